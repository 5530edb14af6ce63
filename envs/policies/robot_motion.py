"""How a robot moves in a rollout, in code that compiles.

The frame is the robot's at planning time (origin robot, x ahead, y left), SI units. A control is
(speed, angular speed) for a unicycle and for a bicycle, which turns only as it drives, and a
velocity (x, y) for a holonomic robot.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

STEERING_GAIN = 2.0
"""Angular speed per radian of bearing to the target [1/s]."""

CREEP = 0.5
"""Share of its speed that a bicycle keeps where a unicycle would turn on the spot."""


class Limits(NamedTuple):
    """What the robot can do. A tuple, because compiled code takes it whole.

    Attributes:
        holonomic: Whether the robot moves in any direction; else it drives along its heading.
        speed: Largest speed [m/s].
        angular_speed: Largest angular speed [rad/s]; unused when holonomic.
        acceleration: Largest change of speed (of velocity when holonomic) [m/s^2].
        radius: Radius of its disc [m].
        goal_radius: Distance at which the goal counts as reached [m].
        dt: Duration of a rollout step [s].
        curvature: Largest turn per metre [rad/m]; infinite for who can turn on the spot.
        wheelbase: Distance of the axles of who cannot [m].
    """

    holonomic: bool
    speed: float
    angular_speed: float
    acceleration: float
    radius: float
    goal_radius: float
    dt: float
    curvature: float = math.inf
    wheelbase: float = 1.0


@njit(cache=True)
def encircled(x: Any, y: Any, margin: float, limits: Limits) -> Any:
    """Whether (x, y), robot frame, lies deeper than `margin` [m] within a turning circle.

    Floats give a bool, arrays an array of them; never where the robot can turn on the spot.
    """
    turning = 1.0 / limits.curvature
    return np.hypot(x, np.abs(y) - turning) < turning - margin


@njit(cache=True)
def detour(
    x: float, y: float, heading: float, target: NDArray[np.float64], limits: Limits
) -> float:
    """Way that turning towards the target adds to the straight one [m], about; 0 on the spot.

    What no turn comes near needs a whole loop.
    """
    if limits.curvature == math.inf:
        return 0.0
    dx, dy = target[0] - x, target[1] - y
    along = dx * math.cos(heading) + dy * math.sin(heading)
    across = dy * math.cos(heading) - dx * math.sin(heading)
    turn = abs(math.atan2(across, along))
    if encircled(along, across, limits.goal_radius, limits):
        turn += 2.0 * math.pi
    return turn / limits.curvature


@njit(cache=True)
def steer(
    x: float, y: float, heading: float, target: NDArray[np.float64], limits: Limits
) -> tuple[float, float]:
    """Control that heads for the target: turn, and drive as far as the bearing is ahead.

    A bicycle turns at full speed, which is no wider, and first gets away from what lies within
    its turning circle.
    """
    dx, dy = target[0] - x, target[1] - y
    if limits.holonomic:
        scale = limits.speed / max(math.hypot(dx, dy), 1e-6)
        return dx * scale, dy * scale
    along = dx * math.cos(heading) + dy * math.sin(heading)
    across = dy * math.cos(heading) - dx * math.sin(heading)
    bearing = math.atan2(across, along)
    speed = limits.speed * max(math.cos(bearing), 0.0)
    if limits.curvature < math.inf:
        speed = limits.speed
        if encircled(along, across, 0.5 * limits.goal_radius, limits):
            return speed, 0.0
    most = min(limits.angular_speed, limits.curvature * max(speed, 1e-9))
    return speed, min(max(STEERING_GAIN * bearing, -most), most)


@njit(cache=True)
def feasible(
    a: float, b: float, last_a: float, last_b: float, limits: Limits
) -> tuple[float, float]:
    """The control nearest to (a, b) that the robot can follow after (last_a, last_b)."""
    change = limits.acceleration * limits.dt
    if not limits.holonomic:
        a = min(max(a, last_a - change), last_a + change)
        a = min(max(a, 0.0), limits.speed)
        most = limits.angular_speed
        if limits.curvature < math.inf:
            most = min(most, limits.curvature * a)
        return a, min(max(b, -most), most)
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
