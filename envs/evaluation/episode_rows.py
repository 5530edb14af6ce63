"""Rows of measured episodes and of their forecast errors, and the Parquet files that hold them."""

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from envs.evaluation.metric_table import METRICS
from envs.evaluation.metrics import Value

Row = dict[str, Value]
"""One episode: `EPISODE_COLUMNS` and every metric; or one bin and step of its forecast errors."""

EPISODE_COLUMNS = (
    "scenario",
    "place",
    "model",
    "robot_visible",
    "arm",
    "policy",
    "forecaster",
    "horizon",
    "seed",
)
"""What tells an episode from all others: `place` is the scenario's name without what it was varied
by, `model` the motion model it was asked for ("" leaves the scenario its own)."""

_TEXT = (
    "scenario",
    "place",
    "model",
    "arm",
    "policy",
    "forecaster",
    "collision_role",
    "distance",
    "frames_seen",
)
_FLAGS = ("robot_visible",)
_COUNTS = (
    *("seed", "failure_to_progress", "forecast_count", "step"),
    *("n", "within_radius", "nll_n", "twin_n"),
)


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What is kept of some episodes.

    Attributes:
        rows: One per episode.
        cells: Their forecast errors, rows of `envs.evaluation.forecast_cells.forecast_cells`.
    """

    rows: list[Row]
    cells: list[Row]


def rows_as_parquet(rows: Sequence[Row], keys: Sequence[str]) -> bytes:
    """The rows as the content of a Parquet file, one column per key; missing numbers are null."""
    columns = {
        key: pa.array([row[key] for row in rows], type=_column_type(key), from_pandas=True)
        for key in keys
    }
    sink = io.BytesIO()
    pq.write_table(pa.table(columns), sink, compression="zstd")
    return sink.getvalue()


def read_rows(path: Path) -> list[Row]:
    """Reads back what `rows_as_parquet` gave; numbers that are missing are NaN again."""
    rows: list[Row] = pq.read_table(path).to_pylist()
    for row in rows:
        for key, value in row.items():
            if value is None and key not in _TEXT:
                row[key] = np.nan
    return rows


def _column_type(key: str) -> pa.DataType:
    """Type of a column; the same whatever its rows hold."""
    if key in _TEXT:
        return pa.string()
    if key in _COUNTS:
        return pa.int64()
    is_share = key in METRICS and METRICS[key].kind == "share"
    return pa.bool_() if is_share or key in _FLAGS else pa.float64()
