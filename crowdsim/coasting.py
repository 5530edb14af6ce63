"""Steps in which nobody touches anything: then bodies just move straight on."""

import math
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.cell_list import near_pairs
from crowdsim.distance_field import distance_at

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

ROUNDING: Final = 1e-6
"""Bodies count as touching from this gap on [m]; the solver, which decides then, knows better."""


@njit(cache=True, error_model="numpy")
def coast(
    bodies: FloatArray,
    present: BoolArray,
    radius: FloatArray,
    first: int,
    parts: FloatArray,
    wall_radius: float,
    wall_grid: FloatArray,
    wall_origin: FloatArray,
    wall_cell: float,
) -> bool:
    """Move bodies straight on for a step, unless anybody touches somebody or a wall on the way.

    It adds up and looks at the same places as the contact solver, and so gives the same bits.

    Args:
        bodies: `(M, 4)` x, y, vx, vy; if nobody does, changed in place from row `first` on.
        present: `(M,)` who is there; the others stand still, far from everybody.
        radius: `(M,)` [m].
        first: first row to move.
        parts: lengths of the parts of the step, after each of which the solver looks [s].
        wall_radius: half the thickness of walls [m].
        wall_grid: `(H, W, 3)` grid of a `DistanceField`.
        wall_origin: `(2,)` its origin [m].
        wall_cell: its spacing [m].

    Returns:
        Whether nobody touched anything, and so they have been moved.
    """
    pairs = near_pairs(bodies, present, _reach(bodies, radius, parts.sum()))
    places = bodies[:, :2].copy()
    for part in parts:
        for i in range(len(bodies)):
            places[i, 0] += bodies[i, 2] * part
            places[i, 1] += bodies[i, 3] * part
        if _any_at_walls(places, radius, wall_radius, wall_grid, wall_origin, wall_cell):
            return False
        if _any_touch(pairs, places, radius):
            return False
    bodies[first:, :2] = places[first:]
    return True


@njit(cache=True, error_model="numpy")
def _reach(bodies: FloatArray, radius: FloatArray, dt: float) -> float:
    """Distance [m] beyond which no two can touch within `dt`."""
    farthest = 0.0
    for i in range(len(bodies)):
        farthest = max(farthest, radius[i] + dt * math.hypot(bodies[i, 2], bodies[i, 3]))
    return 2 * farthest + ROUNDING


@njit(cache=True, error_model="numpy")
def _any_at_walls(
    places: FloatArray,
    radius: FloatArray,
    wall_radius: float,
    wall_grid: FloatArray,
    wall_origin: FloatArray,
    wall_cell: float,
) -> bool:
    """Whether anybody at those places `(M, 2)` may touch a wall.

    Two spacings of the grid away from all walls the distance curves by less than one over a
    spacing, and then what is interpolated is at most an eighth of a spacing too large.
    """
    for i in range(len(places)):
        room = distance_at(wall_grid, wall_origin, wall_cell, places[i, 0], places[i, 1])
        if room <= max(radius[i] + wall_radius + wall_cell / 8 + ROUNDING, 2 * wall_cell):
            return True
    return False


@njit(cache=True, error_model="numpy")
def _any_touch(pairs: IntArray, places: FloatArray, radius: FloatArray) -> bool:
    """Whether any of the pairs `(P, 2)` touch at those places `(M, 2)`."""
    for k in range(len(pairs)):
        a, b = pairs[k, 0], pairs[k, 1]
        dx, dy = places[a, 0] - places[b, 0], places[a, 1] - places[b, 1]
        contact = radius[a] + radius[b] + ROUNDING
        if dx * dx + dy * dy <= contact * contact:
            return True
    return False
