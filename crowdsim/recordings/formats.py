"""Formats by name: told from a path or its contents, read and written in stretches."""

from collections.abc import Callable, Iterable, Iterator
from itertools import chain, groupby
from pathlib import Path
from typing import Final, Literal

from crowdsim.recordings.eth_ucy_text import (
    iter_eth_ucy,
    iter_obsmat,
    write_eth_ucy,
    write_obsmat,
)
from crowdsim.recordings.recording import Recording
from crowdsim.recordings.sdd import sdd_scales
from crowdsim.recordings.sdd_text import (
    BOX_HEADER,
    SNIPPET_HEADER,
    Scales,
    iter_sdd_snippets,
    read_sdd_boxes,
    scale_of,
    write_sdd_snippets,
)
from crowdsim.recordings.store import MANIFEST, iter_stretches, write_recordings
from crowdsim.recordings.stretches import joined
from crowdsim.recordings.text_table import first_line, plain_stem
from crowdsim.recordings.trajnet import iter_trajnet, write_trajnet

Format = Literal["dataset", "eth_ucy", "obsmat", "trajnet", "sdd"]
Stretches = Iterable[Recording]
SUFFIXES: Final[dict[str, Format]] = {
    "": "dataset",
    ".txt": "eth_ucy",
    ".ndjson": "trajnet",
    ".csv": "sdd",
}
COLUMNS: Final[dict[int, Format]] = {4: "eth_ucy", 8: "obsmat", 10: "sdd"}
"""What a text file without a header is by the columns of its first line."""


def format_of_input(path: Path) -> Format:
    """Tell the format of what stands at a path.

    Raises:
        FileNotFoundError: Nothing stands there.
        ValueError: It looks like none of the formats.
    """
    if path.is_dir() or path.name == MANIFEST:
        return "dataset"
    line = first_line(path)
    if line.startswith("{"):
        return "trajnet"
    if line in (SNIPPET_HEADER, BOX_HEADER):
        return "sdd"
    columns = len(line.split())
    if columns not in COLUMNS:
        raise ValueError(
            f"{path}, line 1: expected JSON, a header of SDD, or {sorted(COLUMNS)} columns, "
            f"found {line[:80]!r}; name its format"
        )
    return COLUMNS[columns]


def format_of_output(path: Path) -> Format:
    """Tell the format that a path to be written asks for.

    Raises:
        ValueError: No format ends like this.
    """
    if plain_stem(path) == "obsmat":
        return "obsmat"
    suffix = Path(path.name.removesuffix(".gz")).suffix
    if suffix not in SUFFIXES:
        raise ValueError(
            f"{path}: expected a folder or a file ending in {', '.join(filter(None, SUFFIXES))} "
            "(and .gz); name its format"
        )
    return SUFFIXES[suffix]


def iter_format(
    path: Path, form: Format, *, dt: float | None = None, metres_per_px: float | None = None
) -> Iterator[Recording]:
    """Read any format in stretches; several in a row of one name are one recording.

    Args:
        path: What to read.
        form: Its format.
        dt: Time of a frame step [s]; None leaves it to the reader.
        metres_per_px: Scale of pixels; None looks for `scales.csv` of SDD above the file.

    Raises:
        FileNotFoundError: Nothing stands there.
        ValueError: A damaged file, an unexplained rate, or a scale that is not known.
    """
    if form == "dataset":
        if dt is not None:
            raise ValueError(f"{path}: a data set states its own time step, leave out dt {dt}")
        return iter_stretches(path.parent if path.name == MANIFEST else path)
    if form == "sdd":
        return _iter_sdd(path, dt, metres_per_px)
    readers = {"eth_ucy": iter_eth_ucy, "obsmat": iter_obsmat, "trajnet": iter_trajnet}
    return readers[form](path, dt=dt)


def _iter_sdd(path: Path, dt: float | None, metres_per_px: float | None) -> Iterator[Recording]:
    scales = _scales_above(path) if metres_per_px is None else metres_per_px
    if first_line(path) == SNIPPET_HEADER:
        yield from iter_sdd_snippets(path, scales, dt=dt)
    else:
        yield read_sdd_boxes(path, scale_of(scales, plain_stem(path)), dt=dt)


def _scales_above(path: Path) -> Scales:
    for folder in path.resolve().parents[:2]:
        if (folder / "scales.csv").is_file():
            return sdd_scales(folder)
    raise ValueError(f"{path}: expected scales.csv beside or above it, found none; name the scale")


ONE_PER_FILE: Final[dict[Format, tuple[Callable[[Path, Stretches], None], str]]] = {
    "eth_ucy": (write_eth_ucy, ".txt"),
    "obsmat": (write_obsmat, ".txt"),
    "trajnet": (write_trajnet, ".ndjson"),
}
"""Formats of one recording per file: how to write it, and how the file ends."""


def write_format(
    path: Path, form: Format, stretches: Stretches, *, metres_per_px: float | None = None
) -> None:
    """Write any format, a stretch in memory at a time.

    Args:
        path: A file, or a folder: of the data set, or of one file for every recording.
        form: The format.
        stretches: Recordings, each whole or in stretches.
        metres_per_px: Scale of pixels, for SDD.

    Raises:
        FileExistsError: A data set stands there already.
        ValueError: No recording, several for one file of one, or SDD without a scale.
    """
    # What cannot be read leaves no file and no folder.
    waiting = iter(stretches)
    first = next(waiting, None)
    if first is None:
        raise ValueError(f"{path}: expected at least one recording to write, found none")
    stretches = chain([first], waiting)
    if form == "dataset":
        write_recordings(path, stretches)
    elif form == "sdd":
        if metres_per_px is None:
            raise ValueError(f"{path}: expected metres per pixel for SDD, found none")
        write_sdd_snippets(path, joined(stretches), metres_per_px)
    else:
        write, suffix = ONE_PER_FILE[form]
        if path.suffix:
            write(path, _only_one(path, stretches))
            return
        for name, parts in groupby(stretches, key=lambda part: part.name):
            write(path / f"{name}{suffix}", parts)


def _only_one(path: Path, stretches: Stretches) -> Iterator[Recording]:
    name = None
    for part in stretches:
        if name not in (None, part.name):
            raise ValueError(
                f"{path}: expected one recording for one file, found {name!r} and "
                f"{part.name!r}; name a folder"
            )
        name = part.name
        yield part
