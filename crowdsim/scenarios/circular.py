"""People on a circle who all want to be on its other side, with and without things in it."""

import math
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.maps.shapes import disc
from crowdsim.motion import ModelChoice
from crowdsim.pedestrians import Pedestrians
from crowdsim.recordings.surfaces import Surface
from crowdsim.scenario import OnArrival, Scenario
from crowdsim.scenarios.placement import place, require_count, require_range
from crowdsim.scenarios.walks import draw_walks

MARGIN: Final = 3.0
"""Ground around the circle [m]."""
EXITS: Final = 16
"""Places around planters where people leave: way-finding is computed once for each."""
ARRANGEMENTS: Final = 8
"""Arrangements of planters that are drawn from unless one is asked for."""
PASSAGE: Final = 1.6
"""Least width between planters, and between them and the circle [m]: two people pass."""


def circular_crossing(
    rng: np.random.Generator,
    *,
    pedestrians: int = 20,
    radius: float = 6.0,
    noise: float = 0.5,
    on_arrival: OnArrival = "return",
    model: ModelChoice = "social_force",
) -> Scenario:
    """People start on a circle and walk to the opposite point; the robot crosses it from the south.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 200.
        radius: Radius of the circle [m], 2 to 30.
        noise: Starts are moved by up to this much along x and y [m], 0 to 2.
        on_arrival: `return` (walk back and forth for ever), `stop`, or `respawn` (start again as a
            new person).
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the circle is too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 200)
    require_range("radius", radius, 2.0, 30.0)
    require_range("noise", noise, 0.0, 2.0)
    if on_arrival not in ("return", "stop", "respawn"):
        raise ValueError(f"on_arrival must be return, stop or respawn, got {on_arrival!r}")

    def draw(_: int) -> NDArray[np.float64]:
        angle = rng.uniform(-math.pi, math.pi)
        on_circle = radius * np.array([math.cos(angle), math.sin(angle)])
        return on_circle + rng.uniform(-noise, noise, 2)

    # Goals mirror the starts: keeping off the robot's start keeps them off its goal as well.
    start = place(pedestrians, draw, keep_away=[(0.0, -radius), (0.0, radius)])
    return Scenario(
        name="circular_crossing",
        map=_square(radius + MARGIN),
        pedestrians=Pedestrians.draw(rng, position=start, waypoints=-start, model=model),
        on_arrival=on_arrival,
        robot_start=(0.0, -radius, math.pi / 2.0),
        robot_goal=(0.0, radius),
        time_limit=max(20.0, 4.0 * radius),
    )


def circular_crossing_with_static_obstacles(
    rng: np.random.Generator,
    *,
    pedestrians: int = 12,
    radius: float = 7.0,
    obstacles: int = 5,
    layout: int | None = None,
    model: ModelChoice = "social_force",
) -> Scenario:
    """People cross a circle around planters that stand in it, and so does the robot.

    The name is that of the socialjym benchmark. People start on the circle; who has crossed leaves
    over the edge of the ground and enters again opposite as a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 200.
        radius: Radius of the circle [m], 5 to 30.
        obstacles: Number of planters, 0 to 12; fewer where there is no room.
        layout: Which arrangement of them, 0 to 99,999; None draws one of the first 8.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the circle is too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 200)
    require_range("radius", radius, 5.0, 30.0)
    require_count("obstacles", obstacles, 0, 12)
    if layout is None:
        layout = int(rng.integers(ARRANGEMENTS))
    require_count("layout", layout, 0, 99_999)
    edge = radius + MARGIN

    def through_the_middle() -> NDArray[np.float64]:
        entry = rng.uniform(-math.pi, math.pi)
        beyond = round((entry + math.pi) * EXITS / (2.0 * math.pi)) * 2.0 * math.pi / EXITS
        angle = np.array([entry, beyond])
        return edge * np.column_stack([np.cos(angle), np.sin(angle)])

    on_circle = MARGIN / (2.0 * edge)
    walks = draw_walks(
        rng,
        pedestrians,
        through_the_middle,
        lane=0.0,
        stretch=(on_circle - 0.02, on_circle + 0.02),
        keep_away=[(0.0, -radius), (0.0, radius)],
    )
    return Scenario(
        name="circular_crossing_with_static_obstacles",
        map=_planted(radius, obstacles, layout),
        pedestrians=walks.pedestrians(rng, model),
        on_arrival="respawn",
        entrances=walks.entrances,
        robot_start=(0.0, -radius, math.pi / 2.0),
        robot_goal=(0.0, radius),
        time_limit=max(30.0, 5.0 * radius),
    )


@lru_cache(maxsize=64)
def _square(half: float) -> Map:
    return Map(bounds=(-half, -half, half, half))


@lru_cache(maxsize=64)
def _planted(radius: float, count: int, layout: int) -> Map:
    """Round planters of several sizes inside a circle, two people's width apart."""
    rng = np.random.default_rng(np.random.SeedSequence(layout, spawn_key=(0xC1AC,)))
    planters: list[tuple[float, float, float]] = []
    for _ in range(40 * count):
        size = rng.uniform(0.3, 0.8)
        x, y = rng.uniform(-radius, radius, 2).tolist()
        free = all(math.hypot(x - u, y - v) > size + other + PASSAGE for u, v, other in planters)
        if free and math.hypot(x, y) < radius - size - PASSAGE and len(planters) < count:
            planters.append((x, y, size))
    edge = radius + MARGIN
    surfaces = tuple(part for x, y, size in planters for part in _planter(x, y, size))
    return Map(bounds=(-edge, -edge, edge, edge), surfaces=surfaces)


def _planter(x: float, y: float, radius: float) -> list[tuple[Surface, NDArray[np.float64]]]:
    """A round box with a rim and bushes in it."""
    return [
        (Surface.BUILDING, disc(x, y, radius)),
        (Surface.TREE, disc(x, y, 0.75 * radius)),
    ]
