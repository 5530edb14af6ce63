"""Checkpoints: weights as safetensors, all else as JSON beside them. Nothing is unpickled."""

import hashlib
import json
import subprocess
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError
from safetensors.torch import load as load_safetensors
from safetensors.torch import save as save_safetensors

from crowdsim.recordings.store import write_atomic
from predictor.networks import Network, build_network, config_from_dict, name_of

FORMAT = "crowdnav-predictor-2"
OLDER_FORMAT = "iterative-attention-1"
"""Named no model, as there was one only."""


def save_checkpoint(path: Path, network: Network, about: dict[str, Any]) -> None:
    """Write `path` (.safetensors) and the JSON beside it, each whole or not at all.

    Args:
        path: File to write; its suffix must be `.safetensors`.
        network: What to keep.
        about: JSON-able facts: data, protocol, metrics, the command.
    """
    weights = save_safetensors({k: v.contiguous() for k, v in network.state_dict().items()})
    description = {
        "format": FORMAT,
        "model": name_of(network.config),
        "config": asdict(network.config),
        "parameters": sum(p.numel() for p in network.parameters()),
        "sha256": hashlib.sha256(weights).hexdigest(),
        "revision": source_revision(),
        **about,
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, weights)
    write_atomic(path.with_suffix(".json"), json.dumps(description, indent=1).encode() + b"\n")


def load_checkpoint(path: Path) -> tuple[Network, dict[str, Any]]:
    """Read a checkpoint, ready for use (`eval` mode).

    Args:
        path: A `.safetensors` file with its JSON beside it, or a folder with `best.safetensors`.

    Returns:
        The network, and what its JSON says.

    Raises:
        FileNotFoundError: One of the two files is not there.
        ValueError: The files are damaged, do not belong together, or do not fit the model.
    """
    path = path / "best.safetensors" if path.is_dir() else path
    description = _read_description(path.with_suffix(".json"))
    weights = path.read_bytes()
    found = hashlib.sha256(weights).hexdigest()
    if found != description["sha256"]:
        raise ValueError(
            f"{path}: damaged, expected SHA-256 {description['sha256'][:12]}…, found {found[:12]}…"
        )
    with torch.random.fork_rng(devices=[]):
        network = build_network(config_from_dict(description["model"], description["config"]))
    _load_state(network, _read_state(weights, path), path)
    return network.eval(), description


def _read_description(path: Path) -> dict[str, Any]:
    try:
        description = json.loads(path.read_text(encoding="utf-8"))
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: expected JSON, found {error}") from error
    if not isinstance(description, dict) or description.get("format") not in (
        FORMAT,
        OLDER_FORMAT,
    ):
        raise ValueError(f"{path}: expected the description of a checkpoint of format {FORMAT!r}")
    if description["format"] == OLDER_FORMAT:
        description["model"] = "iterative_attention"
    for key, kind in (("model", str), ("sha256", str), ("config", dict)):
        if not isinstance(description.get(key), kind):
            raise ValueError(f"{path}: expected the key {key!r} with a {kind.__name__}")
    return description


def _read_state(weights: bytes, path: Path) -> dict[str, torch.Tensor]:
    try:
        return load_safetensors(weights)
    except SafetensorError as error:
        raise ValueError(f"{path}: expected safetensors, found {error}") from error


def _load_state(network: Network, state: dict[str, torch.Tensor], path: Path) -> None:
    expected = network.state_dict()
    if state.keys() != expected.keys():
        odd = sorted(state.keys() ^ expected.keys())
        raise ValueError(f"{path}: weights and config differ in {odd[:4]}")
    for name, tensor in state.items():
        if tensor.shape != expected[name].shape or tensor.dtype != expected[name].dtype:
            raise ValueError(
                f"{path}: {name} must be {tuple(expected[name].shape)} {expected[name].dtype}, "
                f"found {tuple(tensor.shape)} {tensor.dtype}"
            )
        if not torch.isfinite(tensor).all():
            raise ValueError(f"{path}: {name} must be finite")
    network.load_state_dict(state)


@cache
def source_revision() -> str:
    """Git commit of this source tree, or `unknown` outside of a checkout."""
    try:
        found = subprocess.run(
            ["git", "rev-parse", "--verify", "HEAD"],
            cwd=Path(__file__).parent,
            capture_output=True,
            text=True,
            check=True,
            timeout=5,
        )
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    return found.stdout.strip()
