"""Weights that a training begins with: drawn at random, or those of a checkpoint."""

from dataclasses import asdict
from pathlib import Path
from typing import Final

import torch
from torch import Tensor

from predictor.checkpoint import load_checkpoint
from predictor.config import NetworkConfig
from predictor.networks import Network, build_network, name_of

NEW_FIELDS: Final = ("modes", "dropout", "forecast_steps")
"""What may differ from the checkpoint: modes are added to a trained network or left out, dropout
has no weights, and for another horizon the layers that give the paths are drawn anew."""
NEW_WEIGHTS: Final = "mode_decoder."
"""How the names of the weights begin that modes add."""


def drawn_network(config: NetworkConfig, seed: int) -> Network:
    """A network with weights drawn from `seed`."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        return build_network(config)


def continued_network(config: NetworkConfig, seed: int, checkpoint: Path) -> tuple[Network, str]:
    """A network with the weights of a checkpoint, and their SHA-256.

    Args:
        config: What the network is; as in the checkpoint, but for `NEW_FIELDS`.
        seed: Of the weights that the checkpoint does not have: modes, layers of other sizes.
        checkpoint: As `predictor.checkpoint.load_checkpoint`.

    Raises:
        FileNotFoundError: The checkpoint is not there.
        ValueError: It is damaged, or of another network.
    """
    trained, about = load_checkpoint(checkpoint)
    _require_same(checkpoint, trained.config, config)
    network = drawn_network(config, seed)
    drawn = network.state_dict()
    network.load_state_dict({**drawn, **_of_same_size(trained.state_dict(), drawn)})
    return network, str(about["sha256"])


def _of_same_size(learned: dict[str, Tensor], drawn: dict[str, Tensor]) -> dict[str, Tensor]:
    """Those of the learned weights that another network has too, and has in the same size."""
    return {
        name: weights
        for name, weights in learned.items()
        if name in drawn and weights.shape == drawn[name].shape
    }


def _require_same(checkpoint: Path, found: NetworkConfig, expected: NetworkConfig) -> None:
    there, here = ({"model": name_of(config), **asdict(config)} for config in (found, expected))
    fields = sorted((there.keys() | here.keys()) - set(NEW_FIELDS))
    odd = [key for key in fields if there.get(key) != here.get(key)]
    if odd:
        differences = "; ".join(f"{k} {there.get(k)} there, {here.get(k)} here" for k in odd)
        raise ValueError(f"{checkpoint}: expected weights of the same network, found {differences}")
