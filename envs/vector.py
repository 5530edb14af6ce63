"""Many episodes behind Gymnasium's vector interface: one process, one batch, no copies of it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from envs.autoreset import SAME_STEP
from envs.config import make_config
from envs.crowd_nav import CrowdNav
from envs.episodes import Episodes, StepResult
from envs.observation import Observation, flattened, flattened_space
from envs.rendering import render_world
from envs.robots import action_space
from envs.trace import Trace

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


class CrowdNavVector(VectorEnv[Observation, NDArray[np.float32], NDArray[Any]]):
    """W environments `crowdnav/CrowdNav-v0`, stepped together.

    Sub-environment i after `reset(seed=s)` is, bit for bit, the single environment after
    `reset(seed=s + i)`. An episode that ends starts anew within the same step
    (`AutoresetMode.SAME_STEP`); its last observation and info are in `final_obs` and
    `final_info`. Time limits are applied here: no TimeLimit wrapper belongs around it.
    """

    metadata = CrowdNav.metadata | {"autoreset_mode": SAME_STEP}
    flat = False

    def __init__(
        self,
        num_envs: int = 1,
        *,
        render_mode: str | None = None,
        record: bool = False,
        **keywords: Any,
    ):
        """Builds W = `num_envs` environments; keywords as for `CrowdNav`.

        Raises:
            ValueError: An unknown keyword or a bad value.
        """
        config = make_config(**keywords)
        self.num_envs = num_envs
        self.render_mode = render_mode
        self.metadata = self.metadata | {"render_fps": round(1.0 / config.policy_dt)}
        self.episodes = Episodes(config, num_envs, record=record)
        space = self.episodes.observer.space
        self.single_observation_space = flattened_space(space) if self.flat else space
        self.single_action_space = action_space(config)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._generators: list[np.random.Generator] = [
            seeding.np_random()[0] for _ in range(num_envs)
        ]

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Starts W episodes; there are no options.

        Args:
            seed: One for each sub-environment, or s for s, s + 1, ...; None goes on with the
                random streams that are there.
            options: Ignored.

        Raises:
            ValueError: Another number of seeds than environments.
        """
        for world, own in enumerate(self._seeds(seed)):
            if own is not None:
                self._generators[world], _ = seeding.np_random(own)
        return self._shaped(self.episodes.reset(self._generators)), {}

    def step(self, actions: ArrayLike) -> tuple[Observation, Floats, Flags, Flags, dict[str, Any]]:
        """Runs one policy period in every world; see `gymnasium.vector.VectorEnv.step`.

        Raises:
            ValueError: The actions (W, 2) have the wrong shape, are not of real numbers, or not
                finite.
            ResetNeeded: Before the first reset.
        """
        result = self.episodes.step(actions)
        ended = result.terminated | result.truncated
        observation = self._shaped(result.observation)
        info = masked({"rewards": result.rewards}, ~ended)
        if ended.any():
            info = self._final(observation, result, ended) | info
            self._restart(observation, np.flatnonzero(ended))
        return observation, result.reward, result.terminated, result.truncated, info

    def pop_traces(self) -> dict[int, Trace]:
        """Returns, by sub-environment, the traces of episodes that ended, and forgets them."""
        return self.episodes.pop_traces()

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Returns a picture of each world, or None without a render mode."""
        if self.render_mode is None:
            return None
        return tuple(render_world(self.episodes, world) for world in range(self.num_envs))

    def _seeds(self, seed: int | Sequence[int | None] | None) -> list[int | None]:
        if seed is None:
            return [None] * self.num_envs
        if isinstance(seed, int):
            return [seed + world for world in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise ValueError(f"expected {self.num_envs} seeds, found {len(seed)}")
        return list(seed)

    def _shaped(self, observation: Observation) -> Observation:
        return flattened(observation, leading=1) if self.flat else observation

    def _final(self, observation: Observation, result: StepResult, ended: Flags) -> dict[str, Any]:
        """What the episodes that ended leave behind, as Gymnasium's vector environments say it."""
        final_obs = np.full(self.num_envs, None, dtype=object)
        for world in np.flatnonzero(ended):
            final_obs[world] = {key: values[world].copy() for key, values in observation.items()}
        reason = np.array(result.reason, dtype=object)
        final_info = masked(
            {
                "rewards": result.rewards,
                "is_success": reason == "goal",
                "termination_reason": reason,
                "forecast_seconds": result.forecast_seconds,
            },
            ended,
        )
        return {
            "final_obs": final_obs,
            "_final_obs": ended.copy(),
            "final_info": final_info,
            "_final_info": ended.copy(),
        }

    def _restart(self, observation: Observation, rows: NDArray[np.intp]) -> None:
        """Resets the worlds `rows` and puts their first observations in place of the last."""
        generators = [self._generators[row] for row in rows]
        for key, values in self._shaped(self.episodes.reset(generators, rows.tolist())).items():
            observation[key][rows] = values


class CrowdNavFlatVector(CrowdNavVector):
    """W environments `crowdnav/CrowdNavFlat-v0`, stepped together."""

    flat = True


def masked(values: Mapping[str, Any], mask: Flags) -> dict[str, Any]:
    """Writes infos (W,) as Gymnasium's vector environments do: `_key` says where `key` is set.

    Where it is not set stands zero, or None for objects. Empty if the mask is.
    """
    info: dict[str, Any] = {}
    if not mask.any():
        return info
    for key, value in values.items():
        if isinstance(value, Mapping):
            info[key] = masked(value, mask)
        else:
            info[key] = value.copy()
            info[key][~mask] = None if value.dtype == object else 0
        info[f"_{key}"] = mask.copy()
    return info
