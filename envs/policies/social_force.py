"""The robot as one more pedestrian of the crowd simulator's social force model."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.forces import SocialForce, sight
from crowdsim.interactions import circular, repulsion
from envs.config import CrowdNavConfig
from envs.policies.policy import Observation, Policy
from envs.policies.robot_motion import Limits
from envs.policies.scenes import robot_limits
from envs.policies.velocities import look_around, velocity_actions

Floats = NDArray[np.float64]

RELAXATION_TIME = 0.5
"""Time in which the wanted velocity is taken up [s] (Helbing and Molnár 1995)."""


class SocialForcePolicy(Policy):
    """Moves by the forces that people feel (`crowdsim.forces`), with the same parameters.

    It takes people where they are going to be nearest if they keep their velocities; forecasts
    it has no use for.
    """

    name = "social_force"

    def __init__(self, config: CrowdNavConfig) -> None:
        self._limits = robot_limits(config)
        self._frame_dt = config.frame_dt
        self._sensor_range = config.sensor_range
        self._model = SocialForce()

    def act_batch(self, observation: Observation) -> NDArray[np.float32]:
        """Returns actions (W, 2) that follow the forces; see `Policy.act`."""
        around, limits = look_around(observation, self._frame_dt, self._sensor_range), self._limits
        contact = around.radius + limits.radius
        model = self._model.record()
        chosen = [
            next_velocity(
                around.velocity[world],
                around.wanted[world],
                around.position[world][around.valid[world]],
                around.people_velocity[world][around.valid[world]],
                contact[world][around.valid[world]],
                around.walls[world][around.wall_valid[world]],
                limits,
                model,
            )
            for world in range(len(contact))
        ]
        return velocity_actions(np.array(chosen), limits)


@njit(cache=True)
def next_velocity(
    velocity: Floats,
    wanted: Floats,
    people: Floats,
    people_velocity: Floats,
    contact: Floats,
    walls: Floats,
    limits: Limits,
    model: NDArray[np.void],
) -> tuple[float, float]:
    """Velocity (x, y) after one step under the goal's pull and the repulsion of people and wall.

    Args:
        velocity: (2,) of the robot [m/s].
        wanted: (2,) [m/s].
        people: (K, 2) positions as seen from the robot [m].
        people_velocity: (K, 2) [m/s].
        contact: (K,) sums of the radii [m].
        walls: (P, 2) points of walls as seen from the robot [m]; the nearest one is felt.
        limits: What the robot can do.
        model: Parameters, as `SocialForce.record` gives them.
    """
    ax = (wanted[0] - velocity[0]) / RELAXATION_TIME
    ay = (wanted[1] - velocity[1]) / RELAXATION_TIME
    strength, reach = model[0].repulsion, model[0].repulsion_range
    for k in range(len(people)):
        x, y = people[k]
        vx, vy = velocity[0] - people_velocity[k, 0], velocity[1] - people_velocity[k, 1]
        size, nx, ny = circular(-x, -y, vx, vy, contact[k], strength, reach, model[0].anticipation)
        seen = (x * wanted[0] + y * wanted[1]) / max(np.hypot(x, y) * limits.speed, 1e-9)
        size *= sight(model[0].anisotropy, seen)
        ax, ay = ax + size * nx, ay + size * ny
    nearest = np.inf
    for p in range(len(walls)):
        distance = np.hypot(walls[p, 0], walls[p, 1])
        if 0.0 < distance < nearest:
            nearest, wall = distance, p
    if nearest < np.inf:
        size = repulsion(model[0].wall_repulsion, model[0].wall_range, nearest - limits.radius)
        ax, ay = ax - size * walls[wall, 0] / nearest, ay - size * walls[wall, 1] / nearest
    vx, vy = velocity[0] + ax * limits.dt, velocity[1] + ay * limits.dt
    scale = min(1.0, limits.speed / max(np.hypot(vx, vy), 1e-9))
    return vx * scale, vy * scale
