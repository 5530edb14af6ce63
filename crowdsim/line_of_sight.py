"""Who is hidden behind a wall, told from the grid of wall distances in a few steps."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.distance_field import MARGIN, distance_at, interpolate, is_on_grid

FloatArray = NDArray[np.float64]

WALL_REACH = 0.6
"""Nearer to a wall than so many grid spacings counts as in it: interpolation rounds off the edge.

At a spacing of 0.1 m that is the thickness that walls have for bodies.
"""


@njit(cache=True, error_model="numpy")
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
    near_a = nearest[0, 0], nearest[0, 1], nearest[0, 2]
    near_b = nearest[1, 0], nearest[1, 1], nearest[1, 2]
    return hides(ax, ay, bx - ax, by - ay, near_a, near_b, wall_grid, wall_origin, wall_cell)


@njit(cache=True, error_model="numpy")
def nearest_walls(
    bodies: FloatArray, wall_grid: FloatArray, wall_origin: FloatArray, wall_cell: float
) -> FloatArray:
    """Distance to the nearest wall [m] and direction away from it (x, y) of each body `(M, 3)`.

    Off the grid, where nobody knows the direction, the distance is the grid's `MARGIN`.
    """
    rows, columns, _ = wall_grid.shape
    nearest = np.zeros((len(bodies), 3))
    for i in range(len(bodies)):
        u = (bodies[i, 0] - wall_origin[0]) / wall_cell
        v = (bodies[i, 1] - wall_origin[1]) / wall_cell
        if is_on_grid(rows, columns, u, v):
            for layer in range(3):
                nearest[i, layer] = interpolate(wall_grid, u, v, layer)
        else:
            nearest[i, 0] = MARGIN if wall_grid.size > 0 else np.inf
    return nearest


@njit(cache=True, error_model="numpy")
def hides(
    x: float,
    y: float,
    dx: float,
    dy: float,
    near_a: tuple[float, float, float],
    near_b: tuple[float, float, float],
    wall_grid: FloatArray,
    wall_origin: FloatArray,
    wall_cell: float,
) -> bool:
    """Whether a wall lies on the line from a at (x, y) to b at (x + dx, y + dy).

    No wall lies within the circles around either that touch the walls nearest to them. Else a look
    at where the line meets the straight continuation of those walls finds most that hide. Else
    it strides along the line as far as no wall can be (sphere tracing, Hart 1996).

    Args as those of `is_hidden`; `near_a` and `near_b` are rows of `nearest_walls`. (They are no
    arrays because this is asked for many pairs: handing an array on costs numba more than the
    answer.)
    """
    distance = math.sqrt(dx * dx + dy * dy)
    end = distance - near_b[0]
    done = near_a[0]
    if done >= end:
        return False
    thickness = WALL_REACH * wall_cell
    for share in (_share_to_wall(near_a, dx, dy), 1 - _share_to_wall(near_b, -dx, -dy)):
        if 0 < share < 1:
            room = distance_at(wall_grid, wall_origin, wall_cell, x + share * dx, y + share * dy)
            if room < thickness:
                return True
    while done < end:
        share = done / distance
        room = distance_at(wall_grid, wall_origin, wall_cell, x + share * dx, y + share * dy)
        if room < thickness:
            return True
        done += max(room - thickness, thickness / 2)
    return False


@njit(cache=True, error_model="numpy")
def _share_to_wall(near: tuple[float, float, float], dx: float, dy: float) -> float:
    """Share of the way (dx, dy) after which it meets the line that the nearest wall lies on."""
    approach = -(dx * near[1] + dy * near[2])
    return near[0] / approach if approach > near[0] else 0.0
