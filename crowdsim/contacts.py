"""Who touches whom, and the last guard against walking through walls."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim import distance_field
from crowdsim.distance_field import distance_to_segments

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@njit(cache=True)
def keep_outside_walls(
    before: FloatArray,
    after: FloatArray,
    first: int,
    walls: FloatArray,
    wall_grid: FloatArray,
    wall_origin: FloatArray,
    wall_cell: float,
) -> int:
    """Write the new state of bodies, but leave those where they were who would cross a wall.

    Args:
        before: `(M, 4)` x, y, vx, vy before the step; changed in place from row `first` on.
        after: `(M, 4)` where the solver moved them.
        first: first row to look at.
        walls: `(S, 2, 2)` segments [m].
        wall_grid: `(H, W, 3)` grid of their `DistanceField`.
        wall_origin: `(2,)` its origin [m].
        wall_cell: its spacing [m].

    Returns:
        How many were held back.
    """
    held = 0
    for i in range(first, len(before)):
        x, y = before[i, 0], before[i, 1]
        moved = math.hypot(after[i, 0] - x, after[i, 1] - y)
        # Off the grid the distance is infinite: no wall is within its margin there.
        distance = distance_field.sample(wall_grid, wall_origin, wall_cell, x, y)[0]
        near = distance <= moved + wall_cell
        if near and _crosses(x, y, after[i, 0], after[i, 1], walls):
            before[i, 2:] = 0.0
            held += 1
        else:
            before[i] = after[i]
    return held


@njit(cache=True)
def robot_clearances(
    bodies: FloatArray, radius: FloatArray, present: BoolArray, walls: FloatArray
) -> tuple[float, float]:
    """Gap [m] between the robot (last row) and the nearest person, and the nearest wall line.

    Both are infinite where there is nothing, and negative where bodies overlap.
    """
    robot = len(bodies) - 1
    x, y = bodies[robot, 0], bodies[robot, 1]
    nearest = np.inf
    for i in range(robot):
        if present[i]:
            distance = math.hypot(bodies[i, 0] - x, bodies[i, 1] - y)
            nearest = min(nearest, distance - radius[i] - radius[robot])
    return nearest, distance_to_segments(x, y, walls) - radius[robot]


@njit(cache=True)
def _crosses(ax: float, ay: float, bx: float, by: float, walls: FloatArray) -> bool:
    """Whether the way from a to b touches the line of any wall."""
    for index in range(len(walls)):
        px, py = walls[index, 0, 0], walls[index, 0, 1]
        qx, qy = walls[index, 1, 0], walls[index, 1, 1]
        sides_of_wall = _side(px, py, qx, qy, ax, ay) * _side(px, py, qx, qy, bx, by)
        sides_of_way = _side(ax, ay, bx, by, px, py) * _side(ax, ay, bx, by, qx, qy)
        if sides_of_wall <= 0 and sides_of_way <= 0:
            return True
    return False


@njit(cache=True)
def _side(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Sign tells on which side of the line a to b a point lies."""
    return (bx - ax) * (y - ay) - (by - ay) * (x - ax)
