"""`crowdnav train-predictor`: train the predictor or one of its baselines."""

import json
import shlex
from pathlib import Path
from typing import Literal

from jsonargparse.typing import NonNegativeInt, PositiveInt

from predictor.config import ConfigName, Device, ModelName, Variant
from scripts.interruption import resumable
from scripts.options import PositiveNumber
from scripts.output import require_folder


def train_predictor(
    data: str = "runs/dataset",
    model: ModelName = "iterative_attention",
    variant: Variant = "none",
    backbone: str | None = None,
    train_backbone: bool = False,
    config_name: ConfigName = "residual",
    horizon: PositiveNumber | None = None,
    epochs: PositiveInt | None = None,
    patience: PositiveInt | None = None,
    changes: dict[str, bool | int | float | str] | None = None,
    init: Path | None = None,
    modes: NonNegativeInt = 0,
    train_only: Literal["all", "modes"] = "all",
    out: Path = Path("runs/predictor"),
    resume: bool = False,
    device: Device = "auto",
    cache: Path | None = None,
    tensorboard: bool = False,
    seed: NonNegativeInt = 0,
) -> None:
    """Train a predictor and keep the epoch that is best on validation.

    The folder, with `best` and `last` as safetensors and JSON, is a `--forecaster` of the other
    commands. Killed at any moment, the same command with `--resume` ends with the same weights.

    Args:
        data: Folder written by `crowdnav generate`, or `eth_ucy:FOLD`, or `FOLDER:FOLD` where
            FOLDER holds the ETH/UCY data and FOLD is eth, hotel, univ, zara1 or zara2, or `sdd` or
            the folder of that data; with `@drawn` behind real data, its masks drawn in the palette
            of simulated maps take the place of the photographs.
        model: The iterative-attention network or a baseline.
        variant: What the network sees of the map: nothing, patches of the picture, or features of a
            pretrained network for pictures (`pip install 'crowdnav-testbed[backbones]'`).
        backbone: Where such a network comes from, a name on the Hugging Face hub or a folder; not
            given: microsoft/resnet-18 or google/vit-base-patch16-224.
        train_backbone: Train it, too, instead of leaving it as it is.
        config_name: Model and training of the paper, or corrections of constant velocity, or these
            by a network for the loop (`fast`), and `finetune` to train weights of `residual` on
            with small steps.
        horizon: How far one pass of the network forecasts [s], instead of the configuration's own
            4.8; a multiple of 0.4.
        epochs: Passes over the data, instead of the configuration's own number.
        patience: Stop after so many epochs that were no better on validation.
        changes: Other values for fields of the configuration, which the checkpoint's JSON lists
            under `config` and `training`: '{"stride": 2, "mirror": false}'.
        init: Checkpoint of the same network to begin with; it is kept if no epoch is better.
        modes: How many futures are forecast for each person, besides the one, as a mixture.
        train_only: Train all of the network, or leave it as `init` has it apart from its modes.
        out: Folder of the checkpoints.
        resume: Go on where the training of this folder was killed.
        device: Where to train; `auto` takes a GPU if there is one.
        cache: Folder of the cut windows, shared by runs; `windows` beside `out` if not given.
        tensorboard: Write scalars into `tensorboard` in the folder.
        seed: Seed of the initial weights, the order of windows and their augmentation.
    """
    require_folder(out)
    from dataclasses import replace

    from predictor.backbones import with_backbone
    from predictor.changes import with_changes
    from predictor.distributed import joined_processes
    from predictor.forecaster import steps_of
    from predictor.networks import configuration
    from predictor.train import train

    network, training = configuration(
        model, config_name, variant=variant, modes=modes, seed=seed, epochs=epochs
    )
    if backbone is not None or train_backbone:
        network = with_backbone(network, backbone, trained=train_backbone)
    if horizon is not None:
        network = replace(network, forecast_steps=steps_of(horizon, network.frame_dt))
    training = replace(training, patience=patience, train_only=train_only)
    changes = {} if changes is None else changes
    network, training = with_changes(network, training, changes)
    command = _command(
        data=data,
        model=model,
        variant=variant,
        config_name=config_name,
        epochs=training.epochs,
        seed=seed,
        backbone=backbone,
        train_backbone=True if train_backbone else None,
        horizon=horizon,
        patience=patience,
        changes=json.dumps(changes) if changes else None,
        init=init,
        modes=None if modes == 0 else modes,
        train_only=None if modes == 0 else train_only,
    )
    with resumable(), joined_processes() as processes:
        found = train(
            data=data,
            out=out,
            model=network,
            training=training,
            init=init,
            resume=resume,
            device=device,
            cache=cache,
            tensorboard=tensorboard,
            command=command,
            processes=processes,
        )
    if not processes.first:
        return
    mine, baseline = found.validation, found.constant_velocity
    print(
        f"Epoch {found.best_epoch} of {training.epochs} is best on validation: ADE/FDE "
        f"{mine['ade']:.3f}/{mine['fde']:.3f} m, constant velocity {baseline['ade']:.3f}/"
        f"{baseline['fde']:.3f} m ({found.windows} training windows, "
        f"{found.windows_per_s:.0f} windows/s)"
    )
    print(f"Checkpoint in {found.checkpoint}; next: crowdnav evaluate-predictor --forecaster {out}")


def _command(**options: object) -> str:
    """The command line with these options; one that is None is left out, True needs no value."""
    words = ["crowdnav", "train-predictor"]
    for name, value in options.items():
        if value is not None:
            words += [f"--{name}"] if value is True else [f"--{name}", str(value)]
    return shlex.join(words)
