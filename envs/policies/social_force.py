"""The robot as one more pedestrian of the crowd simulator's social force model."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.forces import SocialForce, sight
from crowdsim.interactions import circular, repulsion
from envs.config import CrowdNavConfig
from envs.policies.robot_motion import Limits
from envs.policies.velocities import Surroundings, VelocityPolicy

RELAXATION_TIME = 0.5
"""Time in which the wanted velocity is taken up [s] (Helbing and Molnár 1995)."""


class SocialForcePolicy(VelocityPolicy):
    """Moves by the forces that people feel (`crowdsim.forces`), with the same parameters.

    It takes people where they are going to be nearest if they keep their velocities; forecasts
    it has no use for.
    """

    name = "social_force"

    def __init__(self, config: CrowdNavConfig) -> None:
        super().__init__(config)
        self._model = SocialForce().record()

    def velocity(self, around: Surroundings) -> tuple[float, float]:
        """Where the forces lead within a step; see `VelocityPolicy.velocity`."""
        x, y = next_velocity(around, self._limits, self._model)
        return float(x), float(y)


@njit(cache=True)
def next_velocity(
    around: Surroundings, limits: Limits, model: NDArray[np.void]
) -> tuple[float, float]:
    """Velocity (x, y) after one step under the goal's pull and the repulsion of people and wall.

    Args:
        around: What the robot has around it; the nearest point of a wall is felt.
        limits: What it can do.
        model: Parameters, as `SocialForce.record` gives them.
    """
    own, wanted, walls = around.velocity, around.wanted, around.walls
    ax = (wanted[0] - own[0]) / RELAXATION_TIME
    ay = (wanted[1] - own[1]) / RELAXATION_TIME
    strength, reach, ahead = model[0].repulsion, model[0].repulsion_range, model[0].anticipation
    for k in range(len(around.people)):
        x, y = around.people[k]
        vx, vy = own[0] - around.people_velocity[k, 0], own[1] - around.people_velocity[k, 1]
        size, nx, ny = circular(-x, -y, vx, vy, around.contact[k], strength, reach, ahead)
        seen = (x * wanted[0] + y * wanted[1]) / max(np.hypot(x, y) * limits.speed, 1e-9)
        size *= sight(model[0].anisotropy, seen)
        ax, ay = ax + size * nx, ay + size * ny
    nearest, wall = np.inf, 0
    for p in range(len(walls)):
        distance = np.hypot(walls[p, 0], walls[p, 1])
        if 0.0 < distance < nearest:
            nearest, wall = distance, p
    if nearest < np.inf:
        size = repulsion(model[0].wall_repulsion, model[0].wall_range, nearest - limits.radius)
        ax, ay = ax - size * walls[wall, 0] / nearest, ay - size * walls[wall, 1] / nearest
    vx, vy = own[0] + ax * limits.dt, own[1] + ay * limits.dt
    scale = min(1.0, limits.speed / max(np.hypot(vx, vy), 1e-9))
    return vx * scale, vy * scale
