"""What two people do to each other: three laws from the literature, one function each.

All give the acceleration of the one at (dx, dy), as seen from the other, in whose frame it moves
with (vx, vy); the other one feels the opposite. How much either minds is not decided here.
"""

import math
from typing import Final, Literal, get_args

from numba import njit

Interaction = Literal["circular", "elliptical", "moussaid_2009"]
INTERACTIONS: Final[tuple[Interaction, ...]] = get_args(Interaction)
CIRCULAR: Final = INTERACTIONS.index("circular")
ELLIPTICAL: Final = INTERACTIONS.index("elliptical")

VELOCITY_WEIGHT: Final = 2.0
"""Weight of the relative velocity against the direction to the other [s/m] (Moussaïd 2009)."""

TURNING_NARROWNESS: Final = 2.0
"""n: the larger, the narrower the angle in which people step aside [rad/m]."""

BRAKING_NARROWNESS: Final = 3.0
"""n': likewise for the angle in which they brake [rad/m]."""


@njit(cache=True, error_model="numpy")
def repulsion(strength: float, reach: float, gap: float) -> float:
    """Acceleration A exp(-gap / B) of two surfaces that are `gap` apart [m/s^2].

    It is minus the gradient of the potential A B exp(-gap / B).
    """
    return strength * math.exp(-gap / reach)


@njit(cache=True, error_model="numpy")
def circular(
    dx: float,
    dy: float,
    vx: float,
    vy: float,
    contact: float,
    strength: float,
    reach: float,
    horizon: float,
) -> tuple[float, float, float]:
    """Repulsion as if from where the two are going to be nearest, the less the later that is.

    A exp((r - d') / B) (1 - t / T) n', with d' n' the vector between the two at the time t when
    they are nearest if both keep their velocities.

    Args:
        dx: x of one as seen from the other [m].
        dy: its y [m].
        vx: how fast dx changes [m/s].
        vy: how fast dy changes [m/s].
        contact: r, sum of the radii [m].
        strength: A [m/s^2].
        reach: B [m].
        horizon: T [s].

    Returns:
        Acceleration [m/s^2], and the unit vector (x, y) in which it acts.
    """
    urgency = 1.0
    if horizon > 0:
        wait = time_to_closest(dx, dy, vx, vy)
        if wait >= horizon:
            return 0.0, 0.0, 0.0
        urgency = 1 - wait / horizon
        dx, dy = dx + wait * vx, dy + wait * vy
    distance = math.sqrt(dx * dx + dy * dy)
    if distance == 0:
        return 0.0, 0.0, 0.0
    acceleration = urgency * repulsion(strength, reach, distance - contact)
    return acceleration, dx / distance, dy / distance


@njit(cache=True, error_model="numpy")
def elliptical(
    dx: float,
    dy: float,
    vx: float,
    vy: float,
    contact: float,
    strength: float,
    reach: float,
    horizon: float,
) -> tuple[float, float, float]:
    """Minus the gradient of A B exp((r - b) / B), constant on ellipses around the step to come.

    b = sqrt((|d| + |d + v T|)^2 - |v T|^2) / 2 is the semi-minor axis of the ellipse through one
    body whose foci are where the other is now and where it will be, relative to the first, in T
    (Helbing and Johansson 2009, equation 6; Johansson, Helbing and Shukla 2007, "elliptical II").
    There the bodies are points: A is larger by exp(r / B), and r is 0.

    Args and units are those of `circular`; T is the length of the step.

    Returns:
        Acceleration [m/s^2] per length of the vector (x, y) that follows.
    """
    step_x, step_y = vx * horizon, vy * horizon
    ahead_x, ahead_y = dx + step_x, dy + step_y
    now, then = math.sqrt(dx * dx + dy * dy), math.sqrt(ahead_x * ahead_x + ahead_y * ahead_y)
    around = now + then
    axis = math.sqrt(max(0.0, around * around - step_x * step_x - step_y * step_y)) / 2
    if axis == 0 or then == 0:
        return 0.0, 0.0, 0.0
    acceleration = repulsion(strength, reach, axis - contact) * around / (4 * axis)
    return acceleration, dx / now + ahead_x / then, dy / now + ahead_y / then


@njit(cache=True, error_model="numpy")
def moussaid_2009(
    dx: float, dy: float, vx: float, vy: float, strength: float, reach: float
) -> tuple[float, float, float]:
    """Braking along, and stepping aside across, the interaction direction t.

    -A exp(-d / B) (exp(-(n' B theta)^2) t + sign(theta) exp(-(n B theta)^2) n) with the vector
    D = lambda (v_i - v_j) + e_ij, t = D / |D|, B = gamma |D|, n to the left of t, and theta the
    angle from t to e_ij, in which i sees j (Moussaïd, Helbing, Garnier, Johansson, Combe and
    Theraulaz 2009, equations 3 to 6, without their small bias to one side). A was 4.5 m/s^2 and
    gamma 0.35 m; distances are from centre to centre.

    Args:
        dx: x of i as seen from j [m].
        dy: its y [m].
        vx: how fast dx changes [m/s].
        vy: how fast dy changes [m/s].
        strength: A [m/s^2].
        reach: gamma [m].

    Returns:
        Acceleration [m/s^2] per length of the vector (x, y) that follows.
    """
    distance = math.sqrt(dx * dx + dy * dy)
    seen_x, seen_y = -dx / distance, -dy / distance
    along_x, along_y = VELOCITY_WEIGHT * vx + seen_x, VELOCITY_WEIGHT * vy + seen_y
    length = math.sqrt(along_x * along_x + along_y * along_y)
    if length == 0:
        return 0.0, 0.0, 0.0
    along_x, along_y = along_x / length, along_y / length
    cross = along_x * seen_y - along_y * seen_x
    angle = math.atan2(cross, along_x * seen_x + along_y * seen_y)
    spread = reach * length
    brake = math.exp(-((BRAKING_NARROWNESS * spread * angle) ** 2))
    aside = math.exp(-((TURNING_NARROWNESS * spread * angle) ** 2))
    aside = math.copysign(aside, angle) if angle != 0 else 0.0
    acceleration = repulsion(strength, spread, distance)
    return (
        acceleration,
        -brake * along_x + aside * along_y,
        -brake * along_y - aside * along_x,
    )


@njit(cache=True, error_model="numpy")
def time_to_closest(dx: float, dy: float, vx: float, vy: float) -> float:
    """Time [s] until two bodies that keep their velocities are nearest; 0 if they do not approach.

    (dx, dy) is where one is as seen from the other [m], (vx, vy) how fast that changes [m/s].
    """
    approach = -(dx * vx + dy * vy)
    return approach / (vx * vx + vy * vy) if approach > 0 else 0.0


@njit(cache=True, error_model="numpy")
def interact(
    dx: float,
    dy: float,
    vx: float,
    vy: float,
    contact: float,
    law: int,
    strength: float,
    reach: float,
    horizon: float,
) -> tuple[float, float, float]:
    """Give what the law of that index in `INTERACTIONS` gives."""
    if law == CIRCULAR:
        return circular(dx, dy, vx, vy, contact, strength, reach, horizon)
    if law == ELLIPTICAL:
        return elliptical(dx, dy, vx, vy, contact, strength, reach, horizon)
    return moussaid_2009(dx, dy, vx, vy, strength, reach)
