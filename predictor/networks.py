"""The networks that can be trained, by the name that a command and a checkpoint give them."""

from dataclasses import dataclass, replace
from typing import Any, Final, TypeAlias, TypeGuard

from predictor.baselines.history_mlp import HistoryMlp, HistoryMlpConfig
from predictor.baselines.lstm import Lstm, LstmConfig
from predictor.baselines.social_lstm import SocialLstm, SocialLstmConfig
from predictor.config import (
    ConfigName,
    ModelConfig,
    ModelName,
    NetworkConfig,
    TrainConfig,
    Variant,
    named_configuration,
)
from predictor.model import IterativeAttention

Network: TypeAlias = IterativeAttention | HistoryMlp | Lstm | SocialLstm
"""Each takes what `predictor.tensors.tensors` gives and returns a goal and a path."""


@dataclass(frozen=True, kw_only=True)
class Architecture:
    """A network that can be trained.

    Attributes:
        network: Its class.
        config: The class of its configuration.
    """

    network: type[Network]
    config: type[NetworkConfig]


NETWORKS: Final[dict[str, Architecture]] = {
    "iterative_attention": Architecture(network=IterativeAttention, config=ModelConfig),
    "history_mlp": Architecture(network=HistoryMlp, config=HistoryMlpConfig),
    "lstm": Architecture(network=Lstm, config=LstmConfig),
    "social_lstm": Architecture(network=SocialLstm, config=SocialLstmConfig),
}


def build_network(config: NetworkConfig) -> Network:
    """A network of the kind that `config` is of, with weights drawn from torch's generator."""
    network: Any = NETWORKS[name_of(config)].network
    built: Network = network(config)
    return built


def has_modes(network: Network) -> TypeGuard[IterativeAttention]:
    """Whether a network forecasts modes besides its one path."""
    return isinstance(network, IterativeAttention) and network.mode_decoder is not None


def name_of(config: NetworkConfig) -> str:
    """Name of the kind of network that a configuration is of; key of `NETWORKS`."""
    return next(name for name, kind in NETWORKS.items() if kind.config is type(config))


def config_from_dict(name: str, values: dict[str, Any]) -> NetworkConfig:
    """Configuration of the network called `name` from a plain dict.

    Raises:
        ValueError: The name or a key is unknown, or a value is out of range.
    """
    if name not in NETWORKS:
        raise ValueError(f"model must be one of {', '.join(NETWORKS)}, got {name!r}")
    return NETWORKS[name].config.from_dict(values)


def configuration(
    model: ModelName,
    config_name: ConfigName,
    *,
    variant: Variant = "none",
    modes: int = 0,
    seed: int = 0,
    epochs: int | None = None,
) -> tuple[NetworkConfig, TrainConfig]:
    """Configuration of any network and of its training, as `named_configuration` gives them.

    A baseline is trained like the iterative-attention network of that configuration, and corrects
    constant velocity where that does; it has no goal of its own to be given the true one for.

    Raises:
        ValueError: A name is unknown, a value is out of range, or a map or modes are asked of who
            has none.
    """
    ours, training = named_configuration(config_name, variant=variant, seed=seed, epochs=epochs)
    if model == "iterative_attention":
        return replace(ours, modes=modes), training
    if modes != 0:
        raise ValueError(f"modes must be 0 for {model}, which forecasts one path, got {modes}")
    baseline = config_from_dict(model, {"variant": variant, "residual": ours.residual})
    return baseline, replace(training, true_goal=False)
