"""What a world begins with: bodies, people first and the robot last, and the people's ways."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.pedestrians import Pedestrians
from crowdsim.robot_body import RobotBody
from crowdsim.routes import Routes, park

if TYPE_CHECKING:
    from crowdsim.scenario import Scenario

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

START_OVERLAP = 0.05
"""Bodies may start inside each other by this much [m], as deep as in a dense crowd."""


def starting_bodies(
    scenario: Scenario, robot: RobotBody | None
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Put the people and the robot, if there is one, into one pool of M bodies.

    Returns:
        bodies: `(M, 4)` x, y, vx, vy [m, m/s]; the robot stands still.
        radius: `(M,)` [m].
        mass: `(M,)` [kg].
        present: `(M,)` who is there; the bodies of the others are parked.

    Raises:
        ValueError: if two bodies start inside each other. Recorded people may: nobody pushes them.
    """
    people = scenario.pedestrians
    rows = [np.concatenate([people.position, people.velocity], axis=1)]
    radius, mass = [people.radius], [people.mass]
    if robot is not None:
        x, y, _ = scenario.robot_start
        rows.append(np.array([[x, y, 0.0, 0.0]]))
        radius.append(np.array([robot.radius]))
        mass.append(np.array([robot.mass]))
    bodies, radii = np.concatenate(rows), np.concatenate(radius)
    present = np.ones(len(bodies), dtype=np.bool_)
    if scenario.entry_times is not None:
        present[: len(people)] = scenario.entry_times == 0
        for person in np.flatnonzero(~present).tolist():
            park(bodies, person)
    if scenario.replay is None:
        names = [*(f"pedestrian {row}" for row in range(len(people))), "the robot"]
        _refuse_overlaps(bodies, radii, present, names)
    return bodies, radii, np.concatenate(mass), present


def draw_awareness(
    rng: np.random.Generator, pedestrians: Pedestrians, robot: RobotBody | None
) -> BoolArray:
    """Draw who notices the robot `(N,)`."""
    if robot is None:
        return pedestrians.notices_robot.copy()
    notices: BoolArray = rng.random(len(pedestrians)) < robot.awareness
    return notices & pedestrians.notices_robot


def planned_routes(scenario: Scenario, dt: float) -> Routes:
    """Plan the ways of a scenario's people, for steps of `dt` [s]."""
    behaviour = scenario.behaviour
    enters_at = None
    if scenario.entry_times is not None:
        enters_at = np.ceil(scenario.entry_times / dt).astype(np.int64)
    return Routes(
        scenario.pedestrians,
        scenario.map,
        scenario.on_arrival,
        scenario.entrances,
        enters_at=enters_at,
        goals_change=behaviour is not None and behaviour.goal_change_rate > 0,
    )


def _refuse_overlaps(
    bodies: FloatArray,
    radius: FloatArray,
    present: BoolArray,
    names: Sequence[str],
) -> None:
    """Raise ValueError if two bodies start deeper than `START_OVERLAP` inside each other."""
    first, second, gap = _narrowest(bodies, radius, present)
    if gap < -START_OVERLAP:
        raise ValueError(
            "expected everybody to start beside everybody else, found "
            f"{_at(names, bodies, first)} and {_at(names, bodies, second)} {-gap:.3f} m inside "
            "each other: move them apart, or make them smaller"
        )


def _at(names: Sequence[str], bodies: FloatArray, row: int) -> str:
    return f"{names[row]} at ({bodies[row, 0]:.3f}, {bodies[row, 1]:.3f})"


@njit(cache=True)
def _narrowest(
    bodies: FloatArray, radius: FloatArray, present: BoolArray
) -> tuple[int, int, float]:
    """Rows of the two bodies whose surfaces are nearest, and the gap between these [m]."""
    first, second, narrowest = 0, 0, np.inf
    for i in range(len(bodies)):
        for j in range(i + 1, len(bodies)):
            dx, dy = bodies[j, 0] - bodies[i, 0], bodies[j, 1] - bodies[i, 1]
            reach = radius[i] + radius[j] + min(narrowest, 0.0)
            if present[i] and present[j] and dx * dx + dy * dy < reach * reach:
                first, second = i, j
                narrowest = math.hypot(dx, dy) - radius[i] - radius[j]
    return first, second, narrowest
