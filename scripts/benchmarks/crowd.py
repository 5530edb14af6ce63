"""Pedestrian-steps per second of the crowd simulator."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.motion import MODEL_NAMES
from crowdsim.pedestrians import Pedestrians
from crowdsim.scenario import Scenario
from crowdsim.world import World
from scripts.benchmarks.timing import seconds_per_call

COUNTS: Final = (10, 30, 100, 300, 1000)
COLUMN_WIDTH: Final = 1.6
"""Distance of neighbors in a row [m]."""
ROW_HEIGHT: Final = 2.5
"""Distance of rows [m]."""
MARGIN: Final = 2.0
"""Free ground at both ends of the rows [m]."""
SETTLE_STEPS: Final = 100
"""Steps before the clock starts: by then people have met."""


def crowd(seed: int) -> dict[str, list[dict[str, Any]]]:
    """Measure worlds of `COUNTS` people by each model of motion, in the open and between walls.

    A step is `World.step` at its own `physics_dt` and reading back all positions and velocities.

    Returns:
        `crowd`: rows with `n`, `walls`, `model`, `steps_per_s` and `pedestrian_steps_per_s`.
    """
    return {
        "crowd": [
            crowd_row(count, walls, model, seconds_per_call(own_step(count, walls, model, seed)))
            for model in MODEL_NAMES
            for walls in (False, True)
            for count in COUNTS
        ]
    }


def own_step(count: int, walls: bool, model: str, seed: int) -> Callable[[], object]:
    """What is measured: a step of a world whose people have left their rows."""
    world = World(counterflow(count, walls, model, seed), rng=np.random.default_rng(seed))
    for _ in range(SETTLE_STEPS):
        world.step()

    def step() -> object:
        world.step()
        return world.positions, world.velocities

    return step


def crowd_row(count: int, walls: bool, model: str, seconds: float) -> dict[str, Any]:
    """One row of the table, given the time of a step [s]."""
    return {"n": count, "walls": walls, "model": model, **rates(count, seconds)}


def rates(count: int, seconds: float) -> dict[str, Any]:
    """Steps of a crowd, and of its people, per second, given the time of one step [s]."""
    return {
        "steps_per_s": round(1.0 / seconds, 1),
        "pedestrian_steps_per_s": round(count / seconds),
    }


def counterflow(count: int, walls: bool, model: str, seed: int) -> Scenario:
    """People in rows, some walking left and some right for ever, 4 m^2 of ground for each.

    Args:
        count: Number of people.
        walls: Whether there are walls around all and between the rows. They are felt by everybody
            and stand in nobody's way: way-finding is not what is measured.
        model: by which everybody moves.
        seed: Seed of where people stand and how fast they want to walk.
    """
    rng = np.random.default_rng(seed)
    rows = int(np.ceil(np.sqrt(count * COLUMN_WIDTH / ROW_HEIGHT)))
    columns = int(np.ceil(count / rows))
    width, height = columns * COLUMN_WIDTH + 2.0 * MARGIN, rows * ROW_HEIGHT
    index = np.arange(count)
    start = np.stack(
        [
            MARGIN + (index // rows + 0.5) * COLUMN_WIDTH,
            (index % rows + 0.5) * ROW_HEIGHT,
        ],
        axis=1,
    )
    start += rng.uniform(-0.2, 0.2, (count, 2))
    to_right = rng.random(count) < 0.5
    goal = np.stack([np.where(to_right, width - MARGIN, MARGIN), start[:, 1]], axis=1)
    return Scenario(
        name="counterflow",
        map=Map(bounds=(0.0, 0.0, width, height), walls=_walls(width, rows if walls else 0)),
        pedestrians=Pedestrians.draw(rng, position=start, waypoints=goal, model=model),
        on_arrival="return",
        robot_start=(0.5, 0.5, 0.0),
        robot_goal=(width - 0.5, height - 0.5),
    )


def _walls(width: float, rows: int) -> NDArray[np.float64]:
    """(S, 2, 2) segments around and between so many rows; none without rows."""
    if rows == 0:
        return np.empty((0, 2, 2))
    height = rows * ROW_HEIGHT
    sides = [[(x, 0.0), (x, height)] for x in (0.0, width)]
    between = [[(0.0, row * ROW_HEIGHT), (width, row * ROW_HEIGHT)] for row in range(rows + 1)]
    return np.array(sides + between)
