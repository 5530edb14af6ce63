"""Windows on the disk, memory-mapped: cut once, shared by all runs, larger than memory if need be.

One folder for each data set and way of cutting it, named by a digest of both: one file of raw
numbers for each array, and `windows.json`, written last, that says their shapes.
"""

import hashlib
import json
import shutil
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from tempfile import mkdtemp
from typing import Any, BinaryIO, Final

import numpy as np

from crowdsim.recordings import Recording
from crowdsim.recordings.store import write_atomic
from predictor.config import NetworkConfig
from predictor.windows import Tracks, Windows, cut, nobody_stays, on_maps

LAYOUT: Final = 1
"""Raised when the arrays change, so that older folders are not read."""
DESCRIPTION: Final = "windows.json"


def cached_windows(
    folder: Path, recordings: list[Recording], config: NetworkConfig, *, stride: int = 1
) -> Windows:
    """Windows as `predictor.windows.extract_windows`, memory-mapped from `folder`.

    What is not there yet is cut and written first, whole or not at all.

    Raises:
        ValueError: There is no window, a recording has another `dt`, or a file is damaged.
    """
    place = folder / _digest(recordings, config, stride)
    if not (place / DESCRIPTION).is_file():
        _write(place, cut(recordings, config, stride), nobody_stays(config))
    return on_maps(_map(place), recordings, config)


def _digest(recordings: list[Recording], config: NetworkConfig, stride: int) -> str:
    """Of all that the windows depend on; maps and names are not in the arrays."""
    steps = (config.history_steps, config.forecast_steps, config.neighbors, config.frame_dt)
    digest = hashlib.sha256(repr((LAYOUT, steps, stride)).encode())
    for recording in recordings:
        digest.update(repr((recording.positions.shape, recording.dt)).encode())
        for array in (recording.positions, recording.valid):
            digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()[:16]


def _write(place: Path, parts: Iterable[Tracks], nobody: str) -> None:
    """Write the arrays part by part into a folder beside `place`, which then becomes it."""
    place.parent.mkdir(parents=True, exist_ok=True)
    temporary = Path(mkdtemp(prefix=f".{place.name}.", dir=place.parent))
    try:
        description = _append(temporary, parts)
        if not description:
            raise ValueError(nobody)
        write_atomic(temporary / DESCRIPTION, json.dumps(description, indent=1).encode() + b"\n")
        temporary.replace(place)
    except OSError:
        # another run may have been first; its windows are the same
        if not (place / DESCRIPTION).is_file():
            raise
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _append(folder: Path, parts: Iterable[Tracks]) -> dict[str, Any]:
    """Names, types and shapes of the arrays written; empty if there was no part."""
    description: dict[str, Any] = {}
    files: dict[str, BinaryIO] = {}
    count = 0
    with ExitStack() as stack:
        for part in parts:
            for name, array in part.arrays().items():
                if name not in files:
                    files[name] = stack.enter_context((folder / name).open("wb"))
                array.tofile(files[name])
                shape = [count + len(part), *array.shape[1:]]
                description[name] = {"dtype": array.dtype.str, "shape": shape}
            count += len(part)
    return description


def _map(place: Path) -> Tracks:
    description = json.loads((place / DESCRIPTION).read_text(encoding="utf-8"))
    arrays = {}
    for name, entry in description.items():
        shape, dtype = tuple(entry["shape"]), np.dtype(entry["dtype"])
        expected, found = int(np.prod(shape)) * dtype.itemsize, (place / name).stat().st_size
        if found != expected:
            raise ValueError(
                f"{place / name}: expected {expected} bytes, found {found}; remove the folder"
            )
        arrays[name] = np.memmap(place / name, dtype=dtype, mode="r", shape=shape)
    return Tracks(**arrays)
