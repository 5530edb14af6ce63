"""All that a training needs to go on where it was killed, in one file.

Randomness needs no place in it: what is drawn for a batch follows from the seed, the epoch and the
number of the batch alone (`batch_generator`).
"""

import hashlib
import json
import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.torch import load as load_safetensors
from safetensors.torch import save as save_safetensors
from torch import Tensor

from crowdsim.recordings.store import write_atomic

FILE: Final = "resume.state"
DIGEST_BYTES: Final = hashlib.sha256().digest_size


@dataclass(kw_only=True)
class Place:
    """Where a training stands.

    Attributes:
        epoch: The epoch under way, counted from 1.
        batch: Batches of it that are done.
        best_epoch: The epoch that was best on validation; 0 before the first.
        best: Its `ade` and `fde` on validation [m], and `nll` [nat] if it has modes.
    """

    epoch: int = 1
    batch: int = 0
    best_epoch: int = 0
    best: dict[str, float] = field(default_factory=lambda: {"ade": math.inf, "fde": math.inf})

    def step(self, batches: int) -> int:
        """Batches done since the beginning, with so many batches in an epoch."""
        return (self.epoch - 1) * batches + self.batch

    def finish_epoch(self, scores: dict[str, float]) -> bool:
        """Note the validation of the epoch under way; True if it is the best until now."""
        better = score(scores) < score(self.best)
        if better:
            self.best, self.best_epoch = scores, self.epoch
        self.epoch, self.batch = self.epoch + 1, 0
        return better

    def is_over(self, epochs: int, patience: int | None) -> bool:
        """True after the last epoch, and after `patience` epochs without a better one."""
        idle = self.epoch - 1 - self.best_epoch
        return self.epoch > epochs or (patience is not None and idle >= patience)


def score(scores: dict[str, float]) -> tuple[float, float]:
    """What the best epoch is chosen by: the loss of the paper; between equals, that of the modes.

    Epochs are equal where modes are all that is trained.
    """
    return scores["ade"] + 0.5 * scores["fde"], scores.get("nll", 0.0)


def epoch_order(count: int, seed: int, epoch: int) -> NDArray[np.int64]:
    """Order of the windows in an epoch."""
    return _generator(seed, 0, epoch).permutation(count)


def batch_generator(seed: int, epoch: int, batch: int, rank: int = 0) -> np.random.Generator:
    """Generator of what is drawn for a batch, after seeding torch's (dropout) for it too.

    Processes of several ranks draw alike from it, but drop out each in its own way.
    """
    rng = _generator(seed, 1, epoch, batch)
    torch.manual_seed(int(rng.integers(2**63)) + rank)
    return rng


def _generator(seed: int, *key: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))


def save_state(path: Path, place: Place, about: dict[str, Any], parts: dict[str, Any]) -> None:
    """Write the state of a training, whole or not at all.

    Args:
        path: File to write.
        place: Where the training stands.
        about: What the training is, JSON-able; `load_state` refuses another one.
        parts: The `state_dict` of network, optimizer, and so on, by name.
    """
    tensors: dict[str, Tensor] = {}
    tree = _split(parts, "", tensors)
    text = json.dumps({"place": asdict(place), "about": about, "tree": tree})
    content = save_safetensors(tensors, metadata={"state": text})
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, content + hashlib.sha256(content).digest())


def load_state(path: Path, about: dict[str, Any]) -> tuple[Place, dict[str, Any]]:
    """Read what `save_state` wrote: the place, and the `state_dict`s by name.

    Raises:
        ValueError: The file is damaged, or of a training that is not `about` the same.
    """
    content = path.read_bytes()
    if hashlib.sha256(content[:-DIGEST_BYTES]).digest() != content[-DIGEST_BYTES:]:
        raise ValueError(f"{path}: damaged, its SHA-256 differs; train without resuming")
    try:
        tensors = load_safetensors(content[:-DIGEST_BYTES])
    except SafetensorError as error:
        raise ValueError(f"{path}: expected safetensors, found {error}") from error
    header = json.loads(content[8 : 8 + int.from_bytes(content[:8], "little")])
    state = json.loads(header["__metadata__"]["state"])
    _require_same(path, state["about"], json.loads(json.dumps(about)))
    return Place(**state["place"]), _joined(state["tree"], tensors)


def _require_same(path: Path, found: dict[str, Any], expected: dict[str, Any]) -> None:
    other = sorted(k for k in found | expected if found.get(k) != expected.get(k))
    if other:
        differences = "; ".join(f"{k} {found.get(k)} there, {expected.get(k)} here" for k in other)
        raise ValueError(f"{path}: expected the same training to go on with, found {differences}")


def _split(value: Any, name: str, tensors: dict[str, Tensor]) -> Any:
    """The value as JSON has it, its tensors moved to `tensors` and named in their places."""
    if isinstance(value, Tensor):
        tensors[name] = value.detach().cpu().contiguous()
        return {"tensor": name}
    if isinstance(value, dict):
        items = [[key, _split(item, f"{name}/{key}", tensors)] for key, item in value.items()]
        return {"items": items}
    if isinstance(value, list | tuple):
        return [_split(item, f"{name}/{i}", tensors) for i, item in enumerate(value)]
    return value


def _joined(tree: Any, tensors: dict[str, Tensor]) -> Any:
    """Undo `_split`; tuples come back as lists."""
    if isinstance(tree, list):
        return [_joined(item, tensors) for item in tree]
    if isinstance(tree, dict):
        if "tensor" in tree:
            return tensors[tree["tensor"]]
        return {key: _joined(item, tensors) for key, item in tree["items"]}
    return tree
