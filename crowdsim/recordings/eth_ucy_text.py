"""Text of the ETH and UCY crowds: the standard split files and the original annotation `obsmat`.

Sources: Pellegrini et al., ICCV 2009 (ETH); Lerner et al., 2007 (UCY). World metres.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings.rate import rated
from crowdsim.recordings.recording import Picture, Recording
from crowdsim.recordings.stretches import cut, join
from crowdsim.recordings.text_table import format_rows, plain_stem, read_blocks, write_lines

ETH_UCY_COLUMNS: Final = np.dtype([("frame", "i8"), ("person", "i8"), ("x", "f8"), ("y", "f8")])
OBSMAT_COLUMNS: Final = np.dtype(
    [("frame", "i8"), ("person", "i8")] + [(n, "f8") for n in ("x", "z", "y", "vx", "vz", "vy")]
)
ETH_UCY_ROW: Final = "%d\t%d\t%.3f\t%.3f\n"
OBSMAT_ROW: Final = 8 * "  %.7e" + "\n"


def read_eth_ucy(
    path: Path | str, *, dt: float | None = None, picture: Picture | None = None
) -> Recording:
    """Read a split text file: white space separated frame, person, x [m], y [m].

    `biwi_eth` of the standard files was resampled: its rows, taken as 0.4 s apart like everybody
    does, are about 0.67 s apart. `read_obsmat` has the original 0.4 s.

    Args:
        path: The text file, plain or gzipped.
        dt: Time between two consecutive frames [s]; None asks for the 0.4 s of all these files,
            which the frame numbers must explain.
        picture: Ground picture to attach.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: Not four numeric columns, or a time step that frames or speeds contradict.
    """
    return replace(join(iter_eth_ucy(path, dt=dt)), picture=picture)


def iter_eth_ucy(path: Path | str, *, dt: float | None = None) -> Iterator[Recording]:
    """Read a split text file, sorted by frame, in stretches; see `read_eth_ucy`."""
    path = Path(path)
    yield from _iter_text(path, ETH_UCY_COLUMNS, plain_stem(path), dt)


def read_obsmat(
    path: Path | str, *, dt: float | None = None, picture: Picture | None = None
) -> Recording:
    """Read an original annotation: frame, person, x, (z), y, vx, (vz), vy; metres.

    Args:
        path: The text file, plain or gzipped; one called `obsmat` is named by its folder.
        dt: As `read_eth_ucy`.
        picture: Ground picture to attach.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: Not eight numeric columns, or a time step that frames or speeds contradict.
    """
    return replace(join(iter_obsmat(path, dt=dt)), picture=picture)


def iter_obsmat(path: Path | str, *, dt: float | None = None) -> Iterator[Recording]:
    """Read an original annotation, sorted by frame, in stretches; see `read_obsmat`."""
    path = Path(path)
    name = plain_stem(path)
    name = path.resolve().parent.name if name == "obsmat" else name
    yield from _iter_text(path, OBSMAT_COLUMNS, name, dt)


def _iter_text(
    path: Path, columns: np.dtype[np.void], name: str, dt: float | None
) -> Iterator[Recording]:
    yield from rated(cut(str(path), read_blocks(path, columns)), name, dt=dt)


def write_eth_ucy(path: Path | str, stretches: Iterable[Recording]) -> None:
    """Write one recording as a split text file, positions to a millimetre.

    Rows in which nobody is seen, pictures and `dt` have no place in it.

    Args:
        path: File to write; gzipped if it ends in `.gz`.
        stretches: The recording, whole or in stretches.
    """
    write_lines(
        Path(path), (format_rows(ETH_UCY_ROW, *part.to_rows(by_frame=True)) for part in stretches)
    )


def write_obsmat(path: Path | str, stretches: Iterable[Recording]) -> None:
    """Write one recording as `obsmat`, with velocities as in the original: central differences.

    A person's first and last row have the velocity of one step; somebody seen once stands still.

    Args:
        path: File to write; gzipped if it ends in `.gz`.
        stretches: The recording, whole or in stretches.
    """
    write_lines(Path(path), (_obsmat_text(part) for part in stretches))


def _obsmat_text(part: Recording) -> str:
    frame, person, position = part.to_rows(by_frame=True)
    velocity, height = _velocities(part)[part.valid], np.zeros(len(frame))
    (x, y), (vx, vy) = position.T, velocity.T
    return format_rows(OBSMAT_ROW, frame, person, x, height, y, vx, height, vy)


def _velocities(part: Recording) -> NDArray[np.float64]:
    """(T, N, 2) velocities [m/s]: mean of the steps from the last and to the next row."""
    time = part.dt * np.diff(part.frames) / part.frame_step
    step = np.diff(part.positions, axis=0) / time[:, None, None]
    both = part.valid[1:] & part.valid[:-1]
    step[~both] = 0.0
    total, count = np.zeros_like(part.positions), np.zeros(part.valid.shape)
    total[1:] += step
    total[:-1] += step
    count[1:] += both
    count[:-1] += both
    return total / np.maximum(count, 1.0)[..., None]
