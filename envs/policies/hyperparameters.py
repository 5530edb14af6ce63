"""Hyperparameters of the algorithms, from the files that RL Zoo reads as well."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import yaml

ZOO: Final = Path(__file__).parent / "zoo"
ENVIRONMENT: Final = "crowdnav/CrowdNav-v0"


@dataclass(frozen=True, kw_only=True)
class Hyperparameters:
    """What a policy is trained with unless told otherwise; all of it fits into JSON.

    Attributes:
        algorithm: Name in `envs.policies.networks.ALGORITHMS`.
        environments: Environments side by side.
        steps: Environment steps of all of them together.
        normalize: Keywords of Stable-Baselines3's `VecNormalize`, apart from the discount; None
            leaves observations and rewards as they are.
        keywords: Of the algorithm's class in Stable-Baselines3; a learning rate `lin_0.001` falls
            from 0.001 to 0 in a straight line.
    """

    algorithm: str
    environments: int
    steps: int
    normalize: Mapping[str, Any] | None
    keywords: Mapping[str, Any]


def read_hyperparameters(algorithm: str) -> Hyperparameters:
    """Reads `zoo/ALGORITHM.yml`; its network is the one of `envs.policies.networks`."""
    content = yaml.safe_load((ZOO / f"{algorithm}.yml").read_text())
    keywords = {name: value for name, value in content[ENVIRONMENT].items() if name != "policy"}
    return Hyperparameters(
        algorithm=algorithm,
        environments=keywords.pop("n_envs"),
        steps=keywords.pop("n_timesteps"),
        normalize=keywords.pop("normalize", None),
        keywords=keywords,
    )
