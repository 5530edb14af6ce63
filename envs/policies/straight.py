"""The simplest policy: head for the waypoint and ignore everybody."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from envs.config import CrowdNavConfig
from envs.observation import ROBOT_INDEX
from envs.policies.policy import Observation, Policy
from envs.policies.robot_motion import STEERING_GAIN


class StraightPolicy(Policy):
    """Heads for the waypoint at full speed; a unicycle turns towards it first."""

    name = "straight"

    def __init__(self, config: CrowdNavConfig) -> None:
        self._holonomic = config.robot == "holonomic"
        self._gain = STEERING_GAIN / config.max_angular_speed

    def act_batch(self, observation: Observation) -> NDArray[np.float32]:
        """Returns actions (W, 2) towards the waypoints; see `Policy.act`."""
        robot = np.asarray(observation["robot"], np.float64)
        x, y = robot[:, ROBOT_INDEX["waypoint_x"]], robot[:, ROBOT_INDEX["waypoint_y"]]
        bearing = np.arctan2(y, x)
        if self._holonomic:
            return np.stack((np.cos(bearing), np.sin(bearing)), axis=1).astype(np.float32)
        # The less the waypoint is ahead the slower: no circling around a near one.
        speed = 2.0 * np.maximum(np.cos(bearing), 0.0) - 1.0
        turn = np.clip(self._gain * bearing, -1.0, 1.0)
        return np.stack((speed, turn), axis=1).astype(np.float32)
