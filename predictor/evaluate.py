"""Forecasters against recorded crowds, by the protocol of the literature; honest tables only."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings import Recording
from predictor.calibration import LEVEL
from predictor.datasets import read_tests, unit_of, usual_min_ped
from predictor.forecaster import Forecaster
from predictor.metrics import MOVING_DISPLACEMENT, ade, fde
from predictor.trajectory_errors import TrajectoryErrors, trajectory_errors

MIN_PED: Final = (1, 0)
"""Windows count with more than so many agents; the first is the one of the Social-GAN loader."""


def evaluate(
    forecaster: Forecaster, data: str, *, min_ped: int | None = None, progress: bool = False
) -> dict[str, Any]:
    """Errors of a forecaster on the test parts of a data set.

    Args:
        forecaster: What to test.
        data: As `predictor.datasets.read_tests`.
        min_ped: Which table stands at the top level, 0 or 1; None takes the usual one of the data.
        progress: Show a progress bar.

    Returns:
        As `evaluate_folds`.

    Raises:
        FileNotFoundError: The data is not there.
        ValueError: The data is unfit, or `min_ped` is another number.
    """
    limit = checked_min_ped(min_ped, data)
    tests = read_tests(data)
    everywhere = dict.fromkeys(tests, forecaster)
    return evaluate_folds(everywhere, tests, data=data, min_ped=limit, progress=progress)


def checked_min_ped(min_ped: int | None, data: str) -> int:
    """The limit asked for, or the usual one of the data.

    Raises:
        ValueError: `min_ped` is another number than 0 and 1.
    """
    if min_ped is not None and min_ped not in MIN_PED:
        raise ValueError(f"min_ped must be one of {MIN_PED}, got {min_ped}")
    return usual_min_ped(data) if min_ped is None else min_ped


def evaluate_folds(
    forecasters: Mapping[str, Forecaster],
    tests: Mapping[str, Sequence[Recording]],
    *,
    data: str,
    min_ped: int,
    progress: bool = False,
) -> dict[str, Any]:
    """Errors on the test part of each fold, of the forecaster that never saw it.

    Args:
        forecasters: What to test, by fold.
        tests: Recordings to test on, by fold.
        data: Where they come from, as `predictor.datasets.read_tests`.
        min_ped: Which table stands at the top level; 0 or 1.
        progress: Show a progress bar.

    Returns:
        JSON-able `{"folds": {fold: row}, "mean": row, "protocol": {...}, "min_ped_0": {"folds",
        "mean"}, "min_ped_1": {"folds", "mean"}}`. A row has `ade`, `fde` (in the protocol's
        `unit`), `n` trajectories, `windows`, `error_per_step` and `moving` (`ade`, `fde`, `n`,
        `share`), and of a calibrated forecaster `coverage@0.9` and `radius_mean` [m], both also
        per step. The mean is over folds, unweighted.

    Raises:
        ValueError: The data is unfit.
    """
    unit = unit_of(data)
    found = {
        fold: trajectory_errors(forecasters[fold], recordings, unit=unit, progress=progress)
        for fold, recordings in tests.items()
    }
    tables = {limit: _table(found, limit) for limit in MIN_PED}
    one = next(iter(forecasters.values()))
    protocol = {
        "forecaster": one.name,
        "data": data,
        "unit": unit,
        "history_steps": one.history_steps,
        "forecast_steps": one.forecast_steps,
        "frame_dt": one.frame_dt,
        "window": "consecutive listed frames, stride 1; agents are present in all of them",
        "min_ped": min_ped,
        "samples": 1,
        "moving": f"at least {MOVING_DISPLACEMENT} m between first and last frame of the window",
        "mean": "unweighted over folds",
    }
    both = {f"min_ped_{limit}": table for limit, table in tables.items()}
    return {**tables[min_ped], "protocol": protocol, **both}


def _table(found: dict[str, TrajectoryErrors], min_ped: int) -> dict[str, Any]:
    folds = {fold: _row(errors, min_ped) for fold, errors in found.items()}
    rows = list(folds.values())
    mean = {key: _mean([row[key] for row in rows]) for key in ("ade", "fde")}
    moving = {key: _mean([row["moving"][key] for row in rows]) for key in ("ade", "fde")}
    return {"folds": folds, "mean": {**mean, "moving": moving}}


def _row(found: TrajectoryErrors, min_ped: int) -> dict[str, Any]:
    counted = found.agents > min_ped
    errors, moving = found.errors[counted], found.moving[counted]
    return {
        **_average(errors),
        "windows": len(np.unique(found.windows[counted])),
        "error_per_step": errors.mean(axis=0).tolist() if len(errors) > 0 else None,
        "moving": {
            **_average(errors[moving]),
            "share": float(moving.mean()) if len(moving) > 0 else None,
        },
        **_calibration(found, counted),
    }


def _calibration(found: TrajectoryErrors, counted: NDArray[np.bool_]) -> dict[str, Any]:
    """How often the truth lay within the radii that the forecaster expects; nothing without."""
    if found.within is None or found.radius is None or not counted.any():
        return {}
    within = found.within[counted]
    return {
        f"coverage@{LEVEL}": float(within.mean()),
        "coverage_per_step": within.mean(axis=0).tolist(),
        "radius_mean": float(found.radius.mean()),
        "radius_per_step": found.radius.tolist(),
    }


def _average(errors: NDArray[np.float64]) -> dict[str, Any]:
    if len(errors) == 0:
        return {"ade": None, "fde": None, "n": 0}
    return {"ade": ade(errors), "fde": fde(errors), "n": len(errors)}


def _mean(values: Sequence[float | None]) -> float | None:
    """Mean of the folds that have a value; JSON knows no NaN."""
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None
