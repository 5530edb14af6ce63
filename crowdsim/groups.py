"""People who walk together: what keeps them near each other, and who belongs to whom.

Moussaïd, Perozo, Garnier, Helbing and Theraulaz 2010 add to the acceleration of group member i

    - beta_1 alpha_i V_i           gaze: who has to turn the head by alpha to see the others, slows
    + q_A beta_2 U_i               cohesion: towards the group's centre, if it is far
    + sum_k q_R beta_3 W_ik        inner repulsion: away from members k who are too near

with V_i the velocity, U_i and W_ik unit vectors towards the centre of the group and away from k,
q_A = 1 farther than (n - 1) / 2 m from the centre, and q_R = 1 nearer than d_0; else they are 0.
"""

import math
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.pedestrians import ALONE

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

GAZE: Final = 4.0
"""beta_1 [1/(s rad)]."""
COHESION: Final = 3.0
"""beta_2 [m/s^2]."""
INNER_REPULSION: Final = 1.0
"""beta_3 [m/s^2]."""
INNER_DISTANCE: Final = 0.8
"""d_0 [m]."""
HALF_VIEW: Final = math.pi / 2
"""phi, how far to the side people see without turning the head [rad]."""
TOGETHER: Final = 5.0
"""Who is farther from a member than this has lost it, and does not wait for it [m]; not in the
paper, where nobody enters or leaves."""

SIZES: Final = (2, 3, 4)
SIZE_SHARES: Final = (0.75, 0.21, 0.04)
"""Share of the groups that have so many members: a Poisson law of mean 0.83 from 2 on, as fitted to
population A of the paper."""


def draw_groups(rng: np.random.Generator, count: int, share: float) -> IntArray:
    """Draw who walks with whom: `(count,)` group numbers, `ALONE` for who walks alone.

    Members have consecutive rows, groups come first.

    Args:
        rng: source of the sizes.
        count: number of people.
        share: share of them who are in groups, met to within one person, 0 to 1.

    Raises:
        ValueError: if the share is not in 0 to 1.
    """
    if not 0 <= share <= 1:
        raise ValueError(f"share of people in groups: expected 0 to 1, found {share}")
    group = np.full(count, ALONE, dtype=np.int64)
    left, number = round(share * count), 0
    first = 0
    while left >= SIZES[0]:
        size = min(int(rng.choice(SIZES, p=SIZE_SHARES)), left)
        size = left if left - size == 1 and left <= SIZES[-1] else size
        group[first : first + size] = number
        first, left, number = first + size, left - size, number + 1
    return group


def abreast(middle: FloatArray, heading: float, size: int, spacing: float = 0.75) -> FloatArray:
    """Places `(size, 2)` side by side around a middle `(2,)` [m], facing the heading [rad]."""
    across = np.array([-math.sin(heading), math.cos(heading)])
    return np.asarray(middle + spacing * (np.arange(size) - (size - 1) / 2)[:, None] * across)


@njit(cache=True)
def add_group_forces(
    bodies: FloatArray,
    present: BoolArray,
    direction: FloatArray,
    group: IntArray,
    total: FloatArray,
) -> None:
    """Add what group members feel from their own group to `total (M, 2)` [m/s^2].

    Args:
        bodies: `(M, 4)` x, y, vx, vy; the N pedestrians first.
        present: `(M,)` who is there.
        direction: `(M, 2)` where they want to go: there they look.
        group: `(N,)` number of the group, `ALONE` for nobody's; members have consecutive rows.
        total: `(M, 2)`, changed in place.
    """
    first = 0
    while first < len(group):
        end = first + 1
        while end < len(group) and group[end] == group[first]:
            end += 1
        if group[first] != ALONE:
            for i in range(first, end):
                if present[i]:
                    ax, ay = group_force(i, first, end, bodies, present, direction)
                    total[i, 0] += ax
                    total[i, 1] += ay
        first = end


@njit(cache=True)
def group_force(
    i: int, first: int, end: int, bodies: FloatArray, present: BoolArray, direction: FloatArray
) -> tuple[float, float]:
    """Acceleration (x, y) [m/s^2] of member i by those in rows `first` to `end` who are with it."""
    others, sum_x, sum_y, ax, ay = 0, 0.0, 0.0, 0.0, 0.0
    for k in range(first, end):
        dx, dy = bodies[k, 0] - bodies[i, 0], bodies[k, 1] - bodies[i, 1]
        distance = math.sqrt(dx * dx + dy * dy)
        if k == i or not present[k] or distance > TOGETHER or distance == 0:
            continue
        others, sum_x, sum_y = others + 1, sum_x + dx, sum_y + dy
        if distance < INNER_DISTANCE:
            ax -= INNER_REPULSION * dx / distance
            ay -= INNER_REPULSION * dy / distance
    if others == 0:
        return 0.0, 0.0
    # The centre of all, i among them, and the centre of the others, whom i looks at.
    centre_x, centre_y = sum_x / (others + 1), sum_y / (others + 1)
    away = math.sqrt(centre_x * centre_x + centre_y * centre_y)
    if away > others / 2:
        ax += COHESION * centre_x / away
        ay += COHESION * centre_y / away
    turn = head_turn(sum_x, sum_y, direction[i, 0], direction[i, 1])
    return ax - GAZE * turn * bodies[i, 2], ay - GAZE * turn * bodies[i, 3]


@njit(cache=True)
def head_turn(dx: float, dy: float, ahead_x: float, ahead_y: float) -> float:
    """Angle [rad] by which the head turns from looking ahead until (dx, dy) comes into view."""
    if (dx == 0 and dy == 0) or (ahead_x == 0 and ahead_y == 0):
        return 0.0
    cross, dot = ahead_x * dy - ahead_y * dx, ahead_x * dx + ahead_y * dy
    return max(0.0, abs(math.atan2(cross, dot)) - HALF_VIEW)
