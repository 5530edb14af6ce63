"""A trained policy that acts: any algorithm of `envs.policies.networks`, from its folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from envs.config import CrowdNavConfig
from envs.policies.policy import Observation, Policy
from envs.policies.policy_files import (
    boxes,
    check_fits,
    load_weights,
    make_network,
    read_description,
)

ROW_MULTIPLE: Final = 8
"""Float32 matrix products have bit-equal rows when their number is a multiple of this."""


class LearnedPolicy(Policy):
    """A policy that `save_policy` wrote; it takes the mean of its distribution of actions.

    One with an LSTM remembers each world's episode, until `reset`.

    Args:
        folder: Where `save_policy` wrote to.
        config: Configuration of the environment that it will act in; None skips the comparison
            with the one that it was trained in.

    Raises:
        ValueError: The folder holds no such policy, it is damaged, or it does not fit `config`.
    """

    def __init__(self, folder: Path, config: CrowdNavConfig | None = None) -> None:
        self.description = read_description(folder)
        if config is not None:
            check_fits(self.description, config, folder)
        self.name = self.description["algorithm"]
        self._network = make_network(self.description)
        load_weights(self._network, folder, self.description)
        self._memory: tuple[NDArray[Any], ...] | None = None  # (layers, W, hidden) each, or nothing

    def reset(self, mask: NDArray[np.bool_] | None = None) -> None:
        """Forgets finished episodes; see `Policy.reset`."""
        if mask is None:
            self._memory = None
        elif self._memory is not None:
            for part in self._memory:
                part[:, mask] = 0.0  # what an LSTM starts with

    def act_batch(self, observation: Observation) -> NDArray[np.float32]:
        """Returns (W, A) mean actions; see `Policy.act`.

        Raises:
            ValueError: A key that the policy was trained with is missing.
        """
        keys = boxes(self._network)
        missing = sorted(set(keys) - set(observation))
        if missing:
            raise ValueError(
                f"the policy was trained with {', '.join(missing)}; "
                f"the observation has only {', '.join(observation)}"
            )
        worlds = len(observation["robot"])
        spare = -worlds % ROW_MULTIPLE
        actions, memory = self._network.predict(
            {key: _padded(observation[key], spare, axis=0) for key in keys},
            state=self._remembered(worlds, spare),
            deterministic=True,
        )
        if memory is not None:
            self._memory = tuple(part[:, :worlds] for part in memory)
        return np.asarray(actions[:worlds], np.float32)

    def _remembered(self, worlds: int, spare: int) -> tuple[NDArray[Any], ...] | None:
        """Returns what is remembered of as many worlds; None lets the network begin anew."""
        if self._memory is None or self._memory[0].shape[1] != worlds:
            return None
        return tuple(_padded(part, spare, axis=1) for part in self._memory)


def _padded(values: NDArray[Any], count: int, axis: int) -> NDArray[Any]:
    """Appends zeros along an axis."""
    shape = list(values.shape)
    shape[axis] = count
    return np.concatenate((values, np.zeros(shape, values.dtype)), axis=axis)
