"""Closed-loop forecast errors as sums by distance to the robot, history and step.

Sums, not means: added up over any bins, steps and episodes they give what all of them hold
together, and divided by their counts the exact mean.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envs.evaluation.episode_rows import EPISODE_COLUMNS
from envs.evaluation.forecast_scores import ScoredForecasts, scored_forecasts
from envs.evaluation.metrics import Value
from envs.evaluation.robot_part import RobotPart, robot_part
from envs.trace import Trace

DISTANCES = ("0-2", "2-4", "4-8", "8-")
"""Bins of the distance to the robot when the forecast was made, surface to surface [m]."""

DISTANCE_EDGES = (2.0, 4.0, 8.0)
"""Where they meet [m]; an edge belongs to the bin above."""

FRAMES_SEEN = ("1", "2-4", "5-7", "8-")
"""Bins of the number of frames that the forecast was made from."""

FRAMES_EDGES = (2, 5, 8)
"""The least number of the second bin, the third and the last."""

CELL_COLUMNS = (
    *EPISODE_COLUMNS,
    "distance",
    "frames_seen",
    "step",
    "seconds",
    "n",
    "error_sum",
    "within_radius",
    "nll_n",
    "nll_sum",
    "twin_n",
    "twin_error_sum",
    "model_error_sum",
    "displacement_sum",
    "standing_displacement_sum",
)
"""Columns of `forecast_errors.parquet`: one row per episode, bin and step that hold a forecast."""


def forecast_cells(trace: Trace, about: Mapping[str, Value]) -> list[dict[str, Value]]:
    """Sums one episode's forecast errors by bin and step.

    Args:
        trace: What happened.
        about: The columns that name the episode.

    Returns:
        One row for each pair of bins that holds a forecast and each step, with `distance` and
        `frames_seen` (names of the bins), `step` from 1 and its `seconds`, `n` forecasts, the sum
        of their errors `error_sum` [m] and how many came true `within_radius`; of the `nll_n`
        forecasts that state a radius, the sum of the negative log densities `nll_sum` [nat]; and of
        the `twin_n` forecasts that `envs.evaluation.robot_part` splits, the sums of the error and
        its parts [m].
    """
    scored = scored_forecasts(trace)
    sums_of = _sums(scored, robot_part(trace, scored))
    rows: list[dict[str, Value]] = []
    distance = np.searchsorted(DISTANCE_EDGES, scored.distance, side="right")
    frames = np.searchsorted(FRAMES_EDGES, scored.frames_seen, side="right")
    for near, seen in sorted(set(zip(distance.tolist(), frames.tolist(), strict=True))):
        chosen = (distance == near) & (frames == seen)
        bins: dict[str, Value] = {"distance": DISTANCES[near], "frames_seen": FRAMES_SEEN[seen]}
        for index in range(scored.error.shape[1]):
            when: dict[str, Value] = {
                "step": index + 1,
                "seconds": round((index + 1) * trace.frame_dt, 9),
            }
            sums = {key: values[chosen, index].sum().item() for key, values in sums_of.items()}
            rows.append({**about, **bins, **when, **sums})
    return rows


def _sums(scored: ScoredForecasts, part: RobotPart) -> dict[str, NDArray[Any]]:
    """What is summed up, each (E, F), under the names of the sums."""
    known = np.broadcast_to(part.known[:, None], scored.error.shape)
    dense = np.isfinite(scored.nll)
    return {
        "n": np.ones(scored.error.shape, dtype=np.int64),
        "error_sum": scored.error,
        "within_radius": scored.within,
        "nll_n": dense,
        "nll_sum": np.where(dense, scored.nll, 0.0),
        "twin_n": known,
        "twin_error_sum": scored.error * known,
        "model_error_sum": part.model_error,
        "displacement_sum": part.displacement,
        "standing_displacement_sum": part.standing_displacement,
    }
