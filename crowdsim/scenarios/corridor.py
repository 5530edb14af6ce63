"""A corridor with people walking along it both ways."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.motion import ModelChoice
from crowdsim.pedestrians import Pedestrians
from crowdsim.scenario import Scenario
from crowdsim.scenarios.placement import place, require_count, require_range
from crowdsim.surfaces import Surface

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
    model: ModelChoice = "social_force",
) -> Scenario:
    """People walk along a corridor both ways, each in a lane; the robot goes with one stream.

    Who leaves the corridor enters again at the other end as a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 200.
        length: Length of the corridor [m], 14 to 100.
        width: Distance between its walls [m], 2 to 20.
        oncoming: Share of people who walk against the robot, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the corridor is too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 200)
    require_range("length", length, 14.0, 100.0)
    require_range("width", width, 2.0, 20.0)
    require_range("oncoming", oncoming, 0.0, 1.0, unit="(share)")
    direction = np.where(np.arange(pedestrians) < round(oncoming * pedestrians), -1.0, 1.0)
    half, lane = 0.5 * length, 0.5 * width - SIDE
    robot_x = half - RUN_UP

    def draw(_: int) -> NDArray[np.float64]:
        return np.array([rng.uniform(-half + 0.5, half - 0.5), rng.uniform(-lane, lane)])

    start = place(pedestrians, draw, keep_away=[(-robot_x, 0.0)])
    goal = np.column_stack([direction * half, start[:, 1]])
    return Scenario(
        name="parallel_traffic",
        map=_corridor(length, width),
        pedestrians=Pedestrians.draw(rng, position=start, waypoints=goal, model=model),
        on_arrival="respawn",
        entrances=goal * [-1.0, 1.0],
        robot_start=(-robot_x, 0.0, 0.0),
        robot_goal=(robot_x, 0.0),
        time_limit=max(30.0, 2.5 * length),
    )


@lru_cache(maxsize=64)
def _corridor(length: float, width: float) -> Map:
    end, side = 0.5 * length + 1.0, 0.5 * width
    blocks = [
        (Surface.BUILDING, np.array([(-end, y), (end, y), (end, y + 1.0), (-end, y + 1.0)]))
        for y in (side, -side - 1.0)
    ]
    return Map(bounds=(-end, -side - 1.0, end, side + 1.0), surfaces=tuple(blocks))
