"""Closed-loop forecast errors as sums by distance to the robot, history and step.

Sums, not means: added up over any bins, steps and episodes they give what all of them hold
together, and divided by their counts the exact mean.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from envs.forecast_scores import ScoredForecasts
from envs.metrics import Value

DISTANCES = ("0-2", "2-4", "4-8", "8-")
"""Bins of the distance to the robot when the forecast was made, surface to surface [m]."""

DISTANCE_EDGES = (2.0, 4.0, 8.0)
"""Where they meet [m]; an edge belongs to the bin above."""

FRAMES_SEEN = ("1-2", "3-5", "6-7", "8-")
"""Bins of the number of frames that the forecast was made from."""

FRAMES_EDGES = (3, 6, 8)
"""The least number of the second bin, the third and the last."""

CELL_COLUMNS = (
    "scenario",
    "arm",
    "policy",
    "forecaster",
    "horizon",
    "seed",
    "distance",
    "frames_seen",
    "step",
    "seconds",
    "n",
    "error_sum",
    "within_radius",
)
"""Columns of `forecast_errors.parquet`: one row per episode, bin and step that hold a forecast."""


def forecast_cells(
    scored: ScoredForecasts, frame_dt: float, about: Mapping[str, Value]
) -> list[dict[str, Value]]:
    """Sums one episode's forecast errors by bin and step.

    Args:
        scored: The forecasts.
        frame_dt: Time between their steps [s].
        about: The columns that name the episode.

    Returns:
        One row for each pair of bins that holds a forecast and each step, with `distance` and
        `frames_seen` (names of the bins), `step` from 1 and its `seconds`, `n` forecasts, the sum
        of their errors `error_sum` [m] and how many came true `within_radius`.
    """
    rows: list[dict[str, Value]] = []
    distance = np.searchsorted(DISTANCE_EDGES, scored.distance, side="right")
    frames = np.searchsorted(FRAMES_EDGES, scored.frames_seen, side="right")
    for near, seen in sorted(set(zip(distance.tolist(), frames.tolist(), strict=True))):
        chosen = (distance == near) & (frames == seen)
        bins: dict[str, Value] = {"distance": DISTANCES[near], "frames_seen": FRAMES_SEEN[seen]}
        for step, sums in enumerate(_sums_per_step(scored, chosen), start=1):
            rows.append({**about, **bins, "step": step, "seconds": step * frame_dt, **sums})
    return rows


def _sums_per_step(scored: ScoredForecasts, chosen: NDArray[np.bool_]) -> list[dict[str, Value]]:
    """Count and sums of the chosen forecasts (E,), step by step."""
    error = scored.error[chosen].sum(axis=0).tolist()
    within = scored.within[chosen].sum(axis=0).tolist()
    count = int(chosen.sum())
    return [
        {"n": count, "error_sum": total, "within_radius": inside}
        for total, inside in zip(error, within, strict=True)
    ]
