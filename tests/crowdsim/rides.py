"""A robot that knows the way and minds nobody: what a scenario does to it is the scenario's own."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crowdsim.robot_body import RobotBody
from crowdsim.scenario import Scenario
from crowdsim.wayfinding import geodesic_field
from crowdsim.world import World

FloatArray = NDArray[np.float64]

PERIOD = 4
"""Steps between two rows."""


@dataclass(frozen=True, kw_only=True)
class Ride:
    """What was where, one row every 0.2 s.

    Attributes:
        robot: (T, 2) positions [m].
        positions: (T, N, 2) of the people [m].
        velocities: (T, N, 2) of the people [m/s].
        valid: (T, N) who is there.
        ids: (T, N) who it is.
        clearance: (T,) between the robot's surface and the nearest person's [m].
        arrived: Whether it got to its goal.
    """

    robot: FloatArray
    positions: FloatArray
    velocities: FloatArray
    valid: NDArray[np.bool_]
    ids: NDArray[np.int64]
    clearance: FloatArray
    arrived: bool


def ride(
    scenario: Scenario, *, speed: float = 1.0, by_way_of: Sequence[tuple[float, float]] = ()
) -> Ride:
    """Let it drive to the goal and stop there, or until the time is over.

    Args:
        scenario: Where.
        speed: Of the robot [m/s]; 0 stands at the start until the time is over.
        by_way_of: Points that it drives to before the goal [m].
    """
    world = World(scenario, rng=np.random.default_rng(0), robot=RobotBody())
    goals = [np.array(point) for point in (*by_way_of, scenario.robot_goal)]
    rows: list[tuple[object, ...]] = []
    while world.time < scenario.time_limit and goals:
        ahead = geodesic_field(scenario.map, goals[0], 0.4).direction(world.robot_position)
        for _ in range(PERIOD):
            world.step(speed * ahead)
        rows.append(
            (
                world.robot_position,
                world.positions,
                world.velocities,
                world.valid,
                world.ids,
                world.robot_clearance,
            )
        )
        if np.linalg.norm(world.robot_position - goals[0]) < 0.4:
            del goals[0]
    names = ("robot", "positions", "velocities", "valid", "ids", "clearance")
    columns = (np.array(column) for column in zip(*rows, strict=True))
    return Ride(**dict(zip(names, columns, strict=True)), arrived=not goals)
