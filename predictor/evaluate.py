"""Forecasters against recorded crowds, by the protocol of the literature; honest tables only."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from crowdsim.recordings import Recording
from predictor.datasets import Unit, read_tests, unit_of, usual_min_ped
from predictor.forecaster import Forecaster
from predictor.metrics import MOVING_DISPLACEMENT, ade, displacement_errors, fde, moves
from predictor.scenes import Scene, scenes

MIN_PED = (1, 0)
"""Windows count with more than so many agents; the first is the one of the Social-GAN loader."""

WORLDS = 32
"""Scenes forecast in one call."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrajectoryErrors:
    """Errors of M forecast trajectories.

    Attributes:
        errors: (M, F) displacement errors, in metres or pixels.
        moving: (M,) bool, who moves in its window (`metrics.moves`).
        agents: (M,) agents in the window of each trajectory.
        windows: (M,) number of the window.
    """

    errors: NDArray[np.float64]
    moving: NDArray[np.bool_]
    agents: NDArray[np.int64]
    windows: NDArray[np.int64]


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
        `share`). The mean is over folds, unweighted.

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


def trajectory_errors(
    forecaster: Forecaster,
    recordings: Sequence[Recording],
    *,
    unit: Unit = "m",
    progress: bool = False,
) -> TrajectoryErrors:
    """Forecast every agent of every window of some recordings.

    Args:
        forecaster: What to test.
        recordings: On what.
        unit: `px` tells errors in pixels of the pictures of the recordings.
        progress: Show a progress bar.

    Raises:
        ValueError: Another `dt` than the forecaster's, no window with an agent, or pixels where a
            recording has no picture.
    """
    errors, moving, agents = [], [], []
    bar = tqdm(desc=recordings[0].name, unit="window", disable=not progress)
    for chunk in _chunks(_all_scenes(forecaster, recordings)):
        for scene, forecast in zip(chunk, forecast_scenes(forecaster, chunk), strict=True):
            errors.append(displacement_errors(*_in(unit, scene, forecast, scene.future)).T)
            moving.append(moves(scene.history[:, scene.agents], scene.future))
            agents.append(len(scene.agents))
        bar.update(len(chunk))
    bar.close()
    if not errors:
        raise ValueError(f"expected people to forecast in {recordings[0].name}…, found none")
    return TrajectoryErrors(
        errors=np.concatenate(errors),
        moving=np.concatenate(moving),
        agents=np.repeat(agents, agents),
        windows=np.repeat(np.arange(len(agents)), agents),
    )


def _in(unit: Unit, scene: Scene, *points: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """World points [m] in the unit of the errors."""
    if unit == "m":
        return list(points)
    homography = scene.recording.pixel_from_world
    if homography is None:
        raise ValueError(f"{scene.recording.name}: errors in pixels need a picture, found none")
    projected = [to_homogeneous @ homography.T for to_homogeneous in map(_homogeneous, points)]
    return [p[..., :2] / p[..., 2:] for p in projected]


def _homogeneous(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.concatenate([points, np.ones((*points.shape[:-1], 1))], axis=-1)


def _all_scenes(forecaster: Forecaster, recordings: Sequence[Recording]) -> Iterator[Scene]:
    for recording in recordings:
        yield from scenes(
            recording,
            history_steps=forecaster.history_steps,
            forecast_steps=forecaster.forecast_steps,
            frame_dt=forecaster.frame_dt,
        )


def _chunks(every: Iterator[Scene]) -> Iterator[list[Scene]]:
    while chunk := list(islice(every, WORLDS)):
        yield chunk


def forecast_scenes(forecaster: Forecaster, batch: Sequence[Scene]) -> list[NDArray[np.float64]]:
    """Forecast the agents of several scenes in one call: (F, A, 2) for each [m]."""
    steps, people = len(batch[0].history), max(scene.history.shape[1] for scene in batch)
    history = np.zeros((len(batch), steps, people, 2))
    valid = np.zeros((len(batch), steps, people), dtype=np.bool_)
    select = np.zeros((len(batch), people), dtype=np.bool_)
    for world, scene in enumerate(batch):
        history[world, :, : scene.history.shape[1]] = scene.history
        valid[world, :, : scene.history.shape[1]] = scene.valid
        select[world, scene.agents] = True
    images = [scene.recording.map_image for scene in batch]
    homographies = [scene.recording.pixel_from_world for scene in batch]
    path = forecaster.forecast(history, valid, images, homographies, select)
    return [path[world][:, scene.agents] for world, scene in enumerate(batch)]


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
    }


def _average(errors: NDArray[np.float64]) -> dict[str, Any]:
    if len(errors) == 0:
        return {"ade": None, "fde": None, "n": 0}
    return {"ade": ade(errors), "fde": fde(errors), "n": len(errors)}


def _mean(values: Sequence[float | None]) -> float | None:
    """Mean of the folds that have a value; JSON knows no NaN."""
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None
