"""The forecasts that a robot saw, against what people then did beside it: the closed loop."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envs.trace import Trace
from predictor.calibration import nll_of_radius

Floats = NDArray[np.float64]

EXACT = 1e-9
"""A position this near to the forecast one is inside every radius, a radius of 0 included [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ScoredForecasts:
    """E forecasts whose whole horizon lies within the episode, of people who stayed; F steps.

    Attributes:
        row: (E,) row of the trace at which the forecast was made.
        column: (E,) column of the trace of whom it is for.
        position: (E, F, 2) what was forecast, world frame [m].
        error: (E, F) distance to where they then were [m].
        within: (E, F), whether that is within the forecast's radius.
        nll: (E, F) negative log density there, as `predictor.calibration.nll_of_radius` reads the
            radius [nat]; NaN where it is 0.
        distance: (E,) to the robot when the forecast was made, surface to surface [m].
        frames_seen: (E,) frames of history that the forecast was made from.
    """

    row: NDArray[np.int64]
    column: NDArray[np.int64]
    position: Floats
    error: Floats
    within: NDArray[np.bool_]
    nll: Floats
    distance: Floats
    frames_seen: NDArray[np.int64]


def scored_forecasts(trace: Trace) -> ScoredForecasts:
    """Compares every forecast of an episode that can be judged with the truth."""
    forecast, radius = trace.forecast, trace.forecast_radius
    frames_seen = trace.forecast_frames_seen
    if forecast is None or radius is None or frames_seen is None:
        forecast, radius = np.empty((0, 0, 0, 2)), np.empty((0, 0, 0))
        frames_seen = np.empty((0, 0), dtype=np.int64)
    row, slot, column = _judged(trace)
    truth = trace.position[rows_ahead(trace, row), column[:, None]]
    error = np.linalg.norm(forecast[row, slot] - truth, axis=-1)
    gap = np.linalg.norm(trace.position[row, column] - trace.robot_position[row], axis=-1)
    return ScoredForecasts(
        row=row,
        column=column,
        position=forecast[row, slot],
        error=error,
        within=error <= radius[row, slot] + EXACT,
        nll=nll_of_radius(error, radius[row, slot]),
        distance=gap - trace.radius[column] - trace.robot_radius,
        frames_seen=frames_seen[row, slot],
    )


def rows_ahead(trace: Trace, row: NDArray[np.int64]) -> NDArray[np.int64]:
    """(E, F) rows of the trace that the steps of forecasts made at `row` (E,) are about."""
    steps = 0 if trace.forecast is None else trace.forecast.shape[2]
    stride = round(trace.frame_dt / trace.dt)
    ahead: NDArray[np.int64] = row[:, None] + stride * np.arange(1, steps + 1)
    return ahead


def forecast_columns(trace: Trace) -> NDArray[np.int64]:
    """(T, K) column of the pedestrian whom each forecast is for; -1 in an empty slot."""
    if trace.forecast_ids is None:
        return np.full((len(trace.ids), 0), -1)
    if trace.ids.shape[1] == 0:
        return np.full(trace.forecast_ids.shape, -1)
    is_for = trace.forecast_ids[:, :, None] == trace.ids[:, None, :]  # (T, K, N)
    is_for &= trace.valid[:, None, :]
    columns: NDArray[np.int64] = np.where(is_for.any(axis=-1), is_for.argmax(axis=-1), -1)
    return columns


def _judged(trace: Trace) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Row, slot and column (E,) of the forecasts whose truth is known at every step."""
    columns = forecast_columns(trace)
    row, slot = np.nonzero(columns >= 0)
    ahead = rows_ahead(trace, row)
    whole = (ahead < len(trace.position)).all(axis=1)
    row, slot, ahead = row[whole], slot[whole], ahead[whole]
    column = columns[row, slot]
    there = trace.valid[ahead, column[:, None]]
    same = trace.ids[ahead, column[:, None]] == trace.ids[row, column][:, None]
    stayed = (there & same).all(axis=1)
    return row[stayed], slot[stayed], column[stayed]
