"""Who touches whom, and the last guard against walking through walls."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.bodies import WALL_RADIUS
from crowdsim.distance_field import distance_to_segments
from crowdsim.line_of_sight import Screens, any_between, listed

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@njit(cache=True, error_model="numpy")
def keep_outside_walls(before: FloatArray, after: FloatArray, first: int, screens: Screens) -> int:
    """Write the new state of bodies, but leave those where they were who would cross a wall.

    Args:
        before: `(M, 4)` x, y, vx, vy before the step; changed in place from row `first` on.
        after: `(M, 4)` where the solver moved them.
        first: first row to look at.
        screens: the walls, listed for ways longer than those of a step.

    Returns:
        How many were held back.
    """
    walls, starts, low = screens
    held = 0
    for i in range(first, len(before)):
        from_x, from_y, x, y = before[i, 0], before[i, 1], after[i, 0], after[i, 1]
        first_wall, end = listed(starts, low, (from_x + x) / 2, (from_y + y) / 2)
        if any_between(walls, first_wall, end, from_x, from_y, x, y):
            before[i, 2] = before[i, 3] = 0.0
            held += 1
        else:
            before[i, 0], before[i, 1] = x, y
            before[i, 2], before[i, 3] = after[i, 2], after[i, 3]
    return held


@njit(cache=True, error_model="numpy")
def robot_clearances(
    bodies: FloatArray, radius: FloatArray, present: BoolArray, walls: FloatArray
) -> tuple[float, float]:
    """Gap [m] between the robot (last row) and the nearest person, and the nearest wall's surface.

    Both are infinite where there is nothing, and negative where bodies overlap.
    """
    robot = len(bodies) - 1
    x, y = bodies[robot, 0], bodies[robot, 1]
    nearest = np.inf
    for i in range(robot):
        if present[i]:
            distance = math.hypot(bodies[i, 0] - x, bodies[i, 1] - y)
            nearest = min(nearest, distance - radius[i] - radius[robot])
    return nearest, distance_to_segments(x, y, walls) - radius[robot] - WALL_RADIUS
