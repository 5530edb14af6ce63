"""The robot as the crowd meets it: a round body that drives itself."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class RobotBody:
    """What the crowd can tell of the robot.

    Attributes:
        radius: [m].
        mass: [kg].
        awareness: share of people who notice and feel it, 0 to 1; all bump into it either way.
        max_acceleration: how hard it drives itself towards the wanted velocity [m/s^2].
    """

    radius: float = 0.3
    mass: float = 50.0
    awareness: float = 1.0
    max_acceleration: float = 5.0

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ValueError: if a size is not positive and finite, or the awareness is no share.
        """
        if not 0 <= self.awareness <= 1:
            raise ValueError(f"robot awareness: expected 0 to 1, found {self.awareness}")
        for name in ("radius", "mass", "max_acceleration"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"robot {name}: expected a finite value > 0, found {value}")


def wanted_velocity(command: Sequence[float] | FloatArray | None) -> tuple[float, float]:
    """Read a command: `(2,)` velocity [m/s], or None for standing still.

    Raises:
        ValueError: if it is not two finite numbers.
    """
    if command is None:
        return 0.0, 0.0
    if len(command) != 2:
        raise ValueError(f"robot_velocity: expected 2 numbers, found {len(command)}")
    vx, vy = float(command[0]), float(command[1])
    if not (math.isfinite(vx) and math.isfinite(vy)):
        raise ValueError(f"robot_velocity: expected finite numbers, found ({vx}, {vy})")
    return vx, vy


@njit(cache=True)
def follow(body: FloatArray, vx: float, vy: float, max_change: float) -> None:
    """Bring the velocity of a body `(4,)` as near to (vx, vy) as `max_change` [m/s] allows.

    Setting it outright would undo what the contact solver did, and push the body through walls.
    """
    dx, dy = vx - body[2], vy - body[3]
    change = math.hypot(dx, dy)
    scale = max_change / change if change > max_change else 1.0
    body[2] += dx * scale
    body[3] += dy * scale
