"""The dynamic window approach, on forecasts: the best of all controls that the robot can take now.

Fox, Burgard and Thrun, "The dynamic window approach to collision avoidance" (1997): every control
that the robot can reach in one step is held over a short horizon, and the best path is begun.
Obstacles move here: people are where the forecast says. What a path costs is what it costs the
sampling planner, so that the two differ in how they search and in nothing else.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from envs.config import CrowdNavConfig
from envs.policies.policy import Observation, Policy
from envs.policies.robot_motion import Limits, feasible
from envs.policies.rollouts import Costs, Scene, rollout
from envs.policies.scenes import SceneReader, to_actions

HORIZON = 2.4
"""How long a control is held [s]; longer, and hardly a path leads through a crowd."""

PER_AXIS = 21
"""Controls that are tried along either axis of the window; odd, so that the middle is tried."""


class DWAPolicy(Policy):
    """Holds each control of a window around the present one over 2.4 s and begins the best path."""

    name = "dwa"

    def __init__(self, config: CrowdNavConfig) -> None:
        self._costs = Costs()
        steps = max(1, round(HORIZON / config.policy_dt))
        self._reader = SceneReader(config, steps, self._costs.wall_margin)
        axis = np.linspace(-1.0, 1.0, PER_AXIS)
        self._window = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)

    def act_batch(self, observation: Observation) -> NDArray[np.float32]:
        """Returns the best controls (W, 2) of the windows; see `Policy.act`."""
        limits, steps = self._reader.limits, self._reader.steps
        controls = [
            best_control(self._window, steps, scene, limits, self._costs)
            for scene in self._reader.scenes(observation)
        ]
        return to_actions(np.array(controls), limits)


@njit(cache=True)
def best_control(
    window: NDArray[np.float64], steps: int, scene: Scene, limits: Limits, costs: Costs
) -> tuple[float, float]:
    """The control (a, b) of the window whose path costs least.

    Args:
        window: (C, 2) in units of what the control can change by in a step.
        steps: For how many steps a control is held.
        scene: What the robot sees.
        limits: What the robot can do.
        costs: Weights of the cost of a path.
    """
    change = limits.acceleration * limits.dt
    turn = change if limits.holonomic else 2.0 * limits.angular_speed
    best, best_cost = (0.0, 0.0), np.inf
    for c in range(len(window)):
        a = scene.velocity[0] + change * window[c, 0]
        b = scene.velocity[1] + turn * window[c, 1]
        a, b = feasible(a, b, scene.velocity[0], scene.velocity[1], limits)
        path = np.empty((steps, 2))
        path[:, 0], path[:, 1] = a, b
        cost = rollout(path, False, best_cost, scene, limits, costs)
        if cost < best_cost:
            best, best_cost = (a, b), cost
    return best
