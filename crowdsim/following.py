"""People who keep their distance behind somebody who walks the same way.

Measured in single file, the way d from one person to the next grows with the speed, d = 0.36 m +
1.06 s v (Seyfried, Steffen, Klingsch and Boltes 2005): people leave a gap in time. The
collision-free speed model makes that a law, v <= s / T for the free way s up to the body ahead and
the time gap T (Tordeux, Chraibi and Seyfried 2016, with T = 1 s and whoever overlaps the strip as
wide as a body). Repulsion alone reaches some decimetres, and lets people follow too fast.

Here the gap is the shorter, the farther to the side the one ahead is: in a crowd, unlike in single
file, people walk in each other's gaps. Who keeps it holds back a limited share of the drive, so
that whoever wants much more than there is room for still pushes.
"""

import math
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

NARROWNESS: Final = 3.0
"""Power of 1 - sideways shift / contact distance with which the time gap falls."""


@njit(cache=True, error_model="numpy")
def follow(
    pairs: IntArray,
    bodies: FloatArray,
    radius: FloatArray,
    direction: FloatArray,
    relaxation_time: FloatArray,
    time_gap: float,
    hold_back: float,
    total: FloatArray,
) -> None:
    """Take from accelerations what would bring people too fast behind those ahead of them.

    Args:
        pairs: `(P, 2)` who may be near whom.
        bodies: `(M, 4)` x, y, vx, vy; the N pedestrians first. Nobody follows the robot.
        radius: `(M,)` [m].
        direction: `(M, 2)` wanted direction, of whatever length.
        relaxation_time: `(N,)` [s].
        time_gap: T [s], > 0.
        hold_back: most that anybody gives up [m/s^2].
        total: `(M, 2)` accelerations [m/s^2], changed in place.
    """
    people = len(relaxation_time)
    facing = unit_vectors(direction, people)
    limit = allowed_speeds(pairs, bodies, radius, facing, time_gap)
    for i in range(people):
        ex, ey = facing[i, 0], facing[i, 1]
        speed = bodies[i, 2] * ex + bodies[i, 3] * ey
        wanted = total[i, 0] * ex + total[i, 1] * ey
        brake = braking(wanted, speed, limit[i], relaxation_time[i], hold_back)
        total[i, 0] -= brake * ex
        total[i, 1] -= brake * ey


@njit(cache=True, error_model="numpy")
def allowed_speeds(
    pairs: IntArray,
    bodies: FloatArray,
    radius: FloatArray,
    facing: FloatArray,
    time_gap: float,
) -> FloatArray:
    """Give the least `allowed_speed` `(N,)` [m/s] behind anybody who walks the same way.

    Two walk the same way if the angle between their wanted directions is below a right one; who
    wants to stand is not followed but repelled. Where ways meet, as before a door, each of two may
    have the other ahead: then only the one follows who has the other farther ahead, else both would
    wait. `facing (N, 2)` holds unit vectors, or 0; the other arguments are those of `follow`.
    """
    people = len(facing)
    least = np.full(people, np.inf)
    for k in range(len(pairs)):
        a, b = pairs[k, 0], pairs[k, 1]
        if max(a, b) >= people:
            continue
        ax, ay, bx, by = facing[a, 0], facing[a, 1], facing[b, 0], facing[b, 1]
        if ax * bx + ay * by <= 0:
            continue
        dx, dy = bodies[b, 0] - bodies[a, 0], bodies[b, 1] - bodies[a, 1]
        contact = radius[a] + radius[b]
        if dx * ax + dy * ay > -dx * bx - dy * by:
            least[a] = min(least[a], allowed_speed(dx, dy, ax, ay, contact, time_gap))
        else:
            least[b] = min(least[b], allowed_speed(-dx, -dy, bx, by, contact, time_gap))
    return least


@njit(cache=True, error_model="numpy")
def allowed_speed(
    dx: float, dy: float, ex: float, ey: float, contact: float, time_gap: float
) -> float:
    """Speed s / T [m/s] behind a body, with s the free way straight on until it is touched.

    T falls from the time gap, for a body straight ahead, to 0 for one that is just passed.

    Args:
        dx: x of the body ahead as seen from the one behind [m].
        dy: its y [m].
        ex: x of the unit vector in which the one behind wants to walk.
        ey: its y.
        contact: sum of the radii [m].
        time_gap: for a body straight ahead [s].

    Returns:
        Infinity if nobody is touched that way.
    """
    ahead, aside = dx * ex + dy * ey, abs(dx * ey - dy * ex)
    if ahead <= 0 or aside >= contact:
        return math.inf
    free = max(0.0, ahead - math.sqrt(contact * contact - aside * aside))
    gap: float = time_gap * (1 - aside / contact) ** NARROWNESS
    return free / gap


@njit(cache=True, error_model="numpy")
def braking(
    wanted: float, speed: float, limit: float, relaxation_time: float, hold_back: float
) -> float:
    """What to take from the acceleration `wanted`, so that `speed` does not pass `limit` [m/s^2].

    As with the goal drive, the difference to the limit is made up in the relaxation time [s].
    """
    return min(max(wanted - (limit - speed) / relaxation_time, 0.0), hold_back)


@njit(cache=True, error_model="numpy")
def unit_vectors(vectors: FloatArray, count: int) -> FloatArray:
    """Unit vectors `(count, 2)` along the first so many rows; 0 stays 0."""
    units = np.zeros((count, 2))
    for i in range(count):
        length = math.hypot(vectors[i, 0], vectors[i, 1])
        if length > 0:
            units[i, 0], units[i, 1] = vectors[i, 0] / length, vectors[i, 1] / length
    return units
