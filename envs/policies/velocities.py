"""Policies that choose a velocity: what they read from observations, and how it is followed."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envs.config import CrowdNavConfig
from envs.observation import ROBOT_INDEX
from envs.policies.policy import Observation, Policy
from envs.policies.robot_motion import CREEP, STEERING_GAIN, Limits, encircled
from envs.policies.scenes import robot_limits, turning_action

Floats = NDArray[np.float64]

_VELOCITY = [ROBOT_INDEX["velocity_x"], ROBOT_INDEX["velocity_y"]]
WAYPOINT = [ROBOT_INDEX["waypoint_x"], ROBOT_INDEX["waypoint_y"]]


class Surroundings(NamedTuple):
    """What one robot has around it, robot frame, SI units.

    Attributes:
        velocity: (2,) of the robot.
        wanted: (2,) velocity towards the waypoint, at full speed.
        people: (K, 2) positions.
        people_velocity: (K, 2), over the last frame; 0 for who has been seen only once.
        contact: (K,) sums of the radii of robot and person.
        walls: (P, 2) where lidar rays hit walls.
    """

    velocity: Floats
    wanted: Floats
    people: Floats
    people_velocity: Floats
    contact: Floats
    walls: Floats


class VelocityPolicy(Policy):
    """A policy that chooses a velocity from where people are and how they move now."""

    def __init__(self, config: CrowdNavConfig) -> None:
        self._limits = robot_limits(config)
        self._frame_dt = config.frame_dt
        self._sensor_range = config.sensor_range

    def act_batch(self, observation: Observation) -> NDArray[np.float32]:
        """Returns actions (W, 2) that bring the robots to what `velocity` chooses."""
        chosen = [self.velocity(around) for around in self._look_around(observation)]
        return velocity_actions(np.array(chosen), self._limits)

    @abstractmethod
    def velocity(self, around: Surroundings) -> tuple[float, float]:
        """Chooses the velocity (x, y) of one robot in its own frame [m/s]."""

    def _look_around(self, observation: Observation) -> Iterator[Surroundings]:
        """Yields the surroundings of each of W observations."""
        robot = np.asarray(observation["robot"], np.float64)
        history = np.asarray(observation["history"], np.float64)
        seen = np.asarray(observation["history_valid"]) > 0.5
        # Of a history of one frame, the last frame and the one before are the same.
        twice = np.all(seen[:, :, -2:], axis=-1, keepdims=True)
        step = np.where(twice, history[:, :, -1] - history[:, :, -2:][:, :, 0], 0.0)
        contact = np.asarray(observation["neighbors_radius"], np.float64) + self._limits.radius
        valid = np.asarray(observation["neighbors_valid"]) > 0.5
        ranges = np.asarray(observation["lidar"], np.float64)
        angles = 2.0 * np.pi * np.arange(ranges.shape[1]) / ranges.shape[1]
        rays = np.stack((np.cos(angles), np.sin(angles)), axis=-1)
        for world, fields in enumerate(robot):
            there, hit = valid[world], ranges[world] < self._sensor_range
            yield Surroundings(
                velocity=fields[_VELOCITY],
                wanted=towards(fields[WAYPOINT], self._limits),
                people=history[world, there, -1],
                people_velocity=step[world, there] / self._frame_dt,
                contact=contact[world, there],
                walls=ranges[world, hit, None] * rays[hit],
            )


def towards(target: Floats, limits: Limits) -> Floats:
    """Returns the velocity (..., 2) at full speed towards targets (..., 2), robot frame.

    A bicycle first drives away from what lies within its turning circle.
    """
    x, y = target[..., 0], target[..., 1]
    velocity = target * (limits.speed / np.maximum(np.hypot(x, y), 1e-6))[..., None]
    away = np.asarray(encircled(x, y, 0.5 * limits.goal_radius, limits))[..., None]
    return np.where(away, (limits.speed, 0.0), velocity)


def velocity_actions(velocity: Floats, limits: Limits) -> NDArray[np.float32]:
    """Returns the actions (W, 2) that bring robots to velocities (W, 2) in their own frames.

    A unicycle turns towards the velocity and drives as fast as it points that way; a bicycle
    creeps where that would be no way to turn.
    """
    if limits.holonomic:
        return (velocity / limits.speed).astype(np.float32)
    bearing = np.arctan2(velocity[:, 1], velocity[:, 0])
    speed, gain = np.clip(velocity[:, 0], 0.0, limits.speed), STEERING_GAIN
    if np.isfinite(limits.curvature):
        gain = 1.0 / limits.dt
        speed = np.maximum(speed, CREEP * np.minimum(np.hypot(*velocity.T), limits.speed))
    turn = turning_action(speed, gain * bearing, limits)
    return np.stack((2.0 * speed / limits.speed - 1.0, turn), axis=1).astype(np.float32)
