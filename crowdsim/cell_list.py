"""Sorting bodies into square cells, so that finding neighbors costs linear time."""

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

PAIRS_PER_BODY: Final = 8
"""Pairs that room is made for at first; where people stand closer, listing them starts anew."""

FEW: Final = 24
"""Among so many bodies, looking at everybody with everybody takes less time than sorting them."""


@njit(cache=True, error_model="numpy")
def near_pairs(bodies: FloatArray, present: BoolArray, reach: float) -> IntArray:
    """List the pairs `(P, 2)` of present bodies nearer to each other than `reach` [m], each once.

    Two at the very same place are no pair: there is no direction from one to the other.

    Args:
        bodies: `(M, >=2)` x and y first [m].
        present: `(M,)` which of them to look at.
        reach: [m].
    """
    if len(bodies) <= FEW:
        return _all_near_pairs(bodies, present, reach)
    members, starts, columns = build_cell_list(bodies, present, reach)
    pairs = np.empty((PAIRS_PER_BODY * len(members) + 1, 2), dtype=np.int64)
    count = _list_pairs(bodies, members, starts, columns, reach, pairs)
    if count >= len(pairs):
        pairs = np.empty((count + 1, 2), dtype=np.int64)
        _list_pairs(bodies, members, starts, columns, reach, pairs)
    return pairs[:count]


@njit(cache=True)
def build_cell_list(
    bodies: FloatArray, present: BoolArray, size: float
) -> tuple[IntArray, IntArray, int]:
    """Sort the present bodies by cell.

    The cells may come out larger than asked for, so that a few people far away from each other
    do not need more cells than there are bodies.

    Args:
        bodies: `(M, >=2)` x and y first [m].
        present: `(M,)` which of them to sort.
        size: least edge of a cell [m].

    Returns:
        members: indices of the present bodies, cell by cell, row by row, stable in each cell.
        starts: `(rows * columns + 1,)` where each cell begins in `members`.
        columns: cells per row.
    """
    count, low_x, low_y, high_x, high_y = _extent(bodies, present)
    rows, columns = _shape(high_x - low_x, high_y - low_y, size)
    while rows * columns > 4 * count + 16:
        size *= 2
        rows, columns = _shape(high_x - low_x, high_y - low_y, size)
    cells = np.empty(len(bodies), dtype=np.int64)
    starts = np.zeros(rows * columns + 2, dtype=np.int64)
    for body in range(len(bodies)):
        if present[body]:
            row = int((bodies[body, 1] - low_y) / size)
            cells[body] = row * columns + int((bodies[body, 0] - low_x) / size)
            starts[cells[body] + 2] += 1
    starts = np.cumsum(starts)
    members = np.empty(count, dtype=np.int64)
    for body in range(len(bodies)):
        if present[body]:
            members[starts[cells[body] + 1]] = body
            starts[cells[body] + 1] += 1
    return members, starts[:-1], columns


@njit(cache=True)
def _extent(bodies: FloatArray, present: BoolArray) -> tuple[int, float, float, float, float]:
    """Count the present bodies and bound them: count, low x, low y, high x, high y."""
    count, low_x, low_y, high_x, high_y = 0, np.inf, np.inf, -np.inf, -np.inf
    for body in range(len(bodies)):
        if present[body]:
            count += 1
            low_x, high_x = min(low_x, bodies[body, 0]), max(high_x, bodies[body, 0])
            low_y, high_y = min(low_y, bodies[body, 1]), max(high_y, bodies[body, 1])
    if count == 0:
        return 0, 0.0, 0.0, 0.0, 0.0
    return count, low_x, low_y, high_x, high_y


@njit(cache=True)
def _shape(width: float, height: float, size: float) -> tuple[int, int]:
    return int(height / size) + 1, int(width / size) + 1


@njit(cache=True, error_model="numpy")
def _all_near_pairs(bodies: FloatArray, present: BoolArray, reach: float) -> IntArray:
    """Do what `near_pairs` says without cells."""
    pairs = np.empty((len(bodies) * len(bodies) // 2 + 1, 2), dtype=np.int64)
    count = 0
    for a in range(len(bodies)):
        for b in range(a + 1, len(bodies)):
            dx, dy = bodies[a, 0] - bodies[b, 0], bodies[a, 1] - bodies[b, 1]
            squared = dx * dx + dy * dy
            pairs[count, 0], pairs[count, 1] = a, b
            count += present[a] & present[b] & (squared > 0) & (squared < reach * reach)
    return pairs[:count]


@njit(cache=True, error_model="numpy")
def _list_pairs(
    bodies: FloatArray,
    members: IntArray,
    starts: IntArray,
    columns: int,
    reach: float,
    pairs: IntArray,
) -> int:
    """Write down what `near_pairs` says, as far as there is room; gives how many pairs there are.

    A body is paired with those after it in its own cell, and with those of the cells to the right
    and above, which follow each other in `members`. Every candidate is written down, in a row that
    the next one takes unless it was a pair: the processor cannot guess which ones are.
    """
    count, last_row, end = 0, len(pairs) - 1, len(starts) - 1
    x, y = bodies[members, 0], bodies[members, 1]
    for cell in range(end):
        left, right = min(cell % columns, 1), min(columns - 1 - cell % columns, 1)
        above = cell + columns
        beside = starts[cell + right + 1]
        row_above = starts[min(above - left, end)], starts[min(above + right + 1, end)]
        for a in range(starts[cell], starts[cell + 1]):
            for first, last in ((a + 1, beside), row_above):
                for b in range(first, last):
                    dx, dy = x[a] - x[b], y[a] - y[b]
                    squared = dx * dx + dy * dy
                    row = min(count, last_row)
                    pairs[row, 0], pairs[row, 1] = members[a], members[b]
                    count += (squared > 0) & (squared < reach * reach)
    return count
