"""Training: windows from recordings, a flat epoch loop, the best and the last checkpoint."""

import math
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.optim.lr_scheduler import LRScheduler, OneCycleLR, StepLR
from tqdm import tqdm

from predictor.augment import augmented_batch
from predictor.checkpoint import save_checkpoint
from predictor.config import ModelConfig, TrainConfig
from predictor.datasets import describe, read_training
from predictor.inputs import AgentInputs
from predictor.metrics import ade, displacement_errors, fde
from predictor.model import IterativeAttention, loss, tensors
from predictor.windows import Windows, extract_windows


@dataclass(frozen=True, kw_only=True)
class TrainResult:
    """What a training came to.

    Attributes:
        checkpoint: Best checkpoint on validation.
        best_epoch: Its epoch, counted from 1.
        validation: Its `ade` and `fde` on validation [m].
        constant_velocity: Those of constant velocity on the same windows [m].
        windows: Number of training windows.
        windows_per_s: Training windows per second of wall clock, data included.
    """

    checkpoint: Path
    best_epoch: int
    validation: dict[str, float]
    constant_velocity: dict[str, float]
    windows: int
    windows_per_s: float


def train(
    *,
    data: str,
    out: Path,
    model: ModelConfig,
    training: TrainConfig,
    command: str = "",
    progress: bool = True,
) -> TrainResult:
    """Train a network and write `best` and `last` (`.safetensors` and `.json`) into a folder.

    Args:
        data: As `predictor.datasets.read_training`.
        out: Folder to write to.
        model: What the network is.
        training: How it is trained.
        command: The command line, to be kept in the checkpoint.
        progress: Show a progress bar with the time left.

    Raises:
        FileNotFoundError: The data is not there.
        ValueError: The data is unfit (no windows, another `dt`, a single recording).
        FloatingPointError: The loss is no longer finite.
    """
    rng = np.random.default_rng(training.seed)
    train_recordings, validation_recordings = read_training(data)
    windows = extract_windows(
        train_recordings, model, stride=training.stride, truncate=training.truncate, rng=rng
    )
    validation = extract_windows(validation_recordings, model, stride=training.stride)
    about = {
        "command": command,
        "training": asdict(training),
        "data": {
            "source": data,
            "made_by": describe(data),
            "train_recordings": len(train_recordings),
            "train_windows": len(windows),
            "validation_recordings": len(validation_recordings),
            "validation_windows": len(validation),
        },
        "protocol": "windows of consecutive listed frames; agents present in all of them; "
        "epoch chosen by validation ade + fde / 2; forecasts with the predicted goal",
    }
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(training.seed)
        network = IterativeAttention(model)
        return fit(
            network, windows, validation, training, out=out, rng=rng, about=about, progress=progress
        )


def fit(
    network: IterativeAttention,
    windows: Windows,
    validation: Windows,
    training: TrainConfig,
    *,
    out: Path,
    rng: np.random.Generator,
    about: dict[str, Any],
    progress: bool = True,
) -> TrainResult:
    """The epoch loop of `train`: from windows to checkpoints.

    Raises:
        FloatingPointError: The loss is no longer finite.
    """
    steps = math.ceil(len(windows) / training.batch_size)
    optimizer, scheduler = _optimizer(network, training, steps)
    baseline = evaluate_constant_velocity(validation)
    best, best_epoch = {"ade": math.inf, "fde": math.inf}, 0
    bar = tqdm(total=training.epochs * steps, unit="batch", disable=not progress)
    started = time.perf_counter()
    for epoch in range(1, training.epochs + 1):
        network.train()
        for rows in _batches(len(windows), training.batch_size, rng):
            inputs, future = augmented_batch(windows, rows, training, rng)
            objective = _objective(network, inputs, future, true_goal=training.true_goal)
            _require_finite(objective, epoch)
            optimizer.zero_grad()
            objective.backward()  # type: ignore[no-untyped-call]
            torch.nn.utils.clip_grad_norm_(network.parameters(), training.gradient_clip)
            optimizer.step()
            scheduler.step()
            bar.update()
        scores = evaluate_windows(network, validation)
        metrics = {"epoch": epoch, "validation": scores, "constant_velocity": baseline}
        save_checkpoint(out / "last.safetensors", network, {**about, "metrics": metrics})
        if _score(scores) < _score(best):
            best, best_epoch = scores, epoch
            save_checkpoint(out / "best.safetensors", network, {**about, "metrics": metrics})
        bar.set_postfix(epoch=epoch, ade=f"{scores['ade']:.3f}", fde=f"{scores['fde']:.3f}")
    bar.close()
    return TrainResult(
        checkpoint=out / "best.safetensors",
        best_epoch=best_epoch,
        validation=best,
        constant_velocity=baseline,
        windows=len(windows),
        windows_per_s=training.epochs * len(windows) / (time.perf_counter() - started),
    )


def _objective(
    network: IterativeAttention,
    inputs: AgentInputs,
    future: NDArray[np.float32],
    *,
    true_goal: bool,
) -> Tensor:
    true_path = torch.from_numpy(future)
    goal, path = network(**tensors(inputs), true_goal=true_path[:, -1] if true_goal else None)
    return loss(goal, path, true_path)


def _require_finite(objective: Tensor, epoch: int) -> None:
    if not torch.isfinite(objective):
        raise FloatingPointError(
            f"expected a finite loss, found {objective.item()} in epoch {epoch}: "
            "lower learning_rate or gradient_clip"
        )


def _score(scores: dict[str, float]) -> float:
    """What the best epoch is chosen by: the loss of the paper."""
    return scores["ade"] + 0.5 * scores["fde"]


def _optimizer(
    network: IterativeAttention, training: TrainConfig, steps: int
) -> tuple[torch.optim.Optimizer, LRScheduler]:
    """Optimizer, and the schedule that is stepped after each of the `steps` batches of an epoch."""
    rate = training.learning_rate
    if training.schedule == "step":
        adam = torch.optim.Adam(network.parameters(), lr=rate, fused=True)
        return adam, StepLR(adam, step_size=30 * steps, gamma=0.2)
    adamw = torch.optim.AdamW(network.parameters(), lr=rate, fused=True)
    return adamw, OneCycleLR(adamw, max_lr=rate, total_steps=training.epochs * steps)


def _batches(count: int, size: int, rng: np.random.Generator) -> Iterator[NDArray[np.int64]]:
    order = rng.permutation(count)
    for start in range(0, count, size):
        yield order[start : start + size]


def evaluate_windows(network: IterativeAttention, windows: Windows) -> dict[str, float]:
    """`ade` and `fde` [m] of a network on windows, with the goals that it predicts."""
    network.eval()
    errors = []
    with torch.inference_mode():
        for rows in np.array_split(np.arange(len(windows)), math.ceil(len(windows) / 256)):
            inputs, future = windows.batch(rows)
            _, path = network(**tensors(inputs))
            errors.append(displacement_errors(path.numpy(), future))
    joined = np.concatenate(errors)
    return {"ade": ade(joined), "fde": fde(joined)}


def evaluate_constant_velocity(windows: Windows) -> dict[str, float]:
    """`ade` and `fde` [m] of constant velocity on the same windows."""
    ahead = np.arange(1, windows.config.forecast_steps + 1, dtype=np.float32)[:, None]
    path = windows.inputs.last_step[:, None] * ahead
    errors = displacement_errors(path, windows.future)
    return {"ade": ade(errors), "fde": fde(errors)}
