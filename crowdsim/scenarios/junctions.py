"""Corridors that meet: a crossing, a tee, a corner that one cannot look around."""

from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.maps.shapes import box
from crowdsim.motion import ModelChoice
from crowdsim.recordings.surfaces import Surface
from crowdsim.scenario import Scenario
from crowdsim.scenarios.placement import require_count, require_range
from crowdsim.scenarios.walks import draw_walks

FloatArray = NDArray[np.float64]

ARM: Final = 9.0
"""Length of each corridor, from where their middles meet [m]."""
RUN_UP: Final = 3.0
"""Length of corridor behind the robot's start and goal [m]."""
SIDE: Final = 0.5
"""Distance that people's lanes keep from the walls [m]."""

DIRECTIONS: Final[dict[str, tuple[float, float]]] = {
    "south": (0.0, -1.0),
    "east": (1.0, 0.0),
    "north": (0.0, 1.0),
    "west": (-1.0, 0.0),
}
TURNS: Final = {"left": "west", "straight": "north", "right": "east"}
"""Where the robot, which comes from the south, goes to."""


def intersection(
    rng: np.random.Generator,
    *,
    pedestrians: int = 14,
    width: float = 4.0,
    turn: str | None = None,
    groups: float = 0.0,
    model: ModelChoice = "social_force",
) -> Scenario:
    """Two corridors cross; people and the robot go straight on or turn, and see each other late.

    Intersection of Francis et al. 2023, figure 7. Who leaves enters again as a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 100.
        width: Width of the corridors [m], 2 to 8.
        turn: Where the robot goes: left, straight, right; None draws one.
        groups: Share of people who walk in groups, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the corridors are too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 100)
    turn = _drawn(rng, turn, ("left", "straight", "right"))
    arms = tuple(DIRECTIONS)
    return _junction(rng, "intersection", arms, turn, pedestrians, width, groups, model)


def t_intersection(
    rng: np.random.Generator,
    *,
    pedestrians: int = 9,
    width: float = 4.0,
    turn: str | None = None,
    groups: float = 0.0,
    model: ModelChoice = "social_force",
) -> Scenario:
    """A corridor ends at another one; the robot comes out of it and turns into the traffic.

    The intersection of Francis et al. 2023, figure 7, without its fourth arm. Who leaves enters
    again as a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 100.
        width: Width of the corridors [m], 2 to 8.
        turn: Where the robot goes: left, right; None draws one.
        groups: Share of people who walk in groups, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the corridors are too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 100)
    turn = _drawn(rng, turn, ("left", "right"))
    arms = ("south", "east", "west")
    return _junction(rng, "t_intersection", arms, turn, pedestrians, width, groups, model)


def blind_corner(
    rng: np.random.Generator,
    *,
    pedestrians: int = 3,
    width: float = 3.0,
    turn: str | None = None,
    model: ModelChoice = "social_force",
) -> Scenario:
    """People come around a corner that the robot has to turn, unseen until the last moment.

    Blind corner of Francis et al. 2023, figure 7. Who has passed enters again behind the corner as
    a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 60.
        width: Width of both corridors [m], 2 to 6.
        turn: Where the corner leads: left, right; None draws one.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the corridors are too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 60)
    require_range("width", width, 2.0, 6.0)
    turn = _drawn(rng, turn, ("left", "right"))
    return _junction(
        rng,
        "blind_corner",
        ("south", TURNS[turn]),
        turn,
        pedestrians,
        width,
        0.0,
        model,
        way=way_between(TURNS[turn], "south"),
        stretch=(0.0, 0.5),
    )


def way_between(entry: str, exit_: str) -> FloatArray:
    """The middle line from the end of one arm to that of another: (2, 2), or (3, 2) if it turns."""
    start, end = ARM * np.array([DIRECTIONS[entry], DIRECTIONS[exit_]])
    if (start == -end).all():
        return np.array([start, end])
    return np.array([start, np.zeros(2), end])


def _drawn(rng: np.random.Generator, turn: str | None, choices: tuple[str, ...]) -> str:
    if turn is None:
        return str(rng.choice(choices))
    if turn not in choices:
        raise ValueError(f"turn must be one of {', '.join(choices)}, got {turn!r}")
    return turn


def _junction(
    rng: np.random.Generator,
    name: str,
    arms: tuple[str, ...],
    turn: str,
    pedestrians: int,
    width: float,
    groups: float,
    model: ModelChoice,
    *,
    way: FloatArray | None = None,
    stretch: tuple[float, float] = (0.0, 0.8),
) -> Scenario:
    """People on their ways; the robot comes from the south.

    All walk the same `way`, or each from one arm to another.
    """

    def draw_way() -> FloatArray:
        if way is not None:
            return way
        entry, exit_ = rng.choice(arms, 2, replace=False)
        return way_between(entry, exit_)

    require_range("width", width, 2.0, 8.0)
    require_range("groups", groups, 0.0, 1.0, unit="(share)")
    task = ARM - RUN_UP
    goal = task * np.array(DIRECTIONS[TURNS[turn]])
    walks = draw_walks(
        rng,
        pedestrians,
        draw_way,
        lane=0.5 * width - SIDE,
        groups=groups,
        stretch=stretch,
        keep_away=[(0.0, -task)],
    )
    return Scenario(
        name=name,
        map=junction_map(arms, width),
        pedestrians=walks.pedestrians(rng, model),
        on_arrival="respawn",
        entrances=walks.entrances,
        robot_start=(0.0, -task, 0.5 * np.pi),
        robot_goal=(float(goal[0]), float(goal[1])),
        time_limit=45.0,
    )


@lru_cache(maxsize=64)
def junction_map(arms: tuple[str, ...], width: float) -> Map:
    """Corridors from the middle in the directions `arms`; all else is building."""
    half, end = 0.5 * width, ARM + 1.0
    blocks = [box(x, y, x + end - half, y + end - half) for x in (-end, half) for y in (-end, half)]
    for name, (dx, dy) in DIRECTIONS.items():
        if name not in arms:
            corners = np.array([(half, -half), (end, -half), (end, half), (half, half)])
            blocks.append(corners @ np.array([(dx, dy), (-dy, dx)], dtype=np.float64))
    surfaces = tuple((Surface.BUILDING, block) for block in blocks)
    return Map(bounds=(-end, -end, end, end), surfaces=surfaces)
