"""What a robot policy is: observations in, actions out, many episodes at once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Observation = Mapping[str, NDArray[Any]]
"""One observation of `crowdnav/CrowdNav-v0`, or W of them stacked along a leading axis."""


class Policy(ABC):
    """Chooses actions from observations alone; it never sees the simulator.

    A policy may keep memory for each of the W episodes that it is shown side by side. `reset`
    forgets it. What a policy does in one episode does not depend on which others run beside it.
    """

    name: str

    def reset(self, mask: NDArray[np.bool_] | None = None) -> None:  # noqa: B027
        """Forgets what was remembered of finished episodes.

        Args:
            mask: (W,) True where an episode ended; None means all of them.
        """

    def act(self, observation: Observation) -> NDArray[np.float32]:
        """Chooses the next actions.

        Args:
            observation: a single observation, or a batch with a leading axis W on every key.

        Returns:
            (A,) or (W, A) actions in [-1, 1].
        """
        if np.ndim(observation["robot"]) == 2:
            return self.act_batch(observation)
        batch = {key: np.asarray(value)[None] for key, value in observation.items()}
        first: NDArray[np.float32] = self.act_batch(batch)[0]
        return first

    @abstractmethod
    def act_batch(self, observation: Observation) -> NDArray[np.float32]:
        """Chooses (W, A) actions for a batch of W observations; what `act` calls."""
