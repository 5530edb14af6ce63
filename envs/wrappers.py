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
        assert isinstance(env.observation_space, spaces.Dict)
        self.observation_space: spaces.Dict = flattened_space(env.observation_space)  # type: ignore[assignment]

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
        inner = env.observation_space
        if not isinstance(inner, spaces.Dict) or inner["history"].shape[2:] != (2,):
            raise ValueError(f"expected the keys of crowdnav/CrowdNav-v0, found {inner}")
        changed: dict[str, spaces.Space[Any]] = {
            key: spaces.Box(-WORLD_REACH, WORLD_REACH, inner[key].shape, np.float32)
            for key in ("history", "forecast", "forecast_modes")
            if key in inner.keys()  # noqa: SIM118 (a Dict space is no dict)
        }
        reach = np.array([WORLD_REACH, WORLD_REACH, np.pi], dtype=np.float32)
        changed |= {"robot": _robot_space(inner["robot"]), "pose": spaces.Box(-reach, reach)}
        self.observation_space: spaces.Dict = spaces.Dict(dict(inner.items()) | changed)  # type: ignore[assignment]

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
        told = {
            key: (to_world(observation[key][None], heading)[0] + position) * mask
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
            box = self.observation_space[key]
            told[key] = np.clip(values, box.low, box.high).astype(np.float32)  # type: ignore[attr-defined]
        return observation | told


def _robot_space(box: spaces.Space[Any]) -> spaces.Box:
    """The Box of the key `robot` with room for the goal's and the waypoint's world positions."""
    assert isinstance(box, spaces.Box)
    low, high = box.low.copy(), box.high.copy()
    for name in POINTS:
        at = [ROBOT_INDEX[f"{name}_x"], ROBOT_INDEX[f"{name}_y"]]
        low[at], high[at] = -WORLD_REACH, WORLD_REACH
    return spaces.Box(low, high, dtype=np.float32)
