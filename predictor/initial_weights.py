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
"""What may differ from the checkpoint: modes are added to a trained network, dropout has no
weights, and for another horizon the layers that give the paths are drawn anew."""
NEW_WEIGHTS: Final = "mode_decoder."


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
    learned = trained.state_dict()
    missing = [
        name for name in network.state_dict().keys() - learned if not name.startswith(NEW_WEIGHTS)
    ]
    unexpected = learned.keys() - network.state_dict()
    if missing or unexpected:
        raise ValueError(
            f"{checkpoint}: expected the weights of the network to be trained, "
            f"found them to differ in {sorted([*missing, *unexpected])[:4]}"
        )
    network.load_state_dict({**network.state_dict(), **_of_same_size(learned, network)})
    return network, str(about["sha256"])


def _of_same_size(learned: dict[str, Tensor], network: Network) -> dict[str, Tensor]:
    """The learned weights that have the sizes of those of `network`."""
    sizes = {name: drawn.shape for name, drawn in network.state_dict().items()}
    return {name: weights for name, weights in learned.items() if weights.shape == sizes[name]}


def _require_same(checkpoint: Path, found: NetworkConfig, expected: NetworkConfig) -> None:
    there, here = ({"model": name_of(config), **asdict(config)} for config in (found, expected))
    fields = sorted((there.keys() | here.keys()) - set(NEW_FIELDS))
    odd = [key for key in fields if there.get(key) != here.get(key)]
    if odd:
        differences = "; ".join(f"{k} {there.get(k)} there, {here.get(k)} here" for k in odd)
        raise ValueError(f"{checkpoint}: expected weights of the same network, found {differences}")
