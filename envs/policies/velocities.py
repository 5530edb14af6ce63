"""Policies that choose a velocity: what they read from observations, and how it is followed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envs.observation import ROBOT_INDEX
from envs.policies.policy import Observation
from envs.policies.robot_motion import STEERING_GAIN, Limits

Floats = NDArray[np.float64]


class Surroundings(NamedTuple):
    """What W robots have around them, robot frame, SI units.

    Attributes:
        velocity: (W, 2) of the robots.
        wanted: (W, 2) velocity towards the waypoint, at full speed.
        position: (W, K, 2) of people.
        people_velocity: (W, K, 2), over the last frame; 0 for who has been seen only once.
        radius: (W, K).
        valid: (W, K).
        walls: (W, R, 2) where the lidar rays end.
        wall_valid: (W, R), whether a wall is there.
    """

    velocity: Floats
    wanted: Floats
    position: Floats
    people_velocity: Floats
    radius: Floats
    valid: NDArray[np.bool_]
    walls: Floats
    wall_valid: NDArray[np.bool_]


def look_around(observation: Observation, frame_dt: float, sensor_range: float) -> Surroundings:
    """Reads W observations."""
    robot = np.asarray(observation["robot"], np.float64)
    history = np.asarray(observation["history"], np.float64)
    seen = np.asarray(observation["history_valid"]) > 0.5
    step = history[:, :, -1] - history[:, :, -2] if history.shape[2] > 1 else 0.0 * history[:, :, 0]
    twice = np.all(seen[:, :, -2:], axis=-1, keepdims=True)
    waypoint = robot[:, [ROBOT_INDEX["waypoint_x"], ROBOT_INDEX["waypoint_y"]]]
    far = np.maximum(np.sqrt((waypoint**2).sum(axis=1, keepdims=True)), 1e-6)
    ranges = np.asarray(observation["lidar"], np.float64)
    angles = 2.0 * np.pi * np.arange(ranges.shape[1]) / ranges.shape[1]
    return Surroundings(
        velocity=robot[:, [ROBOT_INDEX["velocity_x"], ROBOT_INDEX["velocity_y"]]],
        wanted=waypoint / far * robot[:, ROBOT_INDEX["max_speed"], None],
        position=history[:, :, -1],
        people_velocity=np.where(twice, step / frame_dt, 0.0),
        radius=np.asarray(observation["neighbors_radius"], np.float64),
        valid=np.asarray(observation["neighbors_valid"]) > 0.5,
        walls=ranges[..., None] * np.stack((np.cos(angles), np.sin(angles)), axis=-1),
        wall_valid=ranges < sensor_range,
    )


def velocity_actions(velocity: Floats, limits: Limits) -> NDArray[np.float32]:
    """Returns the actions (W, 2) that bring robots to velocities (W, 2) in their own frames.

    A unicycle turns towards the velocity and drives as fast as it points that way.
    """
    if limits.holonomic:
        return (velocity / limits.speed).astype(np.float32)
    bearing = np.arctan2(velocity[:, 1], velocity[:, 0])
    forward = 2.0 * np.maximum(velocity[:, 0], 0.0) / limits.speed - 1.0
    turn = np.clip(STEERING_GAIN * bearing / limits.angular_speed, -1.0, 1.0)
    return np.stack((np.minimum(forward, 1.0), turn), axis=1).astype(np.float32)
