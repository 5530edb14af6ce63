"""Tracks in Parquet: whole millimetres, person by person, delta-packed and zstd-compressed.

A row group is what is in memory at a time, on either side. It holds recordings, or stretches of
them, one after the other; a stretch is never cut.
"""

from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Final, NamedTuple, Self

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from crowdsim.recordings.recording import Recording

SCHEMA: Final = pa.schema(
    {
        "recording": pa.int32(),
        "id": pa.int64(),
        "frame": pa.int64(),
        "x_mm": pa.int32(),
        "y_mm": pa.int32(),
    }
)
GROUP_ROWS: Final = 100_000
"""Rows after which a row group is closed."""
MILLIMETRES: Final = 1000.0
FARTHEST: Final = 2_000_000.0
"""Largest coordinate [m] that fits into int32 millimetres."""


class Rows(NamedTuple):
    """Rows of one recording: (R,) frame numbers, (R,) ids, (R, 2) positions [m]."""

    frame: NDArray[np.int64]
    identity: NDArray[np.int64]
    position: NDArray[np.float64]


class TracksWriter:
    """Writes recordings to a Parquet file, a row group in memory at a time.

    Used as a context; the file is whole when it ends.

    Args:
        path: File to write.
    """

    def __init__(self, path: Path) -> None:
        self._writer = pq.ParquetWriter(
            path,
            SCHEMA,
            compression="zstd",
            use_dictionary=False,
            column_encoding=dict.fromkeys(SCHEMA.names, "DELTA_BINARY_PACKED"),
        )
        self._waiting: list[pa.RecordBatch] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if kind is None:
            self._write_group()
        self._writer.close()

    def add(self, number: int, stretch: Recording) -> None:
        """Write a recording, or its next stretch in time.

        Args:
            number: Number of the recording; never smaller than the one before.
            stretch: What to write.

        Raises:
            ValueError: Nobody was seen, or a coordinate does not fit.
        """
        self._waiting.append(_batch(number, stretch))
        if sum(batch.num_rows for batch in self._waiting) >= GROUP_ROWS:
            self._write_group()

    def _write_group(self) -> None:
        if self._waiting:
            table = pa.Table.from_batches(self._waiting)
            self._writer.write_table(table, row_group_size=table.num_rows)
            self._waiting = []


def _batch(number: int, stretch: Recording) -> pa.RecordBatch:
    frame, identity, position = stretch.to_rows()
    if len(frame) == 0:
        raise ValueError(f"{stretch.name}: expected somebody to be seen, found nobody")
    if np.abs(position).max() > FARTHEST:
        raise ValueError(f"{stretch.name}: a coordinate is beyond {FARTHEST:.0f} m")
    x_mm, y_mm = np.rint(position * MILLIMETRES).astype(np.int32).T
    recording = np.full(len(frame), number, dtype=np.int32)
    columns = [recording, identity, frame, np.ascontiguousarray(x_mm), np.ascontiguousarray(y_mm)]
    return pa.record_batch([pa.array(column) for column in columns], schema=SCHEMA)


def read_tracks(path: Path) -> Iterator[tuple[int, Rows]]:
    """Read a file of tracks, a row group in memory at a time.

    Yields:
        Number of the recording and its rows in one row group; those of one recording follow each
        other, and frames of the next are later.

    Raises:
        ValueError: The file holds other columns.
    """
    with pq.ParquetFile(path) as file:
        if not file.schema_arrow.equals(SCHEMA):
            raise ValueError(f"{path}: expected columns {SCHEMA.names}, found {file.schema_arrow}")
        for group in range(file.num_row_groups):
            yield from _split(file.read_row_group(group, use_threads=False))


def _split(table: pa.Table) -> Iterator[tuple[int, Rows]]:
    recording, identity, frame, x_mm, y_mm = (table[name].to_numpy() for name in SCHEMA.names)
    position = np.column_stack([x_mm, y_mm]) / MILLIMETRES
    starts = np.flatnonzero(np.diff(recording, prepend=-1))
    for start, end in zip(starts, [*starts[1:], len(recording)], strict=True):
        part = slice(start, end)
        yield int(recording[start]), Rows(frame[part], identity[part], position[part])
