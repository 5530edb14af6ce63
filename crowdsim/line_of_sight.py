"""Who is hidden behind a wall, told from the few walls that can lie between two people.

The ground is cut into squares. Two who are at most `reach` apart have all walls between them within
half of that of the middle between them, and each square lists the walls that near to its points.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.distance_field import MARGIN, distance_to_segment, interpolate, is_on_grid
from crowdsim.map import Map

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Screens = tuple[FloatArray, IntArray, FloatArray]
"""What the kernels take: the walls of one square after the other `(K, 4)`, px, py, qx, qy [m];
where in them those of each square begin, and those of the one before end `(R, C + 1)`; and the low
corner of the first square `(2,)` [m]."""

SQUARE: Final = 1.0
"""Edge of the squares [m]."""


@lru_cache(maxsize=64)
def screens(world_map: Map, reach: float) -> Screens:
    """Give the walls of a map, listed for looks over at most `reach` [m]; cached per map object."""
    return list_walls(world_map.segments, reach)


def list_walls(segments: FloatArray, reach: float) -> Screens:
    """List the walls `(S, 2, 2)` [m] that may hide who is at most `reach` [m] away."""
    if len(segments) == 0:
        return np.empty((0, 4)), np.zeros((0, 1), dtype=np.int64), np.zeros(2)
    low = segments.min(axis=(0, 1)) - reach / 2
    columns, rows = ((segments.max(axis=(0, 1)) + reach / 2 - low) // SQUARE).astype(int) + 1
    near = _near_squares(segments, low, rows, columns, reach / 2 + SQUARE / math.sqrt(2))
    flat = np.concatenate([[0], np.cumsum(near.sum(axis=2))])  # (R * C + 1,)
    starts = flat[np.arange(rows)[:, None] * columns + np.arange(columns + 1)]
    walls = segments.reshape(-1, 4)[np.nonzero(near)[2]]
    return np.ascontiguousarray(walls), starts, low


@njit(cache=True, error_model="numpy")
def is_hidden(screens: Screens, ax: float, ay: float, bx: float, by: float) -> bool:
    """Whether a wall lies on the straight line from a to b.

    What cannot be walked through hides, water as well: nobody needs to avoid somebody on the
    other side.

    Args:
        screens: the walls, listed for looks at least as long as this one.
        ax: where one is [m].
        ay: likewise.
        bx: where the other is [m].
        by: likewise.
    """
    walls, starts, low = screens
    first, end = listed(starts, low, (ax + bx) / 2, (ay + by) / 2)
    return any_between(walls, first, end, ax, ay, bx, by)


@njit(cache=True, error_model="numpy")
def listed(starts: IntArray, low: FloatArray, x: float, y: float) -> tuple[int, int]:
    """First and end of the walls that can hide two with (x, y) in the middle between them.

    Loops over many ask this and `any_between` themselves: as one function, with the arrays in one
    tuple, it takes ten times as long.
    """
    u, v = (x - low[0]) / SQUARE, (y - low[1]) / SQUARE
    rows, columns = starts.shape
    if not is_on_grid(rows + 1, columns, u, v):
        return 0, 0
    row, column = int(v), int(u)
    return starts[row, column], starts[row, column + 1]


@njit(cache=True, error_model="numpy")
def any_between(
    walls: FloatArray, first: int, end: int, ax: float, ay: float, bx: float, by: float
) -> bool:
    """Whether one of the walls `(K, 4)` from `first` on lies on the line from a to b."""
    for k in range(first, end):
        if meet(ax, ay, bx, by, walls[k, 0], walls[k, 1], walls[k, 2], walls[k, 3]):
            return True
    return False


@njit(cache=True, error_model="numpy")
def meet(
    ax: float, ay: float, bx: float, by: float, px: float, py: float, qx: float, qy: float
) -> bool:
    """Whether the lines from a to b and from p to q touch each other."""
    sides_of_wall = _side(px, py, qx, qy, ax, ay) * _side(px, py, qx, qy, bx, by)
    sides_of_way = _side(ax, ay, bx, by, px, py) * _side(ax, ay, bx, by, qx, qy)
    return (sides_of_wall <= 0) & (sides_of_way <= 0)


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
def _side(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Sign tells on which side of the line a to b a point lies."""
    return (bx - ax) * (y - ay) - (by - ay) * (x - ax)


@njit(cache=True, error_model="numpy")
def _near_squares(
    segments: FloatArray, low: FloatArray, rows: int, columns: int, reach: float
) -> NDArray[np.bool_]:
    """Which segments come within `reach` [m] of the middles of the squares `(R, C, S)`."""
    near = np.empty((rows, columns, len(segments)), dtype=np.bool_)
    for row in range(rows):
        for column in range(columns):
            x, y = low[0] + (column + 0.5) * SQUARE, low[1] + (row + 0.5) * SQUARE
            for k in range(len(segments)):
                near[row, column, k] = distance_to_segment(x, y, segments[k])[0] <= reach
    return near
