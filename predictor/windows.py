"""Training windows: cut once into arrays, augmented and given their map crops in batches.

A window keeps the tracks as they are in their world. What is random (which frames are hidden, along
what who stands is seen) is drawn for a batch, so that all runs and seeds share the same windows, in
memory or in the memory-mapped files of `predictor.window_cache`.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings import Recording
from predictor.config import NetworkConfig
from predictor.crops import crop_maps
from predictor.inputs import AgentInputs, inputs_around, seen_along
from predictor.neighbors import nearest
from predictor.scenes import Scene, scenes


@dataclass(frozen=True, kw_only=True, eq=False)
class Tracks:
    """Tracks of M windows, along the axes of their worlds, from where the agent is now [m].

    In double precision, so that training sees bit for bit what serving sees.

    Attributes:
        own: (M, T, 2) float64 history of the agent.
        own_valid: (M, T) bool.
        others: (M, K, T, 2) float64 histories of the nearest people, nearest first.
        others_valid: (M, K, T) bool.
        future: (M, F, 2) float64 true later positions of the agent.
        origin: (M, 2) float64 where the agent is now, in the frame of its world.
        recording: (M,) int64 number of the recording that a window was cut from.
    """

    own: NDArray[np.float64]
    own_valid: NDArray[np.bool_]
    others: NDArray[np.float64]
    others_valid: NDArray[np.bool_]
    future: NDArray[np.float64]
    origin: NDArray[np.float64]
    recording: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.own)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The arrays by their names."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def take(self, rows: NDArray[np.int64]) -> Self:
        """The tracks of some of the windows, in memory."""
        return type(self)(**{name: np.array(array[rows]) for name, array in self.arrays().items()})


@dataclass(frozen=True, kw_only=True, eq=False)
class Windows:
    """M training windows, one for each agent of each scene.

    Attributes:
        tracks: Who walked how.
        images: Picture of each recording, or None.
        homographies: Homography of each recording, or None.
        config: What the network sees.
    """

    tracks: Tracks
    images: list[NDArray[np.uint8] | None]
    homographies: list[NDArray[np.float64] | None]
    config: NetworkConfig

    def __len__(self) -> int:
        return len(self.tracks)

    def batch(
        self,
        rows: NDArray[np.int64],
        stretch: NDArray[np.float64] | None = None,
        hidden: NDArray[np.int64] | None = None,
        undirected: NDArray[np.float64] | None = None,
    ) -> tuple[AgentInputs, NDArray[np.float32]]:
        """Inputs with crops, and futures (B, F, 2) in the agent frame, of some windows.

        Args:
            rows: (B,) which windows.
            stretch: (B, 2) factors on x and y of the agent frame, crop included: -1 on y mirrors,
                equal ones scale. None leaves all as it was.
            hidden: (B,) how many of the first frames are hidden from everyone; None hides none.
            undirected: (B, 2) unit vectors along which who stands is seen; None takes world +x.
        """
        tracks = self.tracks.take(rows)
        if hidden is not None:
            tracks = _without_first(tracks, hidden)
        inputs = inputs_around(
            tracks.own,
            tracks.own_valid,
            tracks.others,
            tracks.others_valid,
            tracks.origin,
            *([] if undirected is None else [undirected]),
        )
        direction = inputs.world_from_agent[:, :2, 0]
        known = np.ones(tracks.future.shape[:2], dtype=np.bool_)
        future = seen_along(tracks.future, direction, known)
        if stretch is not None:
            inputs, future = _stretched(inputs, stretch), future * _over(future, stretch)
        return self._with_map(inputs, tracks.recording), future

    def _with_map(self, inputs: AgentInputs, recording: NDArray[np.int64]) -> AgentInputs:
        pictured = np.array([image is not None for image in self.images])
        crop = crop_maps(
            self.images, self.homographies, recording, inputs.world_from_agent, self.config
        )
        return replace(inputs, crop=crop, crop_valid=pictured[recording])


def _without_first(tracks: Tracks, hidden: NDArray[np.int64]) -> Tracks:
    """Tracks of which the first (B,) frames are not valid."""
    shown = np.arange(tracks.own.shape[1]) >= hidden[:, None]  # (B, T)
    return replace(
        tracks,
        own_valid=tracks.own_valid & shown,
        others_valid=tracks.others_valid & shown[:, None],
    )


def _over(points: NDArray[np.float32], stretch: NDArray[np.float64]) -> NDArray[np.float32]:
    """(B, 2) factors, shaped to multiply (B, ..., 2) points."""
    factors = stretch.astype(np.float32)
    return factors.reshape(len(stretch), *[1] * (points.ndim - 2), 2)


def _stretched(inputs: AgentInputs, stretch: NDArray[np.float64]) -> AgentInputs:
    return replace(
        inputs,
        history=inputs.history * _over(inputs.history, stretch),
        neighbors=inputs.neighbors * _over(inputs.neighbors, stretch),
        last_step=inputs.last_step * _over(inputs.last_step, stretch),
        world_from_agent=inputs.world_from_agent
        / np.concatenate([stretch, np.ones((len(stretch), 1))], axis=1)[:, None],
    )


def extract_windows(
    recordings: list[Recording], config: NetworkConfig, *, stride: int = 1
) -> Windows:
    """Cut recordings into windows, in memory.

    Args:
        recordings: Crowds, `config.frame_dt` apart.
        config: What the network sees.
        stride: Frames between the beginnings of two windows.

    Raises:
        ValueError: There is no window, or a recording has another `dt`.
    """
    parts = list(cut(recordings, config, stride))
    if not parts:
        raise ValueError(nobody_stays(config))
    joined = {
        field.name: np.concatenate([getattr(part, field.name) for part in parts])
        for field in fields(Tracks)
    }
    return on_maps(Tracks(**joined), recordings, config)


def on_maps(tracks: Tracks, recordings: list[Recording], config: NetworkConfig) -> Windows:
    """Windows with the pictures of the recordings that they were cut from."""
    return Windows(
        tracks=tracks,
        images=[recording.map_image for recording in recordings],
        homographies=[recording.pixel_from_world for recording in recordings],
        config=config,
    )


def nobody_stays(config: NetworkConfig) -> str:
    """What to say where there is no window."""
    steps = config.history_steps + config.forecast_steps
    return f"expected people who stay for {steps} frames, found none in the data"


def cut(recordings: list[Recording], config: NetworkConfig, stride: int) -> Iterator[Tracks]:
    """Tracks of the windows of one scene after the other.

    Raises:
        ValueError: A recording has another `dt`.
    """
    for number, recording in enumerate(recordings):
        for scene in scenes(
            recording,
            history_steps=config.history_steps,
            forecast_steps=config.forecast_steps,
            frame_dt=config.frame_dt,
            stride=stride,
        ):
            yield _tracks(scene, number, config.neighbors)


def _tracks(scene: Scene, number: int, neighbors: int) -> Tracks:
    worlds = np.zeros(len(scene.agents), dtype=np.int64)
    history, valid = scene.history[None], scene.valid[None]
    others, others_valid = nearest(history, valid, worlds, scene.agents, neighbors)
    own, own_valid = scene.history[:, scene.agents], scene.valid[:, scene.agents]
    origin = own[-1]  # (A, 2)
    return Tracks(
        own=(own - origin).swapaxes(0, 1),
        own_valid=np.ascontiguousarray(own_valid.T),
        others=np.where(others_valid[..., None], others - origin[:, None, None], 0.0),
        others_valid=others_valid,
        future=(scene.future - origin).swapaxes(0, 1),
        origin=origin,
        recording=np.full(len(origin), number, dtype=np.int64),
    )
