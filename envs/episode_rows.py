"""Rows of measured episodes, and the Parquet files that hold them."""

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from envs.metric_table import METRICS
from envs.metrics import Value

Row = dict[str, Value]
"""One episode: scenario, arm, policy, forecaster, horizon, seed, and every metric."""

_TEXT = ("scenario", "arm", "policy", "forecaster", "collision_role")
_COUNTS = ("seed", "failure_to_progress", "forecast_count")


def rows_as_parquet(rows: Sequence[Row]) -> bytes:
    """The rows as the content of a Parquet file, one column per key; missing numbers are null."""
    columns = {
        key: pa.array([row[key] for row in rows], type=_column_type(key), from_pandas=True)
        for key in rows[0]
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
    return pa.bool_() if is_share else pa.float64()
