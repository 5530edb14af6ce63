"""Writing down what a simulated crowd does."""

import math
from typing import Final

import numpy as np

from crowdsim.recordings import FRAME_DT, Picture, Recording
from crowdsim.render import render_map
from crowdsim.scenario import Scenario
from crowdsim.world import World

SCENE_STEPS: Final = 20
"""Rows of a training scene: somebody must be seen that long."""
PHYSICS_DT: Final = 0.05


def record(
    scenario: Scenario,
    rng: np.random.Generator,
    *,
    name: str,
    seconds: float = 60.0,
    warmup: float = 4.0,
    frame_dt: float = FRAME_DT,
) -> Recording:
    """Run a world without a robot and write down where everybody is.

    Args:
        scenario: Initial conditions.
        rng: Source of the world's draws.
        name: Name of the recording.
        seconds: Length of the recording [s].
        warmup: Time that passes before it begins [s].
        frame_dt: Time between two rows [s], a whole multiple of `PHYSICS_DT`.

    Returns:
        Recording whose `frames` count from 0, with the map as its picture.

    Raises:
        ValueError: The clocks do not fit, or nobody is seen for `SCENE_STEPS` rows on end.
    """
    per_frame = round(frame_dt / PHYSICS_DT)
    if per_frame < 1 or not math.isclose(per_frame * PHYSICS_DT, frame_dt):
        raise ValueError(f"frame_dt must be a multiple of {PHYSICS_DT} s, got {frame_dt}")
    world = World(scenario, rng=rng, physics_dt=PHYSICS_DT)
    for _ in range(round(warmup / PHYSICS_DT)):
        world.step()
    frames, ids, positions = [], [], []
    for frame in range(round(seconds / frame_dt)):
        seen = world.valid
        frames.append(np.full(int(seen.sum()), frame, dtype=np.int64))
        ids.append(world.ids[seen])
        positions.append(world.positions[seen])
        for _ in range(per_frame):
            world.step()
    if sum(len(part) for part in frames) == 0:
        raise ValueError(f"{name}: expected a crowd, found no pedestrian")
    recording = Recording.from_rows(
        name,
        np.concatenate(frames),
        np.concatenate(ids),
        np.concatenate(positions),
        dt=frame_dt,
        picture=Picture(*render_map(scenario.map)),
    ).regular()
    _require_scene(recording)
    return recording


def _require_scene(recording: Recording) -> None:
    for row in recording.windows(SCENE_STEPS - 1, 1):
        if recording.valid[row : row + SCENE_STEPS].all(axis=0).any():
            return
    raise ValueError(
        f"{recording.name}: expected somebody seen for {SCENE_STEPS} rows on end, found nobody"
    )
