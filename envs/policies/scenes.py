"""What planners make of an observation: the robot's task, people over time, and walls."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from envs.config import CrowdNavConfig
from envs.observation import ROBOT_INDEX
from envs.policies.policy import Observation
from envs.policies.robot_motion import Limits
from envs.policies.rollouts import SPREADING, Scene, walls_seen
from envs.robots import turning_limit

Floats = NDArray[np.float64]

_UNICYCLE = [ROBOT_INDEX["velocity_x"], ROBOT_INDEX["angular_speed"]]
_HOLONOMIC = [ROBOT_INDEX["velocity_x"], ROBOT_INDEX["velocity_y"]]
_WAYPOINT = [ROBOT_INDEX["waypoint_x"], ROBOT_INDEX["waypoint_y"]]
_GOAL = [ROBOT_INDEX["goal_x"], ROBOT_INDEX["goal_y"]]


class SceneReader:
    """Reads scenes out of observations, for plans of a fixed length.

    People are where the forecast says at the time of the rollout step, interpolated between
    frames. Beyond the end of the forecast they are held at its last point, and without the key
    `forecast` where they stand now: the arm `none` is the limit of ever shorter forecasts.

    Attributes:
        limits: What the robot can do.
        steps: Rollout steps of a plan.
    """

    def __init__(self, config: CrowdNavConfig, steps: int, wall_margin: float) -> None:
        """Prepares for a robot and its plans.

        Args:
            config: Configuration of the environment.
            steps: Rollout steps of a plan, one policy period each.
            wall_margin: Walls farther than this from any plan do not matter [m].
        """
        self.limits = robot_limits(config)
        self.steps = steps
        self._frame_dt = config.frame_dt
        reach = config.max_speed * config.policy_dt * steps + wall_margin
        self._farthest = min(config.sensor_range, config.robot_radius + reach)

    def scenes(self, observation: Observation) -> Iterator[Scene]:
        """Yields the scene of each of W observations."""
        robot = np.asarray(observation["robot"], np.float64)
        lidar = np.asarray(observation["lidar"], np.float64)
        reach = np.asarray(observation["neighbors_radius"], np.float64) + self.limits.radius
        valid = np.asarray(observation["neighbors_valid"]) > 0.5
        people, doubt = self._people(observation), self._doubt(observation)
        for world, fields in enumerate(robot):
            yield Scene(
                velocity=fields[_HOLONOMIC if self.limits.holonomic else _UNICYCLE],
                waypoint=fields[_WAYPOINT],
                goal=fields[_GOAL],
                people=people[world][:, valid[world]],
                reach=reach[world][valid[world]],
                doubt=doubt[world][:, valid[world]],
                walls=walls_seen(lidar[world], self._farthest, 2.0 * self.limits.radius),
            )

    def _people(self, observation: Observation) -> Floats:
        """Returns (W, H, K, 2), where everybody is at the end of each rollout step."""
        knots = np.asarray(observation["history"], np.float64)[:, :, -1:]
        if "forecast" in observation:
            knots = np.concatenate((knots, observation["forecast"]), axis=2)
        people: Floats = np.einsum("hf,wkfc->whkc", self._weights(np.inf, knots.shape[2]), knots)
        return people

    def _doubt(self, observation: Observation) -> Floats:
        """Returns (W, H, K), how far from there 9 in 10 of them may be [m]; 0 if nobody says so."""
        radius = np.zeros((*np.shape(observation["neighbors_valid"]), 1))
        if "forecast_radius" in observation:
            radius = np.concatenate((radius, observation["forecast_radius"]), axis=2)
        weights = self._weights(SPREADING, radius.shape[2])
        return np.asarray(np.einsum("hf,wkf->whk", weights, radius))

    def _weights(self, latest: float, knots: int) -> Floats:
        """Weights (H, F) that interpolate at the rollout steps, none later than `latest`."""
        times = self.limits.dt * np.arange(1, self.steps + 1, dtype=np.float64)
        return interpolation(
            np.minimum(times, latest), self._frame_dt * np.arange(knots, dtype=np.float64)
        )


def robot_limits(config: CrowdNavConfig) -> Limits:
    """Returns what the robot of the environment can do, a rollout step being a policy step."""
    bicycle = config.robot == "bicycle"
    return Limits(
        holonomic=config.robot == "holonomic",
        speed=config.max_speed,
        angular_speed=turning_limit(config),
        acceleration=config.max_acceleration,
        radius=config.robot_radius,
        goal_radius=config.goal_radius,
        dt=config.policy_dt,
        curvature=math.tan(config.max_steering) / config.wheelbase if bicycle else math.inf,
        wheelbase=config.wheelbase,
    )


def interpolation(times: Floats, knots: Floats) -> Floats:
    """Returns (H, F) weights that interpolate linearly at `times` (H,) between `knots` (F,).

    After the last knot its value is held.
    """
    return np.stack([np.interp(times, knots, row) for row in np.eye(len(knots))], axis=1)


def to_actions(controls: Floats, limits: Limits) -> NDArray[np.float32]:
    """Returns the actions in [-1, 1] that command the controls (W, 2)."""
    if limits.holonomic:
        return (controls / limits.speed).astype(np.float32)
    speed = 2.0 * controls[:, 0] / limits.speed - 1.0
    turn = turning_action(controls[:, 0], controls[:, 1], limits)
    return np.stack((speed, turn), axis=1).astype(np.float32)


def turning_action(speed: Floats, turn: Floats, limits: Limits) -> Floats:
    """Returns the second action (W,) in [-1, 1] that turns at (W,) rad/s while driving at `speed`.

    That of a bicycle is its steering angle, as a share of the largest.
    """
    if math.isinf(limits.curvature):
        return np.clip(turn / limits.angular_speed, -1.0, 1.0)
    curvature = np.clip(turn / np.maximum(speed, 1e-6), -limits.curvature, limits.curvature)
    steering = np.arctan(curvature * limits.wheelbase)
    return np.asarray(steering / math.atan(limits.curvature * limits.wheelbase))
