"""Recordings that are too long for memory: stretches of time, one after the other.

Several `Recording`s of one name in a row are stretches of one recording; their frames do not
overlap. Readers give them, writers take them, and nothing holds more than one at a time.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings.recording import Recording

Table = NDArray[np.void]
"""(R,) structured array: rows with named columns."""


def join(stretches: Iterable[Recording]) -> Recording:
    """Put the stretches of one recording together. People that were never seen are left out.

    Raises:
        ValueError: There is no stretch, nobody was seen, or frames overlap.
    """
    parts = list(stretches)
    if len(parts) == 0:
        raise ValueError("expected at least one stretch of a recording, found none")
    if len(parts) == 1:
        return parts[0]
    first = parts[0]
    frame, identity, position = zip(*(part.to_rows() for part in parts), strict=True)
    return Recording.from_rows(
        first.name,
        np.concatenate(frame),
        np.concatenate(identity),
        np.concatenate(position),
        dt=first.dt,
        picture=first.picture,
        frames=np.concatenate([part.frames for part in parts]),
    )


def joined(stretches: Iterable[Recording]) -> Iterator[Recording]:
    """Whole recordings, one at a time."""
    for _, parts in groupby(stretches, key=lambda part: part.name):
        yield join(parts)


def overlapping(stretches: Iterable[Recording], rows: int) -> Iterator[Recording]:
    """Begin every stretch with the last rows of the one before.

    With `rows` one less than the length of a window, the windows (of stride 1) of all stretches
    are those of the whole recordings, each once.

    Args:
        stretches: Recordings in stretches.
        rows: Rows that are repeated, at least 1.
    """
    for _, parts in groupby(stretches, key=lambda part: part.name):
        before = None
        for part in parts:
            extended = part if before is None else join([before, part])
            yield extended
            before = _last_rows(extended, rows)


def _last_rows(recording: Recording, rows: int) -> Recording:
    return replace(
        recording,
        positions=recording.positions[-rows:],
        valid=recording.valid[-rows:],
        frames=recording.frames[-rows:],
    )


def cut(source: str, blocks: Iterable[Table]) -> Iterator[Recording]:
    """Make stretches of blocks of rows, no frame in two of them.

    Args:
        source: What is read; the stretches are named by it.
        blocks: Rows with the fields `frame`, `person`, `x` and `y`. Frames may go back within a
            block, not behind one.

    Raises:
        ValueError: There is no row, a person is twice in a frame, or frames go back.
    """
    pending: Table | None = None
    done: int | None = None
    for block in blocks:
        if pending is None:
            pending = block
            continue
        # The last frame of a block may go on in the next one.
        ready = pending["frame"] < pending["frame"].max()
        if ready.any():
            yield _stretch(source, pending[ready], done)
            done = int(pending["frame"][ready].max())
        pending = np.concatenate([pending[~ready], block])
    if pending is None:
        raise ValueError(f"{source}: a recording needs at least one row, got none")
    yield _stretch(source, pending, done)


def _stretch(source: str, rows: Table, done: int | None) -> Recording:
    if done is not None and rows["frame"].min() <= done:
        raise ValueError(
            f"{source}: expected a file of this length sorted by frame, "
            f"found frame {rows['frame'].min()} far behind frame {done}"
        )
    position = np.column_stack([rows["x"], rows["y"]])
    return Recording.from_rows(source, rows["frame"], rows["person"], position)
