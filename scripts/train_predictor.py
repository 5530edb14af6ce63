"""`crowdnav train-predictor`: train the iterative-attention predictor."""

import shlex
from pathlib import Path

from jsonargparse.typing import NonNegativeInt, PositiveInt

from predictor.config import ConfigName, Variant
from scripts.output import require_folder


def train_predictor(
    data: str = "runs/dataset",
    variant: Variant = "none",
    config_name: ConfigName = "residual",
    epochs: PositiveInt | None = None,
    out: Path = Path("runs/predictor"),
    seed: NonNegativeInt = 0,
) -> None:
    """Train the predictor and keep the epoch that is best on validation.

    The folder, with `best` and `last` as safetensors and JSON, is a `--forecaster` of the other
    commands.

    Args:
        data: Folder written by `crowdnav generate`, or `eth_ucy:FOLD`, or `FOLDER:FOLD` where
            FOLDER holds the ETH/UCY data and FOLD is eth, hotel, univ, zara1 or zara2.
        variant: What the network sees of the map: nothing, or patches of the picture.
        config_name: Model and training of the paper, or corrections of constant velocity.
        epochs: Passes over the data, instead of the configuration's own number.
        out: Folder of the checkpoints.
        seed: Seed of the initial weights, the order of windows and their augmentation.
    """
    require_folder(out)
    from predictor.config import named_configuration
    from predictor.train import train

    model, training = named_configuration(config_name, variant=variant, seed=seed, epochs=epochs)
    words = ["crowdnav", "train-predictor", "--data", data, "--variant", variant, "--config_name"]
    words += [config_name, "--epochs", str(training.epochs), "--seed", str(seed)]
    found = train(data=data, out=out, model=model, training=training, command=shlex.join(words))
    mine, baseline = found.validation, found.constant_velocity
    print(
        f"Epoch {found.best_epoch} of {training.epochs} is best on validation: ADE/FDE "
        f"{mine['ade']:.3f}/{mine['fde']:.3f} m, constant velocity {baseline['ade']:.3f}/"
        f"{baseline['fde']:.3f} m ({found.windows} training windows, "
        f"{found.windows_per_s:.0f} windows/s)"
    )
    print(f"Checkpoint in {found.checkpoint}; next: crowdnav evaluate-predictor --forecaster {out}")
