"""How far off forecasts may be that go on beyond what a network was trained for."""

import json
from pathlib import Path
from typing import Any

from crowdsim.recordings.store import write_atomic
from predictor.calibration import conformal_radius
from predictor.datasets import read_training
from predictor.forecaster import steps_of
from predictor.network_forecaster import NetworkForecaster
from predictor.trajectory_errors import trajectory_errors


def calibrate_rolled(
    checkpoint: Path, data: str, *, horizon: float, progress: bool = False
) -> dict[str, Any]:
    """Measure rolled forecasts on validation recordings, and keep the radii in the checkpoint.

    Only people who stay for the whole horizon can be measured, and all steps on the same people.

    Args:
        checkpoint: A `.safetensors` file, or a folder with `best.safetensors`; its JSON is written
            anew.
        data: As `predictor.datasets.read_training`; what it keeps for validation is forecast.
        horizon: How far [s].
        progress: Show a progress bar.

    Returns:
        What was written: `radius` of each step [m], number of `windows`, `data`.

    Raises:
        FileNotFoundError: Checkpoint or data is not there.
        ValueError: It is damaged, was never calibrated within the frames that it was trained for,
            or nobody stays that long.
    """
    path = checkpoint / "best.safetensors" if checkpoint.is_dir() else checkpoint
    forecaster = NetworkForecaster.from_checkpoint(path, forecast_steps=steps_of(horizon))
    about = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    if "calibration" not in about:
        raise ValueError(f"{path}: expected a checkpoint with a calibration, found none")
    _, recordings = read_training(data)
    errors = trajectory_errors(forecaster, recordings, progress=progress).errors
    radius = conformal_radius(errors)
    rolled = {"radius": radius.tolist(), "windows": len(errors), "data": data}
    about["calibration"]["rolled"] = rolled
    write_atomic(path.with_suffix(".json"), json.dumps(about, indent=1).encode() + b"\n")
    return rolled
