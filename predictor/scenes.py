"""Scenes: the windows of history + future that a recording is cut into."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings import Recording


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """One window of a recording. World frame, metres; N are the people seen in the history.

    Attributes:
        history: (T, N, 2) positions, 0 where not valid.
        valid: (T, N) bool.
        agents: (A,) columns of the people who are there in all frames of history and future.
        future: (F, A, 2) true later positions of the agents.
        recording: The recording that was cut.
    """

    history: NDArray[np.float64]
    valid: NDArray[np.bool_]
    agents: NDArray[np.int64]
    future: NDArray[np.float64]
    recording: Recording


def scenes(
    recording: Recording,
    *,
    history_steps: int,
    forecast_steps: int,
    frame_dt: float = 0.4,
    stride: int = 1,
) -> Iterator[Scene]:
    """Cut a recording into windows of consecutive *listed* frames, all that have agents.

    Args:
        recording: What to cut.
        history_steps: Observed frames T.
        forecast_steps: Later frames F.
        frame_dt: Time between two frames that the caller expects [s].
        stride: Frames between the beginnings of two windows.

    Raises:
        ValueError: The recording has another `dt`.
    """
    if abs(recording.dt - frame_dt) > 1e-6:
        raise ValueError(
            f"{recording.name}: expected frames {frame_dt} s apart, got {recording.dt}"
        )
    steps = history_steps + forecast_steps
    for start in recording.windows(history_steps, forecast_steps, stride):
        scene = _scene(recording, slice(start, start + steps), history_steps)
        if len(scene.agents) > 0:
            yield scene


def _scene(recording: Recording, rows: slice, history_steps: int) -> Scene:
    """Who comes later is cut away, so that nothing of the future reaches the inputs."""
    positions, valid = recording.positions[rows], recording.valid[rows]
    seen = np.flatnonzero(valid[:history_steps].any(axis=0))
    agents = np.flatnonzero(valid[:, seen].all(axis=0))
    return Scene(
        history=positions[:history_steps, seen],
        valid=valid[:history_steps, seen],
        agents=agents,
        future=positions[history_steps:, seen[agents]],
        recording=recording,
    )


def with_last_frames(scene: Scene, frames: int) -> Scene:
    """The scene as it is for who began to look `frames` frames ago: all earlier ones are hidden."""
    shown = np.arange(len(scene.valid)) >= len(scene.valid) - frames
    return replace(scene, valid=scene.valid & shown[:, None])
