"""The simplest policy: head for the waypoint and ignore everybody."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envs.config import CrowdNavConfig
from envs.policies.policy import Observation, Policy
from envs.policies.scenes import robot_limits
from envs.policies.velocities import WAYPOINT, towards, velocity_actions


class StraightPolicy(Policy):
    """Heads for the waypoint at full speed; who cannot drive sideways turns towards it first."""

    name = "straight"

    def __init__(self, config: CrowdNavConfig) -> None:
        self._limits = robot_limits(config)

    def act_batch(self, observation: Observation) -> NDArray[np.float32]:
        """Returns actions (W, 2) towards the waypoints; see `Policy.act`."""
        waypoint = np.asarray(observation["robot"], np.float64)[:, WAYPOINT]
        # The less the waypoint is ahead the slower: no circling around a near one.
        return velocity_actions(towards(waypoint, self._limits), self._limits)
