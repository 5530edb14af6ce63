"""The reward: named terms, each its own small function, weighted and summed once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envs.config import CrowdNavConfig

Floats = NDArray[np.float64]
REWARD_TERMS = (
    "progress",
    "goal",
    "collision",
    "discomfort",
    "predicted_intrusion",
    "time",
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Consequences:
    """What one step led to, for W robots; all that the reward looks at.

    Attributes:
        progress: (W,) how much shorter the way to the goal has become [m].
        reached: (W,) whether the robot reached its goal.
        collided: (W,) whether the robot touched a person or a wall.
        clearance: (W,) smallest clearance to a pedestrian during the step [m].
        planned: (W, F, 2) where the robot is at each forecast step if its command stays [m].
        forecast: (W, K, F, 2) forecasts made after the step, same frame as `planned`; None
            without a forecaster.
        neighbors_valid: (W, K), which of them are real.
        neighbors_radius: (W, K) [m].
    """

    progress: Floats
    reached: NDArray[np.bool_]
    collided: NDArray[np.bool_]
    clearance: Floats
    planned: Floats
    forecast: Floats | None
    neighbors_valid: NDArray[np.bool_]
    neighbors_radius: Floats


def reward_terms(step: Consequences, config: CrowdNavConfig) -> dict[str, Floats]:
    """Returns the weighted terms, (W,) each, in the order of `REWARD_TERMS`."""
    dt = config.policy_dt
    return {
        "progress": config.progress_weight * step.progress,
        "goal": config.goal_weight * step.reached,
        "collision": config.collision_weight * step.collided,
        "discomfort": config.discomfort_weight * dt * discomfort(step, config),
        "predicted_intrusion": config.predicted_intrusion_weight
        * dt
        * predicted_intrusion(step, config),
        "time": np.full(len(step.progress), config.time_weight * dt),
    }


def total(terms: dict[str, Floats]) -> Floats:
    """Returns the reward (W,): the terms summed, always in the same order."""
    reward: Floats = np.zeros_like(terms["time"])
    for name in REWARD_TERMS:
        reward += terms[name]
    return reward


def discomfort(step: Consequences, config: CrowdNavConfig) -> Floats:
    """Returns (W,) in 0..1: how deep the robot came into the nearest person's space."""
    return closeness(step.clearance, config.discomfort_distance)


def predicted_intrusion(step: Consequences, config: CrowdNavConfig) -> Floats:
    """Returns (W,) in 0..1: how much the robot is about to run through people's forecasts.

    The forecast of each person at step k is compared with the robot's own rolled-out position at
    the same k; closeness at time t counts exp(-t / `predicted_intrusion_decay`), and the worst
    person and step decide. 0 without a forecaster.
    """
    if step.forecast is None:
        return np.zeros(len(step.progress))
    gap = step.forecast - step.planned[:, None]
    distance = np.sqrt(gap[..., 0] ** 2 + gap[..., 1] ** 2)  # (W, K, F)
    clearance = distance - step.neighbors_radius[..., None] - config.robot_radius
    times = config.frame_dt * np.arange(1, config.forecast_steps + 1)
    worth = np.exp(-times / config.predicted_intrusion_decay)
    intrusion = closeness(clearance, config.discomfort_distance) * worth
    return np.asarray(np.max(intrusion * step.neighbors_valid[..., None], axis=(1, 2)))


def closeness(clearance: Floats, distance: float) -> Floats:
    """Returns 1 at zero clearance (or less), falling linearly to 0 at `distance` [m]."""
    return np.clip(1.0 - clearance / distance, 0.0, 1.0)
