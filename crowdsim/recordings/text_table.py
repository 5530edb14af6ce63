"""Text files of rows and columns, read in blocks; what is wrong is named by file and line."""

import gzip
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import BinaryIO, Final, TextIO, cast

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings.store import new_file
from crowdsim.recordings.stretches import Table

BLOCK_ROWS: Final = 20_000
"""Rows in memory at a time. A block becomes a dense (T, N) array, which grows with its square."""

LONGEST_QUOTE: Final = 80
"""Characters of a wrong line that its message repeats."""


@contextmanager
def open_text(path: Path) -> Iterator[TextIO]:
    """Open a plain or gzipped (`.gz`) text file for reading; bytes that are no text become `�`.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: It is a damaged gzip file.
    """
    try:
        if path.suffix == ".gz":
            with gzip.open(path, "rt", encoding="utf-8", errors="replace") as packed:
                yield packed
        else:
            with path.open(encoding="utf-8", errors="replace") as plain:
                yield plain
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise ValueError(f"{path}: damaged gzip file: {error}") from error


def plain_stem(path: Path) -> str:
    """Name of a text file without its endings `.gz` and `.txt` or the like."""
    return Path(path.name.removesuffix(".gz")).stem


def first_line(path: Path) -> str:
    """The first line of a text file without its end; empty for an empty file."""
    with open_text(path) as file:
        return file.readline().strip()


def write_lines(path: Path, lines: Iterable[str]) -> None:
    """Write lines to a text file, gzipped if it ends in `.gz`, so that it is there whole or not."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with new_file(path) as temporary, temporary.open("wb") as raw, _compressed(path, raw) as file:
        for line in lines:
            file.write(line.encode())


def format_rows(form: str, *columns: NDArray[np.int64] | NDArray[np.float64]) -> str:
    """Lines of text from (R,) or (R, C) columns; one format operation for all is the quickest.

    Args:
        form: What one row becomes, with a place such as `%d` or `%.3f` for every number.
        columns: Whole numbers, exact up to 2^53, and others.
    """
    table = np.column_stack(columns)
    return form * len(table) % tuple(table.ravel().tolist())


def _compressed(path: Path, raw: BinaryIO) -> BinaryIO:
    """Without the time and the name in it, so that the same lines give the same bytes."""
    if path.suffix != ".gz":
        return raw
    return cast(BinaryIO, gzip.GzipFile(filename="", mode="wb", fileobj=raw, mtime=0))


def read_blocks(
    path: Path, dtype: np.dtype[np.void], *, delimiter: str | None = None, skip_lines: int = 0
) -> Iterator[Table]:
    """Read rows of named columns, `BLOCK_ROWS` at a time.

    Args:
        path: Plain or gzipped text file.
        dtype: Names and types of the columns, in their order.
        delimiter: What stands between two columns; None is any white space.
        skip_lines: Lines before the first row.

    Yields:
        (R,) structured arrays, R at least 1.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: A line is no such row, or holds NaN or infinity; the message has its number.
    """
    with open_text(path) as file:
        numbered = islice(enumerate(file, start=1), skip_lines, None)
        rows = ((number, line) for number, line in numbered if line.strip())
        while block := list(islice(rows, BLOCK_ROWS)):
            yield _parse(path, block, dtype, delimiter)


def _parse(
    path: Path, block: list[tuple[int, str]], dtype: np.dtype[np.void], delimiter: str | None
) -> Table:
    lines = [line for _, line in block]
    try:
        return _parse_lines(lines, dtype, delimiter)
    except ValueError as error:
        if len(block) == 1:
            raise ValueError(
                f"{path}, line {block[0][0]}: expected {_spell(dtype)}, "
                f"found {lines[0].strip()[:LONGEST_QUOTE]!r}"
            ) from error
    # Only now is it worth the time to look for the line.
    half = len(block) // 2
    _parse(path, block[:half], dtype, delimiter)
    return _parse(path, block[half:], dtype, delimiter)


def _parse_lines(lines: list[str], dtype: np.dtype[np.void], delimiter: str | None) -> Table:
    """Rows of `dtype`; whole numbers may be written as `780.0` or `7.8e+02`."""
    read_as = np.dtype([(name, _read_type(dtype[name])) for name in _names(dtype)])
    raw = np.loadtxt(
        lines, dtype=read_as, delimiter=delimiter, comments=None, quotechar='"', ndmin=1
    )
    table: Table = np.empty(len(raw), dtype=dtype)
    for name in _names(dtype):
        column = raw[name]
        if column.dtype.kind == "f" and not np.isfinite(column).all():
            raise ValueError(f"{name} is not finite")
        with np.errstate(invalid="ignore"):
            table[name] = column
        if np.any(table[name] != column):
            raise ValueError(f"{name} is not a whole number")
    return table


def _read_type(dtype: np.dtype[np.generic]) -> np.dtype[np.generic]:
    return np.dtype(np.float64) if dtype.kind == "i" else dtype


def _names(dtype: np.dtype[np.void]) -> tuple[str, ...]:
    return () if dtype.names is None else dtype.names


def _spell(dtype: np.dtype[np.void]) -> str:
    """What a row is made of, in words."""
    kinds = {"i": "whole", "f": "number", "U": "text"}
    columns = [f"{name} ({kinds[dtype[name].kind]})" for name in _names(dtype)]
    return f"{len(columns)} columns {', '.join(columns)}"
