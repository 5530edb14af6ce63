"""How far off forecasts may be that are made from less history than there could be.

Whom a robot has just come upon was seen in a few frames only, and is harder to forecast. Radii of
all together would hold too little of them and too much of the others; so each number of frames
seen is a group with radii of its own (Mondrian conformal prediction: V. Vovk et al., "Mondrian
Confidence Machine", 2003).
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings import Recording
from crowdsim.recordings.store import write_atomic
from predictor.calibration import conformal_radius
from predictor.datasets import read_training
from predictor.forecaster import Forecaster
from predictor.metrics import displacement_errors
from predictor.network_forecaster import NetworkForecaster
from predictor.scenes import with_last_frames
from predictor.trajectory_errors import batches, forecast_scenes


def calibrate_short(checkpoint: Path, data: str) -> dict[str, Any]:
    """Measure forecasts from short histories on validation recordings, and keep the radii.

    All lengths are measured on the same people, of whom all earlier frames are hidden, as those of
    everyone around them.

    Args:
        checkpoint: A `.safetensors` file, or a folder with `best.safetensors`; its JSON is written
            anew.
        data: As `predictor.datasets.read_training`; what it keeps for validation is forecast.

    Returns:
        What was written: `radius` [m] of each step for people seen in 1 to T - 1 frames, number of
        `windows`, `data`.

    Raises:
        FileNotFoundError: Checkpoint or data is not there.
        ValueError: It is damaged, or was never calibrated with the whole history.
    """
    path = checkpoint / "best.safetensors" if checkpoint.is_dir() else checkpoint
    forecaster = NetworkForecaster.from_checkpoint(path)
    about = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    if "calibration" not in about:
        raise ValueError(f"{path}: expected a checkpoint with a calibration, found none")
    _, recordings = read_training(data)
    errors = [
        errors_from(forecaster, recordings, frames) for frames in range(1, forecaster.history_steps)
    ]
    short = {
        "radius": [conformal_radius(of_length).tolist() for of_length in errors],
        "windows": len(errors[0]),
        "data": data,
    }
    about["calibration"]["short"] = short
    write_atomic(path.with_suffix(".json"), json.dumps(about, indent=1).encode() + b"\n")
    return short


def errors_from(
    forecaster: Forecaster, recordings: Sequence[Recording], frames: int
) -> NDArray[np.float64]:
    """(M, F) errors [m] of forecasts from the last `frames` frames of history."""
    errors = []
    for batch in batches(forecaster, recordings):
        shown = [with_last_frames(scene, frames) for scene in batch]
        paths = zip(batch, forecast_scenes(forecaster, shown), strict=True)
        errors += [displacement_errors(path, scene.future).T for scene, path in paths]
    return np.concatenate(errors)
