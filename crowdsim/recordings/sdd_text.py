"""Text of the Stanford Drone Dataset: the standard snippets and the annotated boxes.

Both hold pixels: u to the right, v down from the centre of the corner pixel. The drone looks
straight down, so world metres are x = s u and y = -s v for a scale of s metres per pixel.
"""

from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings.rate import rated
from crowdsim.recordings.recording import Recording
from crowdsim.recordings.stretches import Table
from crowdsim.recordings.text_table import first_line, plain_stem, read_blocks, write_lines

SDD_FPS: Final = (30.0,)
SDD_FRAME_STEP: Final = 12
"""Every twelfth frame is a row: 0.4 s."""
PEDESTRIAN: Final = "Pedestrian"
SNIPPET_HEADER: Final = "video,frame,track,x_px,y_px"
SNIPPET_COLUMNS: Final = np.dtype(
    [("video", "U64"), ("frame", "i8"), ("track", "i8"), ("x_px", "f8"), ("y_px", "f8")]
)
_BOX: Final = [(name, "f8") for name in ("xmin", "ymin", "xmax", "ymax")]
_FLAGS: Final = [("lost", "i8"), ("occluded", "i8"), ("generated", "i8"), ("label", "U16")]
BOX_COLUMNS: Final = np.dtype([("track", "i8"), ("frame", "i8"), *_BOX, *_FLAGS])
BOX_HEADER: Final = ",".join(BOX_COLUMNS.names or ())
ORIGINAL_COLUMNS: Final = np.dtype([("track", "i8"), *_BOX, ("frame", "i8"), *_FLAGS])
"""Columns of the published `annotations.txt`, which are separated by blanks, without a header."""

Scales = Mapping[str, float] | float
"""Metres per pixel, by video or the same for all."""


def iter_sdd_snippets(
    path: Path | str, scales: Scales, *, dt: float | None = None
) -> Iterator[Recording]:
    """Read a file of the standard split, one video in memory at a time.

    A person is one snippet of 20 rows: the same human being comes back under other ids.

    Args:
        path: CSV with the columns of `SNIPPET_HEADER`, plain or gzipped, sorted by video.
        scales: Metres per pixel.
        dt: Time of a frame step [s]; None asks for 12 frames at 30 fps.

    Yields:
        Recordings named by their video, without pictures.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: Another format, a video without a scale or in two places, or a rate that
            frames or speeds contradict.
    """
    path = Path(path)
    if (found := first_line(path)) != SNIPPET_HEADER:
        raise ValueError(f"{path}, line 1: expected {SNIPPET_HEADER!r}, found {found[:80]!r}")
    done: set[str] = set()
    for video, parts in groupby(_video_parts(path), key=lambda part: str(part["video"][0])):
        if video in done:
            raise ValueError(f"{path}: expected the rows of video {video!r} in one place")
        done.add(video)
        rows = np.concatenate(list(parts))
        pixels = np.column_stack([rows["x_px"], rows["y_px"]])
        yield _recording(path, video, rows, pixels, scale_of(scales, video), dt)


def _video_parts(path: Path) -> Iterator[Table]:
    """Blocks of rows of one video each."""
    for block in read_blocks(path, SNIPPET_COLUMNS, delimiter=",", skip_lines=1):
        changes = np.flatnonzero(block["video"][1:] != block["video"][:-1]) + 1
        yield from np.split(block, changes)


def read_sdd_boxes(
    path: Path | str, scale: float, *, name: str | None = None, dt: float | None = None
) -> Recording:
    """Read the annotation of one video: the centres of all boxes around pedestrians.

    Of a file that lists every frame, every twelfth is taken. Bikers, cars and the like are left
    out, and so are rows that say `lost` (out of view); occluded and interpolated ones stay.

    Args:
        path: CSV with the columns of `BOX_HEADER`, or the published `annotations.txt`; plain or
            gzipped.
        scale: Metres per pixel.
        name: Of the recording; None takes the file's.
        dt: Time of a frame step [s]; None asks for 12 frames at 30 fps.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: Another format, nobody to be seen, or a rate that frames or speeds contradict.
    """
    path = Path(path)
    kept = [
        block[
            (block["lost"] == 0)
            & (block["label"] == PEDESTRIAN)
            & (block["frame"] % SDD_FRAME_STEP == 0)
        ]
        for block in _box_blocks(path)
    ]
    rows = np.concatenate([np.empty(0, dtype=BOX_COLUMNS), *kept])
    left_top = np.column_stack([rows["xmin"], rows["ymin"]])
    right_bottom = np.column_stack([rows["xmax"], rows["ymax"]])
    centre = (left_top + right_bottom) / 2.0
    return _recording(path, plain_stem(path) if name is None else name, rows, centre, scale, dt)


def _box_blocks(path: Path) -> Iterator[Table]:
    if first_line(path) == BOX_HEADER:
        yield from read_blocks(path, BOX_COLUMNS, delimiter=",", skip_lines=1)
        return
    for block in read_blocks(path, ORIGINAL_COLUMNS):
        yield block[list(BOX_COLUMNS.names or ())].astype(BOX_COLUMNS)


def _recording(
    path: Path, name: str, rows: Table, pixels: NDArray[np.float64], scale: float, dt: float | None
) -> Recording:
    position = scale * pixels * [1.0, -1.0]
    recording = Recording.from_rows(f"{path}, {name}", rows["frame"], rows["track"], position)
    return next(rated([recording], name, dt=dt, fps=SDD_FPS))


def scale_of(scales: Scales, video: str) -> float:
    """Metres per pixel of a video.

    Raises:
        ValueError: It has none, or one that is not positive.
    """
    scale = scales.get(video) if isinstance(scales, Mapping) else scales
    if scale is None:
        raise ValueError(f"expected metres per pixel of video {video!r}, found none; state it")
    if not 0.0 < scale < np.inf:
        raise ValueError(f"metres per pixel of video {video!r} must be positive, got {scale}")
    return float(scale)


def write_sdd_snippets(path: Path | str, recordings: Iterable[Recording], scales: Scales) -> None:
    """Write pixels in the form of the standard split, one recording after the other.

    Pictures are not written; pixels are rounded to 0.001. Frame numbers stay: where 0.4 s are not
    12 of them, reading needs `dt`.

    Args:
        path: File to write; gzipped if it ends in `.gz`.
        recordings: What to write, each one whole.
        scales: Metres per pixel.

    Raises:
        ValueError: A recording has no scale.
    """
    write_lines(Path(path), _snippet_lines(recordings, scales))


def _snippet_lines(recordings: Iterable[Recording], scales: Scales) -> Iterator[str]:
    yield SNIPPET_HEADER + "\n"
    for recording in recordings:
        pixels = recording.positions / scale_of(scales, recording.name) * [1.0, -1.0]
        for person, row in np.argwhere(recording.valid.T):
            u, v = pixels[row, person]
            frame, track = recording.frames[row], recording.ids[person]
            yield f"{recording.name},{frame},{track},{u:.3f},{v:.3f}\n"
