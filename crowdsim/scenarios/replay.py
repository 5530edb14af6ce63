"""A recorded real crowd; the robot takes the place of one of its people."""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.maps.photograph import bounds_around, eth_ucy_map
from crowdsim.pedestrians import Pedestrians
from crowdsim.recordings import Recording, find_data, read_obsmat, read_scene
from crowdsim.recordings.eth_ucy import ETH_UCY_SCENES, scene_picture
from crowdsim.scenario import Scenario
from crowdsim.scenarios.placement import ROBOT_CLEARANCE

LEAST_WAY: Final = 6.0
"""The robot replaces somebody whose ends are at least this far apart [m]."""
OBSTACLE_CLEARANCE: Final = 0.5
"""Distance that this person's way keeps from obstacles, so that a wider robot fits [m]."""
RADIUS: Final = 0.25
"""Radius of the recorded people [m]: the annotation has none."""
SLOWEST: Final = 0.6
"""Mean speed that the robot is given time for [m/s]."""


def replay(
    rng: np.random.Generator,
    *,
    scene: str = "crowds_zara01",
    data: str | None = None,
) -> Scenario:
    """Real people walk as they did; the robot starts and ends like one of them, who is left out.

    They do not react to the robot.

    Args:
        rng: Draws which person the robot replaces, among those who walk at least 6 m.
        scene: One of `crowdsim.recordings.eth_ucy.ETH_UCY_SCENES` with a picture.
        data: Folder `eth_ucy` (or the one above); None looks where `find_data` does.

    Raises:
        FileNotFoundError: The data is not there.
        ValueError: Unknown scene, one that no picture fits, or one where nobody walks far enough.
    """
    if scene not in ETH_UCY_SCENES:
        raise ValueError(f"scene must be one of {', '.join(ETH_UCY_SCENES)}, got {scene!r}")
    recording, scene_map, candidates = _load(find_data(data), scene)
    person, first, last = rng.choice(candidates).tolist()
    track = recording.positions[first : last + 1, person]
    others = _without(recording, person)
    return Scenario(
        name="replay",
        map=scene_map,
        pedestrians=_as_pedestrians(others, first),
        robot_start=(*track[0].tolist(), _heading(track)),
        robot_goal=tuple(track[-1].tolist()),
        time_limit=_time_limit(track[0], track[-1]),
        replay=others,
        replay_start=first,
    )


def _time_limit(start: NDArray[np.float64], goal: NDArray[np.float64]) -> float:
    return max(20.0, float(np.ceil(np.linalg.norm(goal - start) / SLOWEST)) + 10.0)


def _heading(track: NDArray[np.float64]) -> float:
    """Direction of the first metre or so of a track (R, 2)."""
    ahead = track[min(3, len(track) - 1)] - track[0]
    return float(np.arctan2(ahead[1], ahead[0]))


@lru_cache(maxsize=16)
def _load(folder: Path, scene: str) -> tuple[Recording, Map, NDArray[np.int64]]:
    """Recording on a regular clock, its map, and the ways that a robot can take over."""
    recording = _read(folder, scene).regular()
    seen = recording.positions[recording.valid]
    scene_map = eth_ucy_map(folder, scene, bounds=bounds_around(seen))
    candidates = _candidates(recording, scene_map)
    if len(candidates) == 0:
        raise ValueError(f"{scene}: expected somebody who walks {LEAST_WAY} m, found nobody")
    return recording, scene_map, candidates


def _read(folder: Path, scene: str) -> Recording:
    """The scene at its true rate: the standard file of biwi_eth runs 1.7 times too fast."""
    if scene != "biwi_eth":
        return read_scene(folder, scene)
    path = folder / "scenes" / scene / "obsmat.txt.gz"
    return read_obsmat(path, picture=scene_picture(folder, scene))


def _candidates(recording: Recording, scene_map: Map) -> NDArray[np.int64]:
    """(C, 3) person, first and last row of every stretch that the robot can take over.

    It runs between the person's first and last sighting clear of obstacles, stays clear of them,
    is at least `LEAST_WAY` long as the crow flies, and begins with nobody close.
    """
    distance = shapely.distance(scene_map.obstacles, shapely.points(recording.positions))  # (T, N)
    clear = recording.valid & (distance >= OBSTACLE_CLEARANCE)
    found = []
    for person in range(len(recording.ids)):
        rows = np.flatnonzero(clear[:, person])
        if len(rows) == 0 or len(rows) != rows[-1] - rows[0] + 1:
            continue
        start, goal = recording.positions[rows[[0, -1]], person]
        if np.linalg.norm(goal - start) >= LEAST_WAY and _alone(recording, rows[0], person):
            found.append((person, rows[0], rows[-1]))
    return np.array(found, dtype=np.int64).reshape(-1, 3)


def _alone(recording: Recording, row: int, person: int) -> bool:
    others = recording.valid[row].copy()
    others[person] = False
    gap = recording.positions[row, others] - recording.positions[row, person]
    return bool((np.linalg.norm(gap, axis=1) >= ROBOT_CLEARANCE).all())


def _without(recording: Recording, person: int) -> Recording:
    return replace(
        recording,
        positions=np.delete(recording.positions, person, axis=1),
        valid=np.delete(recording.valid, person, axis=1),
        ids=np.delete(recording.ids, person),
    )


def _as_pedestrians(recording: Recording, row: int) -> Pedestrians:
    """Everybody recorded, at their first sighting from `row` on, else at their last one."""
    count = len(recording.ids)
    position, goal, speed = np.empty((count, 2)), np.empty((count, 2)), np.empty(count)
    for person in range(count):
        rows = np.flatnonzero(recording.valid[:, person])
        track = recording.positions[rows, person]
        position[person] = track[min(np.searchsorted(rows, row), len(rows) - 1)]
        goal[person] = track[-1]
        length = np.linalg.norm(np.diff(track, axis=0), axis=1).sum()
        speed[person] = length / (max(rows[-1] - rows[0], 1) * recording.dt)
    return Pedestrians(
        position=position,
        velocity=np.zeros((count, 2)),
        waypoints=goal[:, None, :],
        desired_speed=speed,
        relaxation_time=np.full(count, 0.5),
        radius=np.full(count, RADIUS),
        mass=np.full(count, 80.0),
    )
