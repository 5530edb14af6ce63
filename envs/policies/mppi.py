"""A sampling planner that scores its rollouts against the forecasts in the observation."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from envs.config import CrowdNavConfig, whole_multiple
from envs.observation import ROBOT_INDEX
from envs.policies.policy import Observation, Policy
from envs.policies.robot_motion import Limits
from envs.policies.rollouts import Costs, Scene, improve, walls_seen

Floats = NDArray[np.float64]

_UNICYCLE = [ROBOT_INDEX["velocity_x"], ROBOT_INDEX["angular_speed"]]
_HOLONOMIC = [ROBOT_INDEX["velocity_x"], ROBOT_INDEX["velocity_y"]]
_WAYPOINT = [ROBOT_INDEX["waypoint_x"], ROBOT_INDEX["waypoint_y"]]
_GOAL = [ROBOT_INDEX["goal_x"], ROBOT_INDEX["goal_y"]]


@dataclass(frozen=True, kw_only=True)
class MPPIParameters:
    """What the planner may be tuned by.

    Attributes:
        horizon: How far it plans [s]; a whole number of `policy_dt`.
        samples: Number of rollouts per plan.
        temperature: Cost difference at which a rollout counts 1/e as much.
        noise: Standard deviation of the sampled controls, as a share of the robot's limits.
        noise_time: Time after which the noise of a rollout has lost its memory [s].
        seed: Seed of the noise table, drawn once and used for every plan of every episode.
        costs: Weights of the rollout cost.

    Raises:
        ValueError: A value is out of range.
    """

    horizon: float = 4.8
    samples: int = 256
    temperature: float = 0.2
    noise: float = 0.8
    noise_time: float = 1.0
    seed: int = 0
    costs: Costs = field(default_factory=Costs)

    def __post_init__(self) -> None:
        if self.samples < 3:
            raise ValueError(f"samples must be at least 3, got {self.samples}")
        for name in ("horizon", "temperature", "noise", "noise_time"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be positive and finite, got {value}")


class MPPIPolicy(Policy):
    """Model predictive path integral control on forecasts, for both kinds of robot.

    Every call improves the plan of the last one, shifted by a step, and takes its first control.
    People are where the forecast says at the time of the rollout step, interpolated between
    frames. Beyond the end of the forecast they are held at its last point, and without the key
    `forecast` where they stand now: the arm `none` is the limit of ever shorter forecasts.

    All worlds share one noise table, so plans do not depend on how many run side by side.
    """

    name = "mppi"

    def __init__(self, config: CrowdNavConfig, parameters: MPPIParameters | None = None) -> None:
        self._parameters = MPPIParameters() if parameters is None else parameters
        self._limits = robot_limits(config)
        self._steps = whole_multiple(
            "horizon", self._parameters.horizon, "policy_dt", config.policy_dt
        )
        self._noise = noise_table(self._parameters, self._steps, self._limits)
        self._frame_dt = config.frame_dt
        reach = config.max_speed * self._parameters.horizon + self._parameters.costs.wall_margin
        self._farthest = min(config.sensor_range, config.robot_radius + reach)
        self._plans: Floats = np.zeros((0, self._steps, 2))

    def reset(self, mask: NDArray[np.bool_] | None = None) -> None:
        """Forgets the plans of finished episodes; see `Policy.reset`."""
        self._plans[slice(None) if mask is None else mask] = 0.0

    def act_batch(self, observation: Observation) -> NDArray[np.float32]:
        """Returns the first controls of W improved plans; see `Policy.act`."""
        worlds = len(observation["robot"])
        if len(self._plans) != worlds:
            self._plans = np.zeros((worlds, self._steps, 2))
        self._plans[:, :-1] = self._plans[:, 1:]
        settings = (self._parameters.temperature, self._limits, self._parameters.costs)
        for plan, scene in zip(self._plans, self._scenes(observation), strict=True):
            improve(plan, self._noise, scene, *settings)
        return to_actions(self._plans[:, 0], self._limits)

    def _scenes(self, observation: Observation) -> Iterator[Scene]:
        robot = np.asarray(observation["robot"], np.float64)
        lidar = np.asarray(observation["lidar"], np.float64)
        reach = np.asarray(observation["neighbors_radius"], np.float64) + self._limits.radius
        valid = np.asarray(observation["neighbors_valid"]) > 0.5
        people = self._people(observation)
        for world, fields in enumerate(robot):
            yield Scene(
                velocity=fields[_HOLONOMIC if self._limits.holonomic else _UNICYCLE],
                waypoint=fields[_WAYPOINT],
                goal=fields[_GOAL],
                people=people[world][:, valid[world]],
                reach=reach[world][valid[world]],
                walls=walls_seen(lidar[world], self._farthest, 2.0 * self._limits.radius),
            )

    def _people(self, observation: Observation) -> Floats:
        """Returns (W, H, K, 2), where everybody is at the end of each rollout step."""
        knots = np.asarray(observation["history"], np.float64)[:, :, -1:]
        if "forecast" in observation:
            knots = np.concatenate((knots, observation["forecast"]), axis=2)
        times = self._limits.dt * np.arange(1, self._steps + 1, dtype=np.float64)
        weights = interpolation(times, self._frame_dt * np.arange(knots.shape[2], dtype=np.float64))
        people: Floats = np.einsum("hf,wkfc->whkc", weights, knots)
        return people


def robot_limits(config: CrowdNavConfig) -> Limits:
    """Returns what the robot of the environment can do, a rollout step being a policy step."""
    return Limits(
        holonomic=config.robot == "holonomic",
        speed=config.max_speed,
        angular_speed=config.max_angular_speed,
        acceleration=config.max_acceleration,
        radius=config.robot_radius,
        goal_radius=config.goal_radius,
        dt=config.policy_dt,
    )


def noise_table(parameters: MPPIParameters, steps: int, limits: Limits) -> Floats:
    """Draws (S, H, 2) offsets to the controls, correlated in time; row 0 is zero."""
    rng = np.random.default_rng(parameters.seed)
    table = rng.standard_normal((parameters.samples, steps, 2))
    memory = np.exp(-limits.dt / parameters.noise_time)
    for t in range(1, steps):
        table[:, t] = memory * table[:, t - 1] + np.sqrt(1.0 - memory**2) * table[:, t]
    table[0] = 0.0
    turning = limits.speed if limits.holonomic else limits.angular_speed
    table *= parameters.noise * np.array([limits.speed, turning])
    return table


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
    return np.stack((speed, controls[:, 1] / limits.angular_speed), axis=1).astype(np.float32)
