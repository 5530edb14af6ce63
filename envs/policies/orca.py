"""Optimal reciprocal collision avoidance (van den Berg, Guy, Lin and Manocha 2011) for the robot.

The velocity nearest to the one towards the waypoint that meets nobody within the horizon if all
keep their present velocities. It takes half of each evasion and trusts people with the other
half, as the policy does that the literature compares itself with; forecasts it has no use for.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from crowdsim.half_planes import nearest_permitted
from crowdsim.velocity_obstacle import way_out
from envs.config import CrowdNavConfig
from envs.policies.robot_motion import Limits
from envs.policies.velocities import Surroundings, VelocityPolicy

HORIZON = 3.0
"""People are avoided whom the robot would meet within this time [s]."""

WALL_HORIZON = 1.0
"""Likewise for walls [s]."""

COMFORT = 0.1
"""Free space that is added to the radii [m]: a robot does not follow a velocity at once."""


class ORCAPolicy(VelocityPolicy):
    """Avoids people by half-planes of permitted velocities; walls are seen by the lidar."""

    name = "orca"

    def __init__(self, config: CrowdNavConfig) -> None:
        super().__init__(config)
        # Who does not see the robot takes no half of the evasion.
        self._share = 0.5 if config.robot_visible else 1.0

    def velocity(self, around: Surroundings) -> tuple[float, float]:
        """The permitted velocity nearest to the wanted one; see `VelocityPolicy.velocity`."""
        x, y = permitted(around, self._limits, self._share)
        return float(x), float(y)


@njit(cache=True)
def permitted(around: Surroundings, limits: Limits, share: float) -> tuple[float, float]:
    """Velocity (x, y) nearest to the wanted one that meets nobody [m/s].

    Args:
        around: What the robot has around it.
        limits: What it can do.
        share: Of each evasion that it takes.
    """
    velocity, walls, people = around.velocity, around.walls, around.people
    planes = np.empty((len(walls) + len(people), 4))
    for p in range(len(walls)):
        distance = max(np.hypot(walls[p, 0], walls[p, 1]), 1e-6)
        nx, ny = -walls[p, 0] / distance, -walls[p, 1] / distance
        towards = (distance - limits.radius - COMFORT) / WALL_HORIZON
        planes[p] = -towards * nx, -towards * ny, nx, ny
    for k in range(len(people)):
        x, y = people[k]
        vx = velocity[0] - around.people_velocity[k, 0]
        vy = velocity[1] - around.people_velocity[k, 1]
        room = around.contact[k] + COMFORT
        ux, uy, nx, ny = way_out(x, y, vx, vy, room, HORIZON, limits.dt)
        planes[len(walls) + k] = velocity[0] + share * ux, velocity[1] + share * uy, nx, ny
    wanted = around.wanted[0], around.wanted[1]
    return nearest_permitted(planes, len(planes), len(walls), *wanted, limits.speed)
