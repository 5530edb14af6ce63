"""Crossings on open ground: people from all sides, or in streams across the robot's way."""

import math
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.motion import ModelChoice
from crowdsim.scenario import Scenario
from crowdsim.scenarios.placement import require_count, require_range
from crowdsim.scenarios.walks import Walks, draw_walks

FloatArray = NDArray[np.float64]

OPEN_LANE: Final = 1.2
"""Room to either side of a way in the open, so that four walk abreast [m]."""
EDGE: Final = 1.0
"""Ground beyond where people enter and leave [m]."""
RUN_UP: Final = 1.5
"""Distance of the robot's start and goal from the edge of a square [m]."""
BESIDE: Final = 2.5
"""Distance of the robot's start and goal from a stream that it crosses [m]."""
REACH: Final = 8.0
"""Half the length of a stream [m]."""


def random_crossing(
    rng: np.random.Generator,
    *,
    pedestrians: int = 24,
    size: float = 14.0,
    groups: float = 0.0,
    model: ModelChoice = "social_force",
) -> Scenario:
    """People cross a square at all angles, and the robot crosses it with them.

    The square crossing of CrowdNav (Chen et al. 2019) with ways from anywhere on its edge to
    anywhere at least a quarter of the way around. Who has crossed enters again as a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 500.
        size: Side of the square [m], 8 to 60.
        groups: Share of people who walk in groups, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the square is too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 500)
    require_range("size", size, 8.0, 60.0)
    require_range("groups", groups, 0.0, 1.0, unit="(share)")
    half = 0.5 * size
    walks = draw_walks(
        rng,
        pedestrians,
        lambda: across_square(rng, half),
        lane=OPEN_LANE,
        groups=groups,
        keep_away=[(0.0, RUN_UP - half)],
    )
    return crossed_northwards(
        rng, "random_crossing", walks, model, open_ground(half, half), half - RUN_UP
    )


def perpendicular_traffic(
    rng: np.random.Generator,
    *,
    pedestrians: int = 26,
    width: float = 6.0,
    from_left: float = 0.5,
    groups: float = 0.0,
    model: ModelChoice = "social_force",
) -> Scenario:
    """People stream straight across the robot's way, from both sides.

    Perpendicular traffic of Francis et al. 2023, figure 7. Who leaves the stream enters it again
    at its other end as a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 200.
        width: Width of the stream, all of which the robot crosses [m], 3 to 30.
        from_left: Share of people who come from the robot's left, 0 to 1.
        groups: Share of people who walk in groups, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the stream is too narrow for the people.
    """
    require_count("pedestrians", pedestrians, 0, 200)
    require_range("width", width, 3.0, 30.0)
    require_range("from_left", from_left, 0.0, 1.0, unit="(share)")
    require_range("groups", groups, 0.0, 1.0, unit="(share)")

    def draw_way() -> FloatArray:
        end = REACH if rng.random() < from_left else -REACH
        return np.array([(-end, 0.0), (end, 0.0)])

    walks = draw_walks(rng, pedestrians, draw_way, lane=0.5 * width, groups=groups)
    robot_y = 0.5 * width + BESIDE
    ground = open_ground(REACH, robot_y + EDGE)
    return crossed_northwards(rng, "perpendicular_traffic", walks, model, ground, robot_y)


def group_crossing(
    rng: np.random.Generator,
    *,
    pedestrians: int = 16,
    width: float = 8.0,
    groups: float = 1.0,
    model: ModelChoice = "social_force",
) -> Scenario:
    """Groups of two to four walk abreast across the robot's way, which had better not part them.

    Groups keep together by Moussaïd et al. 2010; a robot that cuts through one is what group-aware
    planners are measured by (Katyal et al. 2021). They come from both sides, at an angle.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 200.
        width: Width of the ground that they cross [m], 5 to 30.
        groups: Share of people who walk in groups, 0 to 1.
        model: Motion model of all, or the share of each; only the social forces know groups.

    Raises:
        ValueError: A parameter is out of range, or the ground is too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 200)
    require_range("width", width, 5.0, 30.0)
    require_range("groups", groups, 0.0, 1.0, unit="(share)")
    reach = 0.5 * width - OPEN_LANE

    def draw_way() -> FloatArray:
        side = rng.choice([-1.0, 1.0])
        here, there = rng.uniform(-reach, reach, 2)
        return np.array([(-side * REACH, here), (side * REACH, there)])

    walks = draw_walks(rng, pedestrians, draw_way, lane=OPEN_LANE, groups=groups)
    robot_y = 0.5 * width + BESIDE
    ground = open_ground(REACH, robot_y + EDGE)
    return crossed_northwards(rng, "group_crossing", walks, model, ground, robot_y)


def across_square(rng: np.random.Generator, half: float) -> FloatArray:
    """A straight way (2, 2) between two points of a square's edge, at least a quarter apart."""
    entry = rng.uniform(-math.pi, math.pi)
    angle = entry + np.array([0.0, rng.uniform(0.5, 1.5) * math.pi])
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.asarray(half * ray / np.abs(ray).max(axis=1, keepdims=True))


def crossed_northwards(
    rng: np.random.Generator,
    name: str,
    walks: Walks,
    model: ModelChoice,
    ground: Map,
    robot_y: float,
) -> Scenario:
    """The scenario of a robot that crosses people's walks from (0, -robot_y) to (0, robot_y)."""
    return Scenario(
        name=name,
        map=ground,
        pedestrians=walks.pedestrians(rng, model),
        on_arrival="respawn",
        entrances=walks.entrances,
        robot_start=(0.0, -robot_y, 0.5 * math.pi),
        robot_goal=(0.0, robot_y),
        time_limit=max(30.0, 5.0 * robot_y),
    )


@lru_cache(maxsize=64)
def open_ground(half_x: float, half_y: float) -> Map:
    """Pavement without anything on it that reaches `EDGE` beyond a half width and height [m]."""
    return Map(bounds=(-half_x - EDGE, -half_y - EDGE, half_x + EDGE, half_y + EDGE))
