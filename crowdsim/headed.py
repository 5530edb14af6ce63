"""The headed social force model: people who walk where they face (Farina et al. 2017).

Farina, Fontanelli, Garulli, Giannitrapani and Prattichizzo, "Walking Ahead: The Headed Social
Force Model", PLoS ONE 12(1), give each pedestrian a heading theta with a forward and a sideways
axis, r_f and r_o, and let the forces of the social force model act on them unequally; all terms
per unit of mass:

    a_f = (f_0 + f_e) . r_f                          goal drive f_0, people, walls and whim f_e
    a_o = k_o f_e . r_o - (k_d / m) v_o              sideways steps are small and die away
    theta'' = -k_theta (theta - theta_0) - k_omega theta'
    k_theta = k_lambda m |f_0|,  k_omega = (1 + alpha) sqrt(k_theta / alpha)

so that the heading settles without swinging, the faster the stronger the drive. Here theta_0 is
the direction in which somebody wants to walk, and who stands does not turn; the paper takes the
direction of f_0, which turns round who slows down before the goal.
"""

import math
from dataclasses import astuple, dataclass, fields

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.forces import goal_drive

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
RecordArray = NDArray[np.void]

STANDING = 0.1
"""Who wants to walk at less than this share of the desired speed keeps facing the same way."""


@dataclass(frozen=True, kw_only=True)
class HeadedSocialForce:
    """Parameters of the model; the defaults are those of Farina et al. 2017.

    Attributes:
        sideways: k_o, share of the sideways force that is felt.
        damping: k_d, of sideways steps [kg/s].
        stiffness: k_lambda, how hard the drive turns the heading [rad/(kg m)].
        alpha: ratio of the heading's two rates of settling.
    """

    sideways: float = 1.0
    damping: float = 500.0
    stiffness: float = 0.3
    alpha: float = 3.0

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ValueError: if a parameter is not finite, negative, or `alpha` is zero.
        """
        for name, value in zip((f.name for f in fields(self)), astuple(self), strict=True):
            if not (np.isfinite(value) and value >= 0):
                raise ValueError(f"{name}: expected a finite value >= 0, found {value}")
        if self.alpha == 0:
            raise ValueError("alpha: expected > 0, found 0")

    def record(self) -> RecordArray:
        """Give the parameters as the one-row record array that the kernels take."""
        dtype = [(parameter.name, np.float64) for parameter in fields(self)]
        return np.array([astuple(self)], dtype=dtype)


@njit(cache=True)
def walk_ahead(
    members: IntArray,
    bodies: FloatArray,
    present: BoolArray,
    direction: FloatArray,
    desired_speed: FloatArray,
    relaxation_time: FloatArray,
    mass: FloatArray,
    dt: float,
    model: RecordArray,
    turning: FloatArray,
    acceleration: FloatArray,
) -> None:
    """Turn the members' social-force accelerations into headed ones, and turn their headings.

    Args:
        members: `(H,)` who moves by this model.
        bodies: `(M, 4)` x, y, vx, vy.
        present: `(M,)` who is there.
        direction: `(M, 2)` wanted direction, shorter than 1 for who wants to be slow.
        desired_speed: `(N,)` [m/s].
        relaxation_time: `(N,)` [s].
        mass: `(N,)` [kg].
        dt: length of the step [s].
        model: parameters, as `HeadedSocialForce.record` gives them.
        turning: `(N, 2)` heading [rad] and its rate [rad/s], changed in place; NaN for who is not
            there, who then enters facing the way that he or she walks.
        acceleration: `(M, 2)` of the social force model [m/s^2], changed in place.
    """
    for i in members:
        if not present[i]:
            turning[i] = np.nan
            continue
        if math.isnan(turning[i, 0]):
            turning[i] = _facing(bodies[i], direction[i]), 0.0
        heading = turning[i, 0]
        drive_x = goal_drive(desired_speed[i], direction[i, 0], bodies[i, 2], relaxation_time[i])
        drive_y = goal_drive(desired_speed[i], direction[i, 1], bodies[i, 3], relaxation_time[i])
        acceleration[i] = along_heading(
            drive_x,
            drive_y,
            acceleration[i, 0] - drive_x,
            acceleration[i, 1] - drive_y,
            sideways_speed(heading, bodies[i, 2], bodies[i, 3]),
            heading,
            model[0].sideways,
            model[0].damping / mass[i],
        )
        if math.hypot(direction[i, 0], direction[i, 1]) < STANDING:
            turning[i, 1] = 0.0
            continue
        stiffness = model[0].stiffness * mass[i] * math.hypot(drive_x, drive_y)
        aim = math.atan2(direction[i, 1], direction[i, 0])
        turning[i] = turn(heading, turning[i, 1], aim, stiffness, model[0].alpha, dt)


@njit(cache=True)
def sideways_speed(heading: float, vx: float, vy: float) -> float:
    """Speed to the left of the heading [m/s]."""
    return vy * math.cos(heading) - vx * math.sin(heading)


@njit(cache=True)
def along_heading(
    drive_x: float,
    drive_y: float,
    push_x: float,
    push_y: float,
    to_the_left: float,
    heading: float,
    sideways: float,
    damping: float,
) -> tuple[float, float]:
    """Acceleration (x, y) [m/s^2] of somebody who faces `heading`.

    Args:
        drive_x: x of the goal drive f_0 [m/s^2].
        drive_y: its y [m/s^2].
        push_x: x of all other forces f_e [m/s^2].
        push_y: their y [m/s^2].
        to_the_left: sideways speed v_o [m/s].
        heading: theta [rad].
        sideways: k_o.
        damping: k_d / m [1/s].
    """
    cos, sin = math.cos(heading), math.sin(heading)
    forward = (drive_x + push_x) * cos + (drive_y + push_y) * sin
    left = sideways * (push_y * cos - push_x * sin) - damping * to_the_left
    return forward * cos - left * sin, forward * sin + left * cos


@njit(cache=True)
def turn(
    heading: float, rate: float, aim: float, stiffness: float, alpha: float, dt: float
) -> tuple[float, float]:
    """Heading in -pi..pi [rad] and its rate [rad/s] after `dt`, on the shorter way to `aim`.

    The damping is implicit: no stiffness k_theta and time step make the heading swing up.
    """
    off = wrap(heading - aim)
    damping = (1 + alpha) * math.sqrt(stiffness / alpha)
    rate = (rate - dt * stiffness * off) / (1 + dt * damping)
    return wrap(heading + dt * rate), rate


@njit(cache=True)
def wrap(angle: float) -> float:
    """The same angle in -pi..pi [rad]."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


@njit(cache=True)
def _facing(body: FloatArray, direction: FloatArray) -> float:
    """Direction of motion [rad], or where somebody who stands wants to go."""
    if body[2] != 0 or body[3] != 0:
        return math.atan2(body[3], body[2])
    return math.atan2(direction[1], direction[0])
