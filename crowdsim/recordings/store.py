"""Store of recordings: Parquet tracks, PNG maps and a manifest with checksums.

A data set is a folder. Its tracks lie in shards, sorted by (recording, person, frame), as whole
millimetres, delta-packed and zstd-compressed; 10 million rows take about 30 MB. `manifest.json` is
written last, so a folder without one is not a data set yet, and no file ever stands half-written
under its final name.
"""

import hashlib
import io
import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from crowdsim.recordings.recording import Picture, Recording

FORMAT: Final = "crowdsim-recordings"
VERSION: Final = 1
MANIFEST: Final = "manifest.json"
COLUMNS: Final = {
    "recording": pa.int32(),
    "id": pa.int64(),
    "frame": pa.int64(),
    "x_mm": pa.int32(),
    "y_mm": pa.int32(),
}
MILLIMETRES: Final = 1000.0
UNFINISHED: Final = ".part"
"""End of the name of a file that is being written."""
FARTHEST: Final = 2_000_000.0
"""Largest coordinate [m] that fits into int32 millimetres."""


def write_recordings(
    folder: Path | str,
    recordings: Iterable[Recording],
    *,
    metadata: Mapping[str, Any] | None = None,
) -> None:
    """Write a data set of one shard. People that were never seen are left out.

    Args:
        folder: Where to; made if needed.
        recordings: What to write; positions are rounded to the nearest millimetre.
        metadata: Anything JSON-able worth keeping (seed, command, source).

    Raises:
        FileExistsError: The folder holds a data set already.
        ValueError: Names repeat, nobody was seen, or a coordinate does not fit.
    """
    folder = Path(folder)
    require_no_dataset(folder)
    shard = write_shard(folder, 0, list(recordings))
    write_manifest(folder, [shard], metadata)


def read_recordings(folder: Path | str) -> list[Recording]:
    """All recordings of a data set; see `iter_recordings`."""
    return list(iter_recordings(folder))


def iter_recordings(folder: Path | str) -> Iterator[Recording]:
    """Recordings of a data set, one shard in memory at a time.

    Raises:
        FileNotFoundError: No data set at this folder.
        ValueError: A file is of another format, or damaged (its checksum differs).
    """
    folder = Path(folder)
    for shard in read_manifest(folder)["shards"]:
        yield from _read_shard(folder, shard)


def require_no_dataset(folder: Path) -> None:
    """Raise FileExistsError where `folder` already holds a data set."""
    if (folder / MANIFEST).exists():
        raise FileExistsError(
            f"expected a folder without a data set, found {folder / MANIFEST}; "
            "choose another folder or remove this one"
        )


def write_shard(folder: Path, index: int, recordings: Sequence[Recording]) -> dict[str, Any]:
    """Write tracks and maps of some recordings; returns their entry for the manifest.

    Raises:
        ValueError: Names repeat, nobody was seen, or a coordinate does not fit.
    """
    folder.mkdir(parents=True, exist_ok=True)
    names = [recording.name for recording in recordings]
    if len(set(names)) != len(names):
        raise ValueError(f"names of recordings must be unique, got {names}")
    file = f"tracks-{index:05d}.parquet"
    content = _parquet_bytes(recordings)
    write_atomic(folder / file, content)
    return {
        "file": file,
        "sha256": _sha256(content),
        "recordings": [_describe(folder, recording) for recording in recordings],
    }


def is_intact(folder: Path, shard: Mapping[str, Any]) -> bool:
    """Tell whether all files of a shard stand and are what its entry (of `write_shard`) says."""
    pictures = [entry["picture"] for entry in shard["recordings"]]
    try:
        for file in (shard, *(picture for picture in pictures if picture is not None)):
            _read_checked(folder / file["file"], file["sha256"])
    except (FileNotFoundError, ValueError):
        return False
    return True


def write_manifest(
    folder: Path, shards: Sequence[Mapping[str, Any]], metadata: Mapping[str, Any] | None = None
) -> None:
    """Turn a folder of shards into a data set."""
    manifest = {
        "format": FORMAT,
        "version": VERSION,
        "metadata": {} if metadata is None else dict(metadata),
        "shards": list(shards),
    }
    text = json.dumps(manifest, indent=1, allow_nan=False) + "\n"
    write_atomic(folder / MANIFEST, text.encode())


def read_manifest(folder: Path) -> dict[str, Any]:
    """The manifest of a data set.

    Raises:
        FileNotFoundError: No data set at this folder.
        ValueError: Another format or version.
    """
    path = folder / MANIFEST
    if not path.is_file():
        raise FileNotFoundError(f"expected a data set with {MANIFEST} at {folder}, found none")
    try:
        manifest: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        found = (manifest["format"], manifest["version"])
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{path}: expected a manifest of {FORMAT}, found {error!r}") from error
    if found != (FORMAT, VERSION):
        raise ValueError(f"{path}: expected format {FORMAT} version {VERSION}, found {found}")
    return manifest


def write_atomic(path: Path, content: bytes) -> None:
    """Write a file so that it is there whole or not at all."""
    # Workers may write the same map at once, and one may be killed: no two share a temporary.
    temporary = path.with_name(f".{path.name}.{os.getpid()}{UNFINISHED}")
    temporary.write_bytes(content)
    temporary.replace(path)


def _parquet_bytes(recordings: Sequence[Recording]) -> bytes:
    rows = [_rows(index, recording) for index, recording in enumerate(recordings)]
    merged = np.concatenate(rows) if rows else np.empty((0, len(COLUMNS)), dtype=np.int64)
    arrays = [
        pa.array(merged[:, column], type=dtype) for column, dtype in enumerate(COLUMNS.values())
    ]
    sink = io.BytesIO()
    pq.write_table(
        pa.table(arrays, names=list(COLUMNS)),
        sink,
        compression="zstd",
        use_dictionary=False,
        column_encoding=dict.fromkeys(COLUMNS, "DELTA_BINARY_PACKED"),
    )
    return sink.getvalue()


def _rows(index: int, recording: Recording) -> NDArray[np.int64]:
    """(R, 5) whole numbers in the order of `COLUMNS`, track-major."""
    person, row = np.nonzero(recording.valid.T)
    position = recording.positions[row, person]
    if len(position) == 0:
        raise ValueError(f"{recording.name}: expected somebody to be seen, found nobody")
    if np.abs(position).max() > FARTHEST:
        raise ValueError(f"{recording.name}: a coordinate is beyond {FARTHEST:.0f} m")
    millimetres = np.rint(position * MILLIMETRES).astype(np.int64)
    columns = [np.full(len(row), index), recording.ids[person], recording.frames[row]]
    return np.column_stack([*columns, millimetres])


def _describe(folder: Path, recording: Recording) -> dict[str, Any]:
    return {
        "name": recording.name,
        "dt": recording.dt,
        "frames": _runs(recording.frames),
        "picture": _write_picture(folder, recording.picture),
    }


def _runs(frames: NDArray[np.int64]) -> list[list[int]]:
    """Frame numbers as stretches [first, step, count]; keeps the rows in which nobody is seen."""
    runs: list[list[int]] = []
    for frame in frames.tolist():
        if runs and runs[-1][2] == 1:
            runs[-1][1:] = [frame - runs[-1][0], 2]
        elif runs and frame == runs[-1][0] + runs[-1][1] * runs[-1][2]:
            runs[-1][2] += 1
        else:
            runs.append([frame, 1, 1])
    return runs


def _write_picture(folder: Path, picture: Picture | None) -> dict[str, Any] | None:
    """Store a picture once per content, named by it; (3, 3) matrices go into the manifest."""
    if picture is None:
        return None
    content = cv2.imencode(".png", cv2.cvtColor(picture.image, cv2.COLOR_RGB2BGR))[1].tobytes()
    digest = _sha256(content)
    file = f"map-{digest[:16]}.png"
    if not (folder / file).exists():
        write_atomic(folder / file, content)
    return {"file": file, "sha256": digest, "pixel_from_world": picture.pixel_from_world.tolist()}


def _read_shard(folder: Path, shard: Mapping[str, Any]) -> Iterator[Recording]:
    content = _read_checked(folder / shard["file"], shard["sha256"])
    table = pq.read_table(io.BytesIO(content), columns=list(COLUMNS))
    rows = np.column_stack([table[name].to_numpy().astype(np.int64) for name in COLUMNS])
    for index, entry in enumerate(shard["recordings"]):
        yield _rebuild(folder, entry, rows[rows[:, 0] == index])


def _rebuild(folder: Path, entry: Mapping[str, Any], rows: NDArray[np.int64]) -> Recording:
    frames = np.concatenate(
        [first + step * np.arange(count, dtype=np.int64) for first, step, count in entry["frames"]]
    )
    ids, column = np.unique(rows[:, 1], return_inverse=True)
    row = np.searchsorted(frames, rows[:, 2])
    positions = np.zeros((len(frames), len(ids), 2))
    positions[row, column] = rows[:, 3:] / MILLIMETRES
    valid = np.zeros((len(frames), len(ids)), dtype=np.bool_)
    valid[row, column] = True
    return Recording(
        name=entry["name"],
        positions=positions,
        valid=valid,
        ids=ids,
        frames=frames,
        dt=entry["dt"],
        picture=_read_picture(folder, entry["picture"]),
    )


def _read_picture(folder: Path, entry: Mapping[str, Any] | None) -> Picture | None:
    if entry is None:
        return None
    content = _read_checked(folder / entry["file"], entry["sha256"])
    image = cv2.imdecode(np.frombuffer(content, dtype=np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise ValueError(f"{folder / entry['file']}: expected a PNG picture")
    rgb = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), dtype=np.uint8)
    return Picture(rgb, np.array(entry["pixel_from_world"], dtype=np.float64))


def _read_checked(path: Path, sha256: str) -> bytes:
    if not path.is_file():
        raise FileNotFoundError(f"expected {path} as its manifest says, found none")
    content = path.read_bytes()
    if _sha256(content) != sha256:
        raise ValueError(f"{path}: damaged, its SHA-256 is not {sha256[:16]}… of the manifest")
    return content


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
