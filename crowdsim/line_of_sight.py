"""Who is hidden behind a wall, told from the grid of wall distances in a few steps."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.distance_field import MARGIN, distance_at, sample

FloatArray = NDArray[np.float64]

WALL_REACH = 0.6
"""Nearer to a wall than so many grid spacings counts as in it: interpolation rounds off the edge.

At a spacing of 0.1 m that is the thickness that walls have for bodies.
"""


@njit(cache=True)
def is_hidden(
    wall_grid: FloatArray,
    wall_origin: FloatArray,
    wall_cell: float,
    ax: float,
    ay: float,
    bx: float,
    by: float,
) -> bool:
    """Whether a wall lies on the straight line from a to b.

    What cannot be walked through hides, water as well: nobody needs to avoid somebody on the
    other side.

    Args:
        wall_grid: `(H, W, 3)` grid of a `DistanceField`.
        wall_origin: `(2,)` its origin [m].
        wall_cell: its spacing [m].
        ax: where one is [m].
        ay: likewise.
        bx: where the other is [m].
        by: likewise.
    """
    ends = np.array([[ax, ay], [bx, by]])
    nearest = nearest_walls(ends, wall_grid, wall_origin, wall_cell)
    return is_hidden_from(0, 1, ends, nearest, wall_grid, wall_origin, wall_cell)


@njit(cache=True)
def nearest_walls(
    bodies: FloatArray, wall_grid: FloatArray, wall_origin: FloatArray, wall_cell: float
) -> FloatArray:
    """Distance to the nearest wall [m] and direction away from it (x, y) of each body `(M, 3)`.

    Off the grid, where nobody knows the direction, the distance is the grid's `MARGIN`.
    """
    nearest = np.empty((len(bodies), 3))
    for i in range(len(bodies)):
        nearest[i] = sample(wall_grid, wall_origin, wall_cell, bodies[i, 0], bodies[i, 1])
        if wall_grid.size > 0 and nearest[i, 0] == np.inf:
            nearest[i, 0] = MARGIN
    return nearest


@njit(cache=True)
def is_hidden_from(
    a: int,
    b: int,
    bodies: FloatArray,
    nearest: FloatArray,
    wall_grid: FloatArray,
    wall_origin: FloatArray,
    wall_cell: float,
) -> bool:
    """Do what `is_hidden` says for two bodies whose nearest walls `(M, 3)` are known.

    No wall lies within the circles around either that touch the walls nearest to them. Else a look
    at where the line meets the straight continuation of those walls finds most that hide. Else
    it strides along the line as far as no wall can be (sphere tracing, Hart 1996).
    """
    x, y = bodies[a, 0], bodies[a, 1]
    dx, dy = bodies[b, 0] - x, bodies[b, 1] - y
    distance = math.sqrt(dx * dx + dy * dy)
    end = distance - nearest[b, 0]
    done = nearest[a, 0]
    if done >= end:
        return False
    thickness = WALL_REACH * wall_cell
    from_a = _share_to_wall(nearest[a], dx, dy)
    from_b = 1 - _share_to_wall(nearest[b], -dx, -dy)
    for share in (from_a, from_b):
        if 0 < share < 1:
            place = x + share * dx, y + share * dy
            if distance_at(wall_grid, wall_origin, wall_cell, *place) < thickness:
                return True
    while done < end:
        share = done / distance
        room = distance_at(wall_grid, wall_origin, wall_cell, x + share * dx, y + share * dy)
        if room < thickness:
            return True
        done += max(room - thickness, thickness / 2)
    return False


@njit(cache=True)
def _share_to_wall(nearest: FloatArray, dx: float, dy: float) -> float:
    """Share of the way (dx, dy) after which it meets the line that the nearest wall lies on."""
    approach = -(dx * nearest[1] + dy * nearest[2])
    return nearest[0] / approach if approach > nearest[0] else 0.0
