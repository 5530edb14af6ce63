"""A sampling planner that scores its rollouts against the forecasts in the observation."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from envs.config import CrowdNavConfig, whole_multiple
from envs.policies.policy import Observation, Policy
from envs.policies.robot_motion import Limits
from envs.policies.rollouts import Costs, improve
from envs.policies.scenes import SceneReader, to_actions

Floats = NDArray[np.float64]

CHANCE = 0.5
"""Share of a forecast's radius that is left alone; measured in docs/environment.md."""


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
    costs: Costs = field(default_factory=lambda: Costs(chance=CHANCE))

    def __post_init__(self) -> None:
        if self.samples < 3:
            raise ValueError(f"samples must be at least 3, got {self.samples}")
        for name in ("horizon", "temperature", "noise", "noise_time"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be positive and finite, got {value}")


class MPPIPolicy(Policy):
    """Model predictive path integral control on forecasts, for every kind of robot.

    Every call improves the plan of the last one, shifted by a step, and takes its first control.
    How people are expected to move, `SceneReader` says.

    All worlds share one noise table, so plans do not depend on how many run side by side.
    """

    name = "mppi"

    def __init__(self, config: CrowdNavConfig, parameters: MPPIParameters | None = None) -> None:
        self._parameters = MPPIParameters() if parameters is None else parameters
        horizon = self._parameters.horizon
        steps = whole_multiple("horizon", horizon, "policy_dt", config.policy_dt)
        self._reader = SceneReader(config, steps, self._parameters.costs.wall_margin)
        self._noise = noise_table(self._parameters, steps, self._reader.limits)
        self._plans: Floats = np.zeros((0, steps, 2))

    def reset(self, mask: NDArray[np.bool_] | None = None) -> None:
        """Forgets the plans of finished episodes; see `Policy.reset`."""
        self._plans[slice(None) if mask is None else mask] = 0.0

    def act_batch(self, observation: Observation) -> NDArray[np.float32]:
        """Returns the first controls of W improved plans; see `Policy.act`."""
        worlds, limits = len(observation["robot"]), self._reader.limits
        if len(self._plans) != worlds:
            self._plans = np.zeros((worlds, self._reader.steps, 2))
        self._plans[:, :-1] = self._plans[:, 1:]
        settings = (self._parameters.temperature, limits, self._parameters.costs)
        for plan, scene in zip(self._plans, self._reader.scenes(observation), strict=True):
            improve(plan, self._noise, scene, *settings)
        return to_actions(self._plans[:, 0], limits)


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
