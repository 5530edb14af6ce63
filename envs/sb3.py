"""The vector environment as Stable-Baselines3 wants it."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from envs.autoreset import SAME_STEP
from envs.observation import Observation


class SB3VecEnv(VecEnv):
    """Adapts a natively batched vector environment to SB3's `VecEnv`; put `VecMonitor` around it.

    Infos of running episodes are empty. That of an episode that ended holds its final info,
    `terminal_observation` and `TimeLimit.truncated`.
    """

    def __init__(self, env: VectorEnv[Observation, NDArray[np.float32], NDArray[Any]]):
        """Wraps `env`.

        Raises:
            ValueError: `env` does not reset within the step in which an episode ends.
        """
        if env.metadata.get("autoreset_mode") != SAME_STEP:
            raise ValueError(
                "env must have the autoreset mode SAME_STEP, "
                f"got {env.metadata.get('autoreset_mode')}"
            )
        self.env = env
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> Observation:
        """Starts all episodes, with the seeds that `seed` has set."""
        seeds: Any = self._seeds  # Gymnasium's annotation leaves out the list that it documents
        observation, _ = self.env.reset(seed=seeds)
        self._reset_seeds()
        self._reset_options()
        return observation

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Keeps the actions for `step_wait`."""
        self._actions = actions

    def step_wait(
        self,
    ) -> tuple[Observation, NDArray[np.float64], NDArray[np.bool_], list[dict[str, Any]]]:
        """Takes the step; see `stable_baselines3.common.vec_env.VecEnv.step_wait`."""
        observation, reward, terminated, truncated, info = self.env.step(self._actions)
        ended = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for world in np.flatnonzero(ended).tolist():
            infos[world] = _unstacked(info["final_info"], world) | {
                "terminal_observation": info["final_obs"][world],
                "TimeLimit.truncated": bool(truncated[world] and not terminated[world]),
            }
        return observation, reward, ended, infos

    def close(self) -> None:
        """Closes the environment."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Returns the attribute of the vector environment once per asked sub-environment."""
        return [getattr(self.env, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuses: the sub-environments have no attributes of their own."""
        raise NotImplementedError("the sub-environments of a batched environment share attributes")

    def env_method(
        self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any
    ) -> list[Any]:
        """Refuses: the sub-environments have no methods of their own."""
        raise NotImplementedError("the sub-environments of a batched environment share methods")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Returns False for each: nothing can be wrapped around one sub-environment."""
        return [False for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[Any]:
        """Returns a picture (H, W, 3) of each world, or None without a render mode."""
        frames = self.env.render()
        return [None] * self.num_envs if frames is None else list(frames)


def _unstacked(info: dict[str, Any], world: int) -> dict[str, Any]:
    """One world's entries of a vector info."""
    own = {}
    for key, values in info.items():
        if not key.startswith("_") and info[f"_{key}"][world]:
            own[key] = (
                _unstacked(values, world) if isinstance(values, dict) else _item(values[world])
            )
    return own


def _item(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value
