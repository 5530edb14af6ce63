"""Other views of the single environment; each changes the observation and nothing else.

Gymnasium's own wrappers work as well: `FlattenObservation` makes one vector, and
`FrameStackObservation` stacks every key, which `FlattenKeys` then makes flat again. Histories are
in the observation already, so that stacking adds only what the robot and its lidar were like.
"""

from __future__ import annotations

from typing import Any, Final

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs
from numpy.typing import NDArray

from envs.observation import ROBOT_INDEX, Observation, flattened, flattened_space
from envs.robots import to_world

WORLD_REACH: Final = 1000.0
"""Coordinates of the world are cut off here [m]; the Boxes stay finite."""

VECTORS: Final = ("velocity",)
POINTS: Final = ("goal", "waypoint")
"""Fields of the key `robot` that are turned, and those that are moved as well."""


class FlattenKeys(
    gymnasium.ObservationWrapper[Observation, NDArray[np.float32], Observation],
    RecordConstructorArgs,
):
    """Flattens every key to one dimension, as `crowdnav/CrowdNavFlat-v0` has them."""

    def __init__(self, env: gymnasium.Env[Observation, NDArray[np.float32]]):
        """Wraps an environment whose observation is a Dict of Boxes."""
        RecordConstructorArgs.__init__(self)
        gymnasium.ObservationWrapper.__init__(self, env)
        inner: spaces.Space[Any] = env.observation_space
        assert isinstance(inner, spaces.Dict)
        self.observation_space: spaces.Space[Any] = flattened_space(inner)

    def observation(self, observation: Observation) -> Observation:
        """Returns the same values, flat."""
        return flattened(observation, leading=0)


class WorldFrame(
    gymnasium.ObservationWrapper[Observation, NDArray[np.float32], Observation],
    RecordConstructorArgs,
):
    """Tells positions and velocities in the world's frame: x right, y up, the scenario's origin.

    Positions in `history`, `forecast`, `forecast_modes` and `robot` (goal and waypoint) become
    those of the world, the velocity in `robot` is turned, and a new key `pose` (3,) says where the
    robot is: x, y [m] and heading [rad, CCW from +x]. Empty places stay zero. `lidar` and `map` go
    on looking ahead.
    """

    def __init__(self, env: gymnasium.Env[Observation, NDArray[np.float32]]):
        """Wraps `crowdnav/CrowdNav-v0`; wrap it before its keys are flattened or stacked.

        Raises:
            ValueError: The keys of `env` are not those of `crowdnav/CrowdNav-v0`.
        """
        RecordConstructorArgs.__init__(self)
        gymnasium.ObservationWrapper.__init__(self, env)
        inner: spaces.Space[Any] = env.observation_space
        boxes: dict[str, Any] = dict(inner.items()) if isinstance(inner, spaces.Dict) else {}
        if "history" not in boxes or boxes["history"].shape[2:] != (2,):
            raise ValueError(f"expected the keys of crowdnav/CrowdNav-v0, found {inner}")
        for key in {"history", "forecast", "forecast_modes"} & boxes.keys():
            boxes[key] = spaces.Box(-WORLD_REACH, WORLD_REACH, boxes[key].shape, np.float32)
        reach = np.array([WORLD_REACH, WORLD_REACH, np.pi], dtype=np.float32)
        boxes |= {"robot": _robot_space(boxes["robot"]), "pose": spaces.Box(-reach, reach)}
        self._boxes = boxes
        self.observation_space: spaces.Space[Any] = spaces.Dict(boxes)

    def observation(self, observation: Observation) -> Observation:
        """Returns the observation with positions and velocities in the world's frame."""
        robots = self.unwrapped.episodes.worlds.robots  # type: ignore[attr-defined]
        position, heading = robots.position[0], robots.heading
        there = observation["neighbors_valid"][:, None, None]
        valid = {
            "history": observation["history_valid"][..., None],
            "forecast": there,
            "forecast_modes": there[..., None],
        }
        told: dict[str, NDArray[Any]] = {
            key: (to_world(observation[key][None].astype(np.float64), heading)[0] + position) * mask
            for key, mask in valid.items()
            if key in observation
        }
        told["robot"] = observation["robot"].astype(np.float64)
        for name in (*VECTORS, *POINTS):
            at = [ROBOT_INDEX[f"{name}_x"], ROBOT_INDEX[f"{name}_y"]]
            turned = to_world(told["robot"][None, at], heading)[0]
            told["robot"][at] = turned + position if name in POINTS else turned
        told["pose"] = np.append(position, heading)
        for key, values in told.items():
            box = self._boxes[key]
            told[key] = np.clip(values, box.low, box.high).astype(np.float32)
        return observation | told


def _robot_space(box: spaces.Box) -> spaces.Box:
    """The Box of the key `robot` with room for the goal's and the waypoint's world positions."""
    low, high = box.low.copy(), box.high.copy()
    for name in POINTS:
        at = [ROBOT_INDEX[f"{name}_x"], ROBOT_INDEX[f"{name}_y"]]
        low[at], high[at] = -WORLD_REACH, WORLD_REACH
    return spaces.Box(low, high, dtype=np.float32)
