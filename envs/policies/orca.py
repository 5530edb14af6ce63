"""Optimal reciprocal collision avoidance (van den Berg, Guy, Lin and Manocha 2011) for the robot.

The velocity nearest to the one towards the waypoint that meets nobody within the horizon if all
keep their present velocities. It takes half of each evasion and trusts people with the other
half, as the policy does that the literature compares itself with; forecasts it has no use for.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.half_planes import nearest_permitted
from crowdsim.velocity_obstacle import way_out
from envs.config import CrowdNavConfig
from envs.policies.policy import Observation, Policy
from envs.policies.scenes import robot_limits
from envs.policies.velocities import look_around, velocity_actions

Floats = NDArray[np.float64]

HORIZON = 3.0
"""People are avoided whom the robot would meet within this time [s]."""

WALL_HORIZON = 1.0
"""Likewise for walls [s]."""

COMFORT = 0.1
"""Free space that is added to the radii [m]: a robot does not follow a velocity at once."""


class ORCAPolicy(Policy):
    """Avoids people by half-planes of permitted velocities; walls are seen by the lidar."""

    name = "orca"

    def __init__(self, config: CrowdNavConfig) -> None:
        self._limits = robot_limits(config)
        self._frame_dt = config.frame_dt
        self._sensor_range = config.sensor_range
        # Who does not see the robot takes no half of the evasion.
        self._share = 0.5 if config.robot_visible else 1.0

    def act_batch(self, observation: Observation) -> NDArray[np.float32]:
        """Returns actions (W, 2) towards the permitted velocities; see `Policy.act`."""
        around, limits = look_around(observation, self._frame_dt, self._sensor_range), self._limits
        room = around.radius + limits.radius + COMFORT
        chosen = [
            permitted(
                around.velocity[world],
                around.wanted[world],
                around.position[world][around.valid[world]],
                around.people_velocity[world][around.valid[world]],
                room[world][around.valid[world]],
                around.walls[world][around.wall_valid[world]],
                limits.radius + COMFORT,
                limits.speed,
                self._share,
                limits.dt,
            )
            for world in range(len(room))
        ]
        return velocity_actions(np.array(chosen), limits)


@njit(cache=True)
def permitted(
    velocity: Floats,
    wanted: Floats,
    people: Floats,
    people_velocity: Floats,
    room: Floats,
    walls: Floats,
    own_room: float,
    max_speed: float,
    share: float,
    dt: float,
) -> tuple[float, float]:
    """Velocity (x, y) nearest to the wanted one that meets nobody [m/s].

    Args:
        velocity: (2,) of the robot [m/s].
        wanted: (2,) [m/s].
        people: (K, 2) positions as seen from the robot [m].
        people_velocity: (K, 2) [m/s].
        room: (K,) distances to keep from their middles [m].
        walls: (P, 2) points of walls as seen from the robot [m].
        own_room: distance to keep from walls [m].
        max_speed: [m/s].
        share: of each evasion that the robot takes.
        dt: time in which it leaves who is nearer than `room` [s].
    """
    planes = np.empty((len(walls) + len(people), 4))
    for p in range(len(walls)):
        distance = max(np.hypot(walls[p, 0], walls[p, 1]), 1e-6)
        nx, ny = -walls[p, 0] / distance, -walls[p, 1] / distance
        towards = (distance - own_room) / WALL_HORIZON
        planes[p] = -towards * nx, -towards * ny, nx, ny
    for k in range(len(people)):
        x, y = people[k]
        vx, vy = velocity[0] - people_velocity[k, 0], velocity[1] - people_velocity[k, 1]
        ux, uy, nx, ny = way_out(x, y, vx, vy, room[k], HORIZON, dt)
        planes[len(walls) + k] = velocity[0] + share * ux, velocity[1] + share * uy, nx, ny
    return nearest_permitted(planes, len(planes), len(walls), wanted[0], wanted[1], max_speed)
