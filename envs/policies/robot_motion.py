"""How a robot moves in a rollout, in code that compiles.

The frame is the robot's at planning time (origin robot, x ahead, y left), SI units. A control is
(speed, angular speed) for a unicycle, a velocity (x, y) for a holonomic robot.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

STEERING_GAIN = 2.0
"""Angular speed per radian of bearing to the target [1/s]."""


class Limits(NamedTuple):
    """What the robot can do. A tuple, because compiled code takes it whole.

    Attributes:
        holonomic: Whether the robot moves in any direction; else it is a unicycle.
        speed: Largest speed [m/s].
        angular_speed: Largest angular speed [rad/s]; unused when holonomic.
        acceleration: Largest change of speed (of velocity when holonomic) [m/s^2].
        radius: Radius of its disc [m].
        goal_radius: Distance at which the goal counts as reached [m].
        dt: Duration of a rollout step [s].
    """

    holonomic: bool
    speed: float
    angular_speed: float
    acceleration: float
    radius: float
    goal_radius: float
    dt: float


@njit(cache=True)
def steer(
    x: float, y: float, heading: float, target: NDArray[np.float64], limits: Limits
) -> tuple[float, float]:
    """Control that heads for the target: turn, and drive as far as the bearing is ahead."""
    dx, dy = target[0] - x, target[1] - y
    if limits.holonomic:
        scale = limits.speed / max(math.hypot(dx, dy), 1e-6)
        return dx * scale, dy * scale
    along = dx * math.cos(heading) + dy * math.sin(heading)
    across = dy * math.cos(heading) - dx * math.sin(heading)
    bearing = math.atan2(across, along)
    turn = min(max(STEERING_GAIN * bearing, -limits.angular_speed), limits.angular_speed)
    return limits.speed * max(math.cos(bearing), 0.0), turn


@njit(cache=True)
def feasible(
    a: float, b: float, last_a: float, last_b: float, limits: Limits
) -> tuple[float, float]:
    """The control nearest to (a, b) that the robot can follow after (last_a, last_b)."""
    change = limits.acceleration * limits.dt
    if not limits.holonomic:
        a = min(max(a, last_a - change), last_a + change)
        b = min(max(b, -limits.angular_speed), limits.angular_speed)
        return min(max(a, 0.0), limits.speed), b
    da, db = a - last_a, b - last_b
    shrink = min(1.0, change / max(math.hypot(da, db), 1e-9))
    a, b = last_a + da * shrink, last_b + db * shrink
    shrink = min(1.0, limits.speed / max(math.hypot(a, b), 1e-9))
    return a * shrink, b * shrink


@njit(cache=True)
def advance(
    x: float, y: float, heading: float, a: float, b: float, limits: Limits
) -> tuple[float, float, float]:
    """Pose after one step under the control (a, b)."""
    if limits.holonomic:
        return x + a * limits.dt, y + b * limits.dt, heading
    middle = heading + 0.5 * b * limits.dt
    step = a * limits.dt
    return x + step * math.cos(middle), y + step * math.sin(middle), heading + b * limits.dt
