"""Corridors with people who walk along them both ways."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from crowdsim.groups import draw_groups
from crowdsim.map import Map
from crowdsim.motion import ModelChoice
from crowdsim.pedestrians import Pedestrians
from crowdsim.recordings.surfaces import Surface
from crowdsim.scenario import Scenario
from crowdsim.scenarios.placement import place_parties, require_count, require_range
from crowdsim.scenarios.walks import formation

SIDE = 0.5
"""Distance that people's lanes keep from the corridor's walls [m]."""
RUN_UP = 4.0
"""Length of corridor behind the robot's start and goal [m]."""


def parallel_traffic(
    rng: np.random.Generator,
    *,
    pedestrians: int = 20,
    length: float = 24.0,
    width: float = 5.0,
    oncoming: float = 0.5,
    groups: float = 0.0,
    model: ModelChoice = "social_force",
) -> Scenario:
    """People walk along a corridor both ways, each in a lane; the robot goes with one stream.

    Parallel traffic of Francis et al. 2023, figure 7. Who leaves the corridor enters again at the
    other end as a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 200.
        length: Length of the corridor [m], 14 to 100.
        width: Distance between its walls [m], 2 to 20.
        oncoming: Share of people who walk against the robot, 0 to 1.
        groups: Share of people who walk in groups, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the corridor is too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 200)
    require_range("length", length, 14.0, 100.0)
    require_range("width", width, 2.0, 20.0)
    require_range("oncoming", oncoming, 0.0, 1.0, unit="(share)")
    require_range("groups", groups, 0.0, 1.0, unit="(share)")
    return _two_way(rng, "parallel_traffic", pedestrians, length, width, oncoming, groups, model)


def narrow_hallway(
    rng: np.random.Generator,
    *,
    pedestrians: int = 2,
    length: float = 18.0,
    width: float = 1.8,
    oncoming: float = 1.0,
    model: ModelChoice = "social_force",
) -> Scenario:
    """People come along a hallway in which they and the robot can only just pass.

    Narrow hallway of Francis et al. 2023, figure 7. Who leaves it enters again at the other end as
    a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 30.
        length: Length of the hallway [m], 16 to 100.
        width: Distance between its walls [m], 1.5 to 2.4.
        oncoming: Share of people who walk against the robot, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the hallway is too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 30)
    require_range("length", length, 16.0, 100.0)
    require_range("width", width, 1.5, 2.4)
    require_range("oncoming", oncoming, 0.0, 1.0, unit="(share)")
    return _two_way(rng, "narrow_hallway", pedestrians, length, width, oncoming, 0.0, model)


def _two_way(
    rng: np.random.Generator,
    name: str,
    pedestrians: int,
    length: float,
    width: float,
    oncoming: float,
    groups: float,
    model: ModelChoice,
) -> Scenario:
    """Streams along a corridor, the first rows against the robot, which walks along its middle."""
    group = draw_groups(rng, pedestrians, groups)
    direction = np.where(np.arange(pedestrians) < round(oncoming * pedestrians), -1.0, 1.0)
    half, lane = 0.5 * length, 0.5 * width - SIDE
    robot_x = half - RUN_UP

    def draw(first: int, size: int) -> NDArray[np.float64]:
        direction[first : first + size] = direction[first]
        behind, across = formation(size, lane)
        reach, end = lane - across.max(), half - 0.5 - behind.max()
        x, y = rng.uniform(-end, end), rng.uniform(-reach, reach)
        return np.column_stack([x - direction[first] * behind, y + across])

    start = place_parties(group, draw, keep_away=[(-robot_x, 0.0)])
    goal = np.column_stack([direction * half, start[:, 1]])
    return Scenario(
        name=name,
        map=corridor_map(length, width),
        pedestrians=Pedestrians.draw(rng, position=start, waypoints=goal, model=model, group=group),
        on_arrival="respawn",
        entrances=goal * [-1.0, 1.0],
        robot_start=(-robot_x, 0.0, 0.0),
        robot_goal=(robot_x, 0.0),
        time_limit=max(30.0, 2.5 * length),
    )


@lru_cache(maxsize=64)
def corridor_map(length: float, width: float) -> Map:
    """Two walls along x, so far apart and so long that people enter and leave between them."""
    end, side = 0.5 * length + 1.0, 0.5 * width
    blocks = [
        (Surface.BUILDING, np.array([(-end, y), (end, y), (end, y + 1.0), (-end, y + 1.0)]))
        for y in (side, -side - 1.0)
    ]
    return Map(bounds=(-end, -side - 1.0, end, side + 1.0), surfaces=tuple(blocks))
