"""Training: windows from recordings, a flat epoch loop, the best and the last checkpoint."""

import math
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from tqdm import tqdm

from predictor.augment import augmented_batch
from predictor.backbones import with_pretrained
from predictor.checkpoint import save_checkpoint
from predictor.config import Device, NetworkConfig, TrainConfig
from predictor.datasets import describe, read_training
from predictor.distributed import ALONE, Processes
from predictor.initial_weights import NEW_WEIGHTS, continued_network, drawn_network
from predictor.inputs import AgentInputs
from predictor.model import loss
from predictor.modes import mode_loss
from predictor.networks import Network, has_modes, name_of
from predictor.optimization import Optimization
from predictor.scalars import scalar_writer
from predictor.tensors import tensors
from predictor.training_state import (
    FILE,
    Place,
    batch_generator,
    epoch_order,
    load_state,
    save_state,
)
from predictor.validation import constant_velocity_errors, scores, validated
from predictor.window_cache import cached_windows
from predictor.windows import Windows

SCALAR_STEPS: Final = 20
"""Batches between two points of the training's scalars."""
LOG_SECONDS: Final = 10.0
"""Time between two lines of the progress bar where nobody watches [s]."""
CPU: Final = torch.device("cpu")


@dataclass(frozen=True, kw_only=True)
class TrainResult:
    """What a training came to.

    Attributes:
        checkpoint: Best checkpoint on validation.
        best_epoch: Its epoch, counted from 1.
        validation: Its `ade` and `fde` on validation [m].
        constant_velocity: Those of constant velocity on the same windows [m].
        windows: Number of training windows.
        windows_per_s: Training windows per second of wall clock, data and validation included.
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
    model: NetworkConfig,
    training: TrainConfig,
    init: Path | None = None,
    resume: bool = False,
    device: Device = "auto",
    cache: Path | None = None,
    tensorboard: bool = False,
    save_seconds: float = 60.0,
    command: str = "",
    progress: bool = True,
    processes: Processes = ALONE,
) -> TrainResult:
    """Train a network and write `best` and `last` (`.safetensors` and `.json`) into a folder.

    Killed at any moment and called again with `resume`, it ends with the same weights, on a CPU
    bit for bit.

    Args:
        data: As `predictor.datasets.read_training`.
        out: Folder to write to.
        model: What the network is.
        training: How it is trained.
        init: Checkpoint of the same network to begin with, instead of weights drawn from the
            seed. It stands for epoch 0, and is kept if no epoch is better on validation.
        resume: Go on where the training of `out` was killed; begin where there is none.
        device: Where to train; `auto` takes a GPU if there is one.
        cache: Folder of the cut windows, shared by runs; None takes `windows` beside `out`.
        tensorboard: Write scalars into `out/tensorboard`.
        save_seconds: Time between two states to resume from, besides one after each epoch [s].
        command: The command line, to be kept in the checkpoint.
        progress: Show a progress bar with the time left.
        processes: Who trains the same network on other rows of each batch; the first one writes.

    Raises:
        FileNotFoundError: The data or `init` is not there.
        ValueError: The data is unfit (no windows, another `dt`, a single recording), `init` is of
            another network, `out` holds the state of another training, or TensorBoard is not
            installed.
        FloatingPointError: The loss is no longer finite.
    """
    network, sha256 = (
        (with_pretrained(drawn_network(model, training.seed)), None)
        if init is None
        else continued_network(model, training.seed, init)
    )
    train_recordings, validation_recordings = read_training(data)
    folder = out.parent / "windows" if cache is None else cache
    windows = cached_windows(folder, train_recordings, model, stride=training.stride)
    validation = cached_windows(folder, validation_recordings, model, stride=training.stride)
    about = {
        "command": command,
        "training": asdict(training),
        "init": None if init is None else {"checkpoint": str(init), "sha256": sha256},
        "data": {
            "source": data,
            "made_by": describe(data),
            "train_recordings": len(train_recordings),
            "train_windows": len(windows),
            "validation_recordings": len(validation_recordings),
            "validation_windows": len(validation),
        },
        "protocol": "windows of consecutive listed frames; agents present in all of them; "
        "epoch chosen by validation ade + fde / 2, by nll among equals; predicted goals",
    }
    return fit(
        network,
        windows,
        validation,
        training,
        out=out,
        about=about,
        init=sha256,
        resume=resume,
        device=chosen_device(device),
        tensorboard=tensorboard,
        save_seconds=save_seconds,
        progress=progress,
        processes=processes,
    )


def chosen_device(device: Device) -> torch.device:
    """The device meant by `auto`: a GPU if there is one.

    Raises:
        ValueError: The device is not there.
    """
    there = {"cpu": True, "cuda": torch.cuda.is_available(), "mps": torch.mps.is_available()}
    if device == "auto":
        return torch.device(next(name for name in ("cuda", "mps", "cpu") if there[name]))
    if not there[device]:
        raise ValueError(f"expected the device {device}, found none on this machine")
    return torch.device(device)


def fit(
    network: Network,
    windows: Windows,
    validation: Windows,
    training: TrainConfig,
    *,
    out: Path,
    about: dict[str, Any],
    init: str | None = None,
    resume: bool = False,
    device: torch.device = CPU,
    tensorboard: bool = False,
    save_seconds: float = 60.0,
    progress: bool = True,
    processes: Processes = ALONE,
) -> TrainResult:
    """The epoch loop of `train`: from windows to checkpoints.

    Weights that were trained elsewhere, of which `init` is the SHA-256, are validated first: they
    are an epoch 0 without batches.

    Raises:
        ValueError: `out` holds the state of another training, or TensorBoard is not installed.
        FloatingPointError: The loss is no longer finite.
    """
    batches = math.ceil(len(windows) / training.batch_size)
    if training.train_only == "modes":
        _leave_all_but_modes(network)
    run = Optimization(network.to(device), training, batches, processes)
    identity = {**_identity(network, windows, validation, training), "init": init}
    start = Place() if init is None else Place(epoch=0, batch=batches)
    place = _beginning(run, out / FILE, identity, start, resume)
    baseline = scores(constant_velocity_errors(validation))
    first, started, saved = place.step(batches), time.perf_counter(), time.monotonic()
    with (
        torch.random.fork_rng(devices=[]),
        scalar_writer(
            out / "tensorboard" if tensorboard and processes.first else None, first
        ) as write,
        tqdm(
            total=training.epochs * batches,
            initial=first,
            unit="batch",
            mininterval=0.1 if sys.stderr.isatty() else LOG_SECONDS,
            disable=not (progress and processes.first),
        ) as bar,
    ):
        while not place.is_over(training.epochs, training.patience):
            order = epoch_order(len(windows), training.seed, place.epoch)
            network.train(training.train_only == "all")
            while place.batch < batches:
                rng = batch_generator(training.seed, place.epoch, place.batch, processes.rank)
                rows = order[place.batch * training.batch_size :][: training.batch_size]
                inputs, future = augmented_batch(windows, rows, training, rng)
                own, share = processes.part(len(rows))
                objective = _objective(network, inputs.take(own), future[own], training, device)
                measured = run.update(
                    share * objective, f"epoch {place.epoch}, batch {place.batch + 1}"
                )
                place.batch += 1
                bar.update()
                if place.step(batches) % SCALAR_STEPS == 0:
                    write(place.step(batches), measured)
                if processes.first and time.monotonic() - saved >= save_seconds:
                    save_state(out / FILE, place, identity, run.state())
                    saved = time.monotonic()
            found, calibration = validated(network, validation, device, processes)
            metrics = {"epoch": place.epoch, "validation": found, "constant_velocity": baseline}
            described = {**about, "metrics": metrics, "calibration": calibration}
            kept = ("last", "best") if place.finish_epoch(found) else ("last",)
            if processes.first:
                for name in kept:
                    save_checkpoint(out / f"{name}.safetensors", network, described)
                # last, so that a training killed before it repeats the epoch's end
                save_state(out / FILE, place, identity, run.state())
            write(place.step(batches), {f"validation/{key}": found[key] for key in found})
            bar.set_postfix_str(
                f"epoch {place.epoch - 1}: ADE/FDE {found['ade']:.3f}/{found['fde']:.3f} m"
            )
    seen = (place.step(batches) - first) * len(windows) / batches
    return TrainResult(
        checkpoint=out / "best.safetensors",
        best_epoch=place.best_epoch,
        validation=place.best,
        constant_velocity=baseline,
        windows=len(windows),
        windows_per_s=seen / (time.perf_counter() - started),
    )


def _beginning(
    run: Optimization, path: Path, identity: dict[str, Any], start: Place, resume: bool
) -> Place:
    """Where the training begins: where the state at `path` was taken, or at the start."""
    if not resume:
        path.unlink(missing_ok=True)
    if not path.exists():
        return start
    place, state = load_state(path, identity)
    run.load(state)
    return place


def _identity(
    network: Network, windows: Windows, validation: Windows, training: TrainConfig
) -> dict[str, Any]:
    """What a state must agree in to be gone on with."""
    return {
        "model": {"name": name_of(network.config), **asdict(network.config)},
        "training": asdict(training),
        "windows": len(windows),
        "validation_windows": len(validation),
    }


def _objective(
    network: Network,
    inputs: AgentInputs,
    future: NDArray[np.float32],
    training: TrainConfig,
    device: torch.device,
) -> Tensor:
    true_path = torch.from_numpy(future).to(device)
    given = {"true_goal": true_path[:, -1]} if training.true_goal else {}
    if has_modes(network):
        goal, path, modes = network.forward_modes(**tensors(inputs, device), **given)
        return loss(goal, path, true_path) + mode_loss(modes, true_path)
    goal, path = network(**tensors(inputs, device), **given)
    return loss(goal, path, true_path)


def _leave_all_but_modes(network: Network) -> None:
    """Let no gradient reach what is not the mode decoder.

    Raises:
        ValueError: There is none.
    """
    if not has_modes(network):
        raise ValueError("expected a network with modes to train only those, found none")
    for name, parameter in network.named_parameters():
        parameter.requires_grad_(name.startswith(NEW_WEIGHTS))
