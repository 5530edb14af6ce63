"""Forecasters against recorded crowds, by the protocol of the literature; honest tables only."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings import Recording
from predictor.datasets import read_tests, unit_of, usual_min_ped
from predictor.forecaster import Forecaster
from predictor.grounds import Ground, read_grounds
from predictor.metrics import MOVING_DISPLACEMENT, ade, fde
from predictor.trajectory_errors import TrajectoryErrors, trajectory_errors

MIN_PED: Final = (1, 0)
"""Windows count with more than so many agents; the first is the one of the Social-GAN loader."""

ERRORS: Final = ("ade", "fde")
"""Stand in every row, None where there is no trajectory."""

COUNTS: Final = ("n", "windows")
"""Have no mean over folds."""


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
        As `tables`.

    Raises:
        FileNotFoundError: The data is not there.
        ValueError: The data is unfit, or `min_ped` is another number.
    """
    limit = checked_min_ped(min_ped, data)
    tests = read_tests(data)
    everywhere = dict.fromkeys(tests, forecaster)
    grounds = read_grounds(data, tests)
    errors = errors_of_folds(everywhere, tests, data=data, grounds=grounds, progress=progress)
    return tables(errors, forecaster, data=data, min_ped=limit)


def checked_min_ped(min_ped: int | None, data: str) -> int:
    """The limit asked for, or the usual one of the data.

    Raises:
        ValueError: `min_ped` is another number than 0 and 1.
    """
    if min_ped is not None and min_ped not in MIN_PED:
        raise ValueError(f"min_ped must be one of {MIN_PED}, got {min_ped}")
    return usual_min_ped(data) if min_ped is None else min_ped


def errors_of_folds(
    forecasters: Mapping[str, Forecaster],
    tests: Mapping[str, Sequence[Recording]],
    *,
    data: str,
    grounds: Mapping[str, Ground],
    progress: bool = False,
) -> dict[str, TrajectoryErrors]:
    """Errors on the test part of each fold, of the forecaster that never saw it.

    Args:
        forecasters: What to test, by fold.
        tests: Recordings to test on, by fold.
        data: Where they come from, as `predictor.datasets.read_tests`.
        grounds: Of the recordings, as `predictor.grounds.read_grounds`.
        progress: Show a progress bar.

    Raises:
        ValueError: The data is unfit.
    """
    return {
        fold: trajectory_errors(
            forecasters[fold], recordings, unit=unit_of(data), grounds=grounds, progress=progress
        )
        for fold, recordings in tests.items()
    }


def tables(
    errors: Mapping[str, TrajectoryErrors], forecaster: Forecaster, *, data: str, min_ped: int
) -> dict[str, Any]:
    """Rows for the folds and their mean, with the protocol.

    Args:
        errors: By fold.
        forecaster: That made them, or one of those that did.
        data: As `predictor.datasets.read_tests`.
        min_ped: Which table stands at the top level; 0 or 1.

    Returns:
        JSON-able `{"folds": {fold: row}, "mean": row, "protocol": {...}, "min_ped_0": {"folds",
        "mean"}, "min_ped_1": {"folds", "mean"}}`. A row has `ade`, `fde` (in the protocol's
        `unit`), `n` trajectories, `windows`, `error_per_step` and `moving` (`ade`, `fde`, `n`,
        `share`); the measures of `TrajectoryErrors` that are known, by their names and those of
        each step as `..._per_step`; and of a calibrated forecaster `radius_mean` and
        `radius_per_step` [m]. The mean is over folds, unweighted.
    """
    by_limit = {limit: _table(errors, limit) for limit in MIN_PED}
    protocol = {
        "forecaster": forecaster.name,
        "data": data,
        "unit": unit_of(data),
        "history_steps": forecaster.history_steps,
        "forecast_steps": forecaster.forecast_steps,
        "frame_dt": forecaster.frame_dt,
        "window": "consecutive listed frames, stride 1; agents are present in all of them",
        "min_ped": min_ped,
        "samples": 1,
        "moving": f"at least {MOVING_DISPLACEMENT} m between first and last frame of the window",
        "mean": "unweighted over folds",
    }
    both = {f"min_ped_{limit}": table for limit, table in by_limit.items()}
    return {**by_limit[min_ped], "protocol": protocol, **both}


def _table(found: Mapping[str, TrajectoryErrors], min_ped: int) -> dict[str, Any]:
    folds = {fold: _row(errors, min_ped) for fold, errors in found.items()}
    return {"folds": folds, "mean": _mean_row(list(folds.values()))}


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
        **_measured(found, counted),
        **_expected(found),
    }


def _average(errors: NDArray[np.float64]) -> dict[str, Any]:
    if len(errors) == 0:
        return {"ade": None, "fde": None, "n": 0}
    return {"ade": ade(errors), "fde": fde(errors), "n": len(errors)}


def _measured(found: TrajectoryErrors, counted: NDArray[np.bool_]) -> dict[str, Any]:
    """Mean of each measure over what is known of it, and per step; what is never known is out."""
    row: dict[str, Any] = {}
    for name, values in found.measures.items():
        mean = _known_mean(values[counted])
        if mean is not None:
            row[name] = mean
            if values.ndim == 2:
                per_step = [_known_mean(of_step) for of_step in values[counted].T]
                row[f"{name.partition('@')[0]}_per_step"] = per_step
    return row


def _known_mean(values: NDArray[np.float64]) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) > 0 else None


def _expected(found: TrajectoryErrors) -> dict[str, Any]:
    """The radii that a calibrated forecaster expects to hold [m]; nothing of another."""
    if found.radius is None:
        return {}
    return {
        "radius_mean": float(found.radius.mean()),
        "radius_per_step": found.radius.tolist(),
    }


def _mean_row(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Unweighted over the folds that know a value, of all that is no count; moving as well."""
    keys = dict.fromkeys(key for row in rows for key in row)
    mean = {key: _mean([row.get(key) for row in rows]) for key in keys if key not in COUNTS}
    return {key: value for key, value in mean.items() if value is not None or key in ERRORS}


def _mean(values: Sequence[Any]) -> Any:
    """Mean of the folds that have a value, or of each of their steps; JSON knows no NaN."""
    known = [value for value in values if value is not None]
    if known and isinstance(known[0], dict):
        return _mean_row(known)
    if known and isinstance(known[0], list):
        return [_mean(of_step) for of_step in zip(*known, strict=True)]
    return float(np.mean(known)) if known else None
