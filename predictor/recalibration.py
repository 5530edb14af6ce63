"""How far off forecasts may be that training does not measure: from short histories, and rolled.

Whom a robot has just come upon was seen in a few frames only, and is harder to forecast. Radii of
all together would hold too few of them and too many of the others; so each number of frames seen
is a group with radii of its own (Mondrian conformal prediction: V. Vovk et al., "Mondrian
Confidence Machine", 2003).
"""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from crowdsim.recordings import Recording
from crowdsim.recordings.store import write_atomic
from predictor.calibration import conformal_radius
from predictor.datasets import read_training
from predictor.forecaster import Forecaster, steps_of
from predictor.metrics import displacement_errors
from predictor.network_forecaster import NetworkForecaster
from predictor.scenes import with_last_frames
from predictor.trajectory_errors import batches, forecast_scenes


def recalibrate(
    checkpoint: Path, data: str, *, horizon: float, progress: bool = False
) -> dict[str, Any]:
    """Measure a network on validation recordings, and keep the radii in its checkpoint.

    All lengths of history are measured on the same people, of whom all earlier frames are hidden,
    as those of everyone around them. Only people who stay for the whole horizon can be measured,
    and all steps on the same people.

    Args:
        checkpoint: A `.safetensors` file, or a folder with `best.safetensors`; its JSON is written
            anew.
        data: As `predictor.datasets.read_training`; what it keeps for validation is forecast.
        horizon: How far to roll [s].
        progress: Show progress bars.

    Returns:
        What was written, each with `radius` [m] in a row for each length of history, number of
        `windows`, and `data`: `short` of the frames that the network was trained for, from 1 to
        T - 1 frames, and `rolled` of those until the horizon, from 1 to T.

    Raises:
        FileNotFoundError: Checkpoint or data is not there.
        ValueError: It is damaged, was never calibrated within the frames that it was trained for
            and from the whole history, or nobody stays that long.
    """
    path = checkpoint / "best.safetensors" if checkpoint.is_dir() else checkpoint
    trained = NetworkForecaster.from_checkpoint(path)
    rolled = NetworkForecaster.from_checkpoint(path, forecast_steps=steps_of(horizon))
    about = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    if "calibration" not in about:
        raise ValueError(f"{path}: expected a checkpoint with a calibration, found none")
    _, recordings = read_training(data)
    lengths = range(1, trained.history_steps + 1)
    found = {}
    for key, forecaster, own in (("short", trained, lengths[:-1]), ("rolled", rolled, lengths)):
        shown = tqdm(own, desc=f"{key}, frames seen", disable=not progress)
        found[key] = {**_radii(forecaster, recordings, shown), "data": data}
    about["calibration"] |= found
    write_atomic(path.with_suffix(".json"), json.dumps(about, indent=1).encode() + b"\n")
    return found


def errors_from(
    forecaster: Forecaster, recordings: Sequence[Recording], frames: int
) -> NDArray[np.float64]:
    """(M, F) errors [m] of forecasts from the last `frames` frames of history.

    Raises:
        ValueError: Another `dt` than the forecaster's, or nobody stays long enough.
    """
    errors = []
    for batch in batches(forecaster, recordings):
        shown = [with_last_frames(scene, frames) for scene in batch]
        paths = zip(batch, forecast_scenes(forecaster, shown), strict=True)
        errors += [displacement_errors(path, scene.future).T for scene, path in paths]
    if not errors:
        raise ValueError(f"expected people to forecast in {recordings[0].name}…, found none")
    return np.concatenate(errors)


def _radii(
    forecaster: Forecaster, recordings: Sequence[Recording], lengths: Iterable[int]
) -> dict[str, Any]:
    """Radii of each length of history, one row each, and of how many windows; JSON-able."""
    errors = [errors_from(forecaster, recordings, frames) for frames in lengths]
    return {
        "radius": [conformal_radius(of_length).tolist() for of_length in errors],
        "windows": len(errors[0]) if errors else 0,
    }
