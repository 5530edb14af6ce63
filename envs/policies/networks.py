"""Stable-Baselines3's networks behind `CrowdFeatures`, and which algorithm trains which.

They are classes of their own so that a name in a file of hyperparameters is all that RL Zoo needs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from sb3_contrib import TQC, RecurrentPPO
from sb3_contrib.common.recurrent.policies import RecurrentMultiInputActorCriticPolicy
from sb3_contrib.tqc.policies import MultiInputPolicy as TQCMultiInputPolicy
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import BasePolicy, MultiInputActorCriticPolicy
from stable_baselines3.sac.policies import MultiInputPolicy as SACMultiInputPolicy

from envs.policies.crowd_features import CrowdFeatures


class SeesPeople:
    """Takes `CrowdFeatures` unless told otherwise; stands before a policy class of SB3."""

    def __init__(self, *spaces: Any, **keywords: Any) -> None:
        super().__init__(*spaces, **({"features_extractor_class": CrowdFeatures} | keywords))


class PPONetwork(SeesPeople, MultiInputActorCriticPolicy):
    """Actor and critic on the same features."""


class RecurrentPPONetwork(SeesPeople, RecurrentMultiInputActorCriticPolicy):
    """Actor and critic on the same features, each with an LSTM of its own."""


class SACNetwork(SeesPeople, SACMultiInputPolicy):
    """An actor and two critics, each with features of its own."""


class TQCNetwork(SeesPeople, TQCMultiInputPolicy):
    """An actor and critics of the return's quantiles, each with features of its own."""


@dataclass(frozen=True, kw_only=True)
class Algorithm:
    """One way to train a policy.

    Attributes:
        model: What trains.
        network: What it trains.
        actor: The part of the network that is kept and acts; empty for all of it.
    """

    model: type[BaseAlgorithm]
    network: type[BasePolicy]
    actor: str = ""


ALGORITHMS: Final = {
    "ppo": Algorithm(model=PPO, network=PPONetwork),
    "recurrent_ppo": Algorithm(model=RecurrentPPO, network=RecurrentPPONetwork),
    "sac": Algorithm(model=SAC, network=SACNetwork, actor="actor"),
    "tqc": Algorithm(model=TQC, network=TQCNetwork, actor="actor"),
}
"""What `crowdnav train-policy --algorithm` takes."""
