"""Weights that a training begins with: drawn at random, or those of a checkpoint."""

from dataclasses import asdict
from pathlib import Path
from typing import Final

import torch

from predictor.checkpoint import load_checkpoint
from predictor.config import NetworkConfig
from predictor.networks import Network, build_network, name_of

NEW_FIELDS: Final = ("modes", "dropout")
"""What may differ from the checkpoint: modes are added to a trained network, and dropout has no
weights."""
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
        seed: Of the weights of modes that the checkpoint does not have.
        checkpoint: As `predictor.checkpoint.load_checkpoint`.

    Raises:
        FileNotFoundError: The checkpoint is not there.
        ValueError: It is damaged, or of another network.
    """
    trained, about = load_checkpoint(checkpoint)
    _require_same(checkpoint, trained.config, config)
    network = drawn_network(config, seed)
    odd = network.load_state_dict(trained.state_dict(), strict=False)
    missing = [name for name in odd.missing_keys if not name.startswith(NEW_WEIGHTS)]
    if missing or odd.unexpected_keys:
        raise ValueError(
            f"{checkpoint}: expected the weights of the network to be trained, "
            f"found them to differ in {(missing + odd.unexpected_keys)[:4]}"
        )
    return network, str(about["sha256"])


def _require_same(checkpoint: Path, found: NetworkConfig, expected: NetworkConfig) -> None:
    there, here = ({"model": name_of(config), **asdict(config)} for config in (found, expected))
    fields = sorted((there.keys() | here.keys()) - set(NEW_FIELDS))
    odd = [key for key in fields if there.get(key) != here.get(key)]
    if odd:
        differences = "; ".join(f"{k} {there.get(k)} there, {here.get(k)} here" for k in odd)
        raise ValueError(f"{checkpoint}: expected weights of the same network, found {differences}")
