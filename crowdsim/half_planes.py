"""The permitted velocity nearest to a wanted one: a linear programme in two dimensions.

Every constraint is a half-plane, a row (px, py, nx, ny): permitted are the velocities v with
(v - p) . n >= 0, n of unit length. The speed is limited as well. Half-planes are added one by one;
only when the best velocity so far breaks the new one, the best on its border is looked for
(de Berg, Cheong, van Kreveld and Overmars, "Computational Geometry", chapter 4.4). Where nothing
is permitted, the velocity that breaks the worst half-plane least is taken (van den Berg, Guy, Lin
and Manocha 2011, section 5.3).
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

PARALLEL = 1e-9
"""Borders whose directions differ by less than this sine never meet."""


@njit(cache=True)
def nearest_permitted(
    planes: FloatArray, count: int, firm: int, wanted_x: float, wanted_y: float, max_speed: float
) -> tuple[float, float]:
    """Velocity (x, y) [m/s] nearest to the wanted one among those permitted.

    Args:
        planes: `(K, 4)` half-planes, the firm ones first.
        count: how many of the rows to use.
        firm: how many of these must hold even where the others cannot all.
        wanted_x: x of the wanted velocity [m/s].
        wanted_y: its y [m/s].
        max_speed: nobody may be faster [m/s].
    """
    speed = math.hypot(wanted_x, wanted_y)
    scale = max_speed / speed if speed > max_speed else 1.0
    x, y = wanted_x * scale, wanted_y * scale
    for i in range(count):
        if breach(planes[i], x, y) <= 0:
            continue
        found, new_x, new_y = _on_border(planes, i, wanted_x, wanted_y, max_speed, False)
        if not found:
            return _least_breach(planes, count, firm, i, x, y, max_speed)
        x, y = new_x, new_y
    return x, y


@njit(cache=True)
def breach(plane: FloatArray, x: float, y: float) -> float:
    """How far outside a half-plane `(4,)` a velocity lies [m/s]; <= 0 inside."""
    outside: float = (plane[0] - x) * plane[2] + (plane[1] - y) * plane[3]
    return outside


@njit(cache=True)
def _least_breach(
    planes: FloatArray, count: int, firm: int, first: int, x: float, y: float, max_speed: float
) -> tuple[float, float]:
    """Make the largest breach of the half-planes from `first` on as small as can be.

    Whenever one is broken more than the worst so far, go as far into it as can be without breaking
    an earlier one more than it; "no more than it" are half-planes again.
    """
    worst = 0.0
    equal = np.empty((count, 4))
    for i in range(first, count):
        if breach(planes[i], x, y) <= worst:
            continue
        equal[:firm] = planes[:firm]
        used = min(firm, i)
        for j in range(firm, i):
            used += _equally_broken(planes[i], planes[j], equal[used])
        found, new_x, new_y = _deepest(equal, used, planes[i, 2], planes[i, 3], max_speed)
        if found:
            x, y = new_x, new_y
        worst = breach(planes[i], x, y)
    return x, y


@njit(cache=True)
def _equally_broken(plane: FloatArray, earlier: FloatArray, out: FloatArray) -> int:
    """Write the half-plane where `earlier` is broken no more than `plane`; tell whether (0, 1)."""
    # (v - p).n <= (v - q).m is linear in v: (m - n).v >= q.m - p.n
    nx, ny = earlier[2] - plane[2], earlier[3] - plane[3]
    length = math.hypot(nx, ny)
    if length < PARALLEL:
        return 0
    offset = earlier[0] * earlier[2] + earlier[1] * earlier[3]
    offset -= plane[0] * plane[2] + plane[1] * plane[3]
    nx, ny = nx / length, ny / length
    offset /= length
    out[0], out[1], out[2], out[3] = offset * nx, offset * ny, nx, ny
    return 1


@njit(cache=True)
def _deepest(
    planes: FloatArray, count: int, nx: float, ny: float, max_speed: float
) -> tuple[bool, float, float]:
    """Permitted velocity that lies farthest along the unit vector (nx, ny), if there is any."""
    x, y = nx * max_speed, ny * max_speed
    for i in range(count):
        if breach(planes[i], x, y) <= 0:
            continue
        found, x, y = _on_border(planes, i, nx, ny, max_speed, True)
        if not found:
            return False, x, y
    return True, x, y


@njit(cache=True)
def _on_border(
    planes: FloatArray, index: int, aim_x: float, aim_y: float, max_speed: float, far: bool
) -> tuple[bool, float, float]:
    """Best velocity on the border of one half-plane that all earlier ones permit, if any is.

    The best is the nearest to (aim_x, aim_y), or the farthest in that direction if `far`.
    """
    px, py, nx, ny = planes[index]
    dx, dy = ny, -nx
    middle = -(px * dx + py * dy)
    squared = max_speed**2 - (px * nx + py * ny) ** 2
    if squared < 0:
        return False, 0.0, 0.0
    low, high = middle - math.sqrt(squared), middle + math.sqrt(squared)
    for j in range(index):
        along = dx * planes[j, 2] + dy * planes[j, 3]
        missing = breach(planes[j], px, py)
        if abs(along) < PARALLEL:
            if missing > 0:
                return False, 0.0, 0.0
        elif along > 0:
            low = max(low, missing / along)
        else:
            high = min(high, missing / along)
        if low > high:
            return False, 0.0, 0.0
    step = (aim_x - px) * dx + (aim_y - py) * dy
    if far:
        step = high if aim_x * dx + aim_y * dy > 0 else low
    step = min(high, max(low, step))
    return True, px + step * dx, py + step * dy
