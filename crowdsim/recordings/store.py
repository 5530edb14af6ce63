"""Store of recordings: Parquet tracks, PNG maps and a manifest with checksums.

A data set is a folder. Its tracks lie in shards (see `tracks`); 10 million rows take about 30 MB.
`manifest.json` is written last, so a folder without one is not a data set yet, and no file ever
stands half-written under its final name.
"""

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings.recording import Picture, Recording
from crowdsim.recordings.tracks import Rows, TracksWriter, read_tracks

FORMAT: Final = "crowdsim-recordings"
VERSION: Final = 1
MANIFEST: Final = "manifest.json"
UNFINISHED: Final = ".part"
"""End of the name of a file that is being written."""


def write_recordings(
    folder: Path | str,
    recordings: Iterable[Recording],
    *,
    metadata: Mapping[str, Any] | None = None,
) -> None:
    """Write a data set of one shard. People that were never seen are left out.

    Args:
        folder: Where to; made if needed.
        recordings: What to write, one in memory at a time; several in a row of one name are
            stretches of one recording. Positions are rounded to the nearest millimetre.
        metadata: Anything JSON-able worth keeping (seed, command, source).

    Raises:
        FileExistsError: The folder holds a data set already.
        ValueError: Names repeat, nobody was seen, or a coordinate does not fit.
    """
    folder = Path(folder)
    require_no_dataset(folder)
    shard = write_shard(folder, 0, recordings)
    write_manifest(folder, [shard], metadata)


def read_recordings(folder: Path | str) -> list[Recording]:
    """All recordings of a data set; see `iter_recordings`."""
    return list(iter_recordings(folder))


def iter_recordings(folder: Path | str) -> Iterator[Recording]:
    """Whole recordings of a data set, one in memory at a time.

    Raises:
        FileNotFoundError: No data set at this folder.
        ValueError: A file is of another format, or damaged (its checksum differs).
    """
    folder = Path(folder)
    for entry, parts in _iter_entries(folder):
        yield _rebuild(folder, entry, _listed(entry), [rows for _, rows in parts])


def iter_stretches(folder: Path | str) -> Iterator[Recording]:
    """Recordings of a data set in stretches of time, about 100,000 positions in memory at a time.

    A recording that is not longer than that comes whole. `stretches` says how to cut windows
    across the borders.

    Raises:
        FileNotFoundError: No data set at this folder.
        ValueError: A file is of another format, or damaged (its checksum differs).
    """
    folder = Path(folder)
    for entry, parts in _iter_entries(folder):
        frames = _listed(entry)
        for is_last, rows in parts:
            count = len(frames) if is_last else np.searchsorted(frames, rows.frame.max(), "right")
            yield _rebuild(folder, entry, frames[:count], [rows])
            frames = frames[count:]


def require_no_dataset(folder: Path) -> None:
    """Raise FileExistsError where `folder` already holds a data set."""
    if (folder / MANIFEST).exists():
        raise FileExistsError(
            f"expected a folder without a data set, found {folder / MANIFEST}; "
            "choose another folder or remove this one"
        )


def write_shard(folder: Path, index: int, recordings: Iterable[Recording]) -> dict[str, Any]:
    """Write tracks and maps of some recordings; returns their entry for the manifest.

    Args:
        folder: Of the data set.
        index: Number of the shard.
        recordings: As `write_recordings`.

    Raises:
        ValueError: Names repeat, nobody was seen, or a coordinate does not fit.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / shard_name(index)
    entries: dict[str, dict[str, Any]] = {}
    with new_file(path) as temporary, TracksWriter(temporary) as tracks:
        for name, stretches in groupby(recordings, key=lambda part: part.name):
            if name in entries:
                raise ValueError(f"names of recordings must be unique, got {name!r} again")
            for stretch in stretches:
                _enter(folder, entries, stretch)
                tracks.add(len(entries) - 1, stretch)
    return {"file": path.name, "sha256": _sha256(path), "recordings": list(entries.values())}


def _enter(folder: Path, entries: dict[str, dict[str, Any]], stretch: Recording) -> None:
    """Describe a recording, or the next stretch of the last one, for the manifest."""
    entry = entries.get(stretch.name)
    if entry is None:
        entries[stretch.name] = {
            "name": stretch.name,
            "dt": stretch.dt,
            "frames": _extend_runs([], stretch.frames),
            "picture": _write_picture(folder, stretch.picture),
        }
        return
    first, step, count = entry["frames"][-1]
    last = first + step * (count - 1)
    if stretch.frames[0] <= last or stretch.dt != entry["dt"]:
        raise ValueError(
            f"{stretch.name}: expected a stretch after frame {last} with dt {entry['dt']} (or "
            f"another name), found frame {stretch.frames[0]} and dt {stretch.dt}"
        )
    _extend_runs(entry["frames"], stretch.frames)


def shard_name(index: int) -> str:
    """Name of the file that holds the tracks of a shard."""
    return f"tracks-{index:05d}.parquet"


def is_intact(folder: Path, shard: Mapping[str, Any]) -> bool:
    """Tell whether all files of a shard stand and are what its entry (of `write_shard`) says."""
    pictures = [entry["picture"] for entry in shard["recordings"]]
    try:
        for file in (shard, *(picture for picture in pictures if picture is not None)):
            _checked(folder / file["file"], file["sha256"])
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
    with new_file(path) as temporary:
        temporary.write_bytes(content)


@contextmanager
def new_file(path: Path) -> Iterator[Path]:
    """Give a temporary path that becomes `path` when all went well, and is removed if not."""
    # Workers may write the same map at once, and one may be killed: no two share a temporary.
    temporary = path.with_name(f".{path.name}.{os.getpid()}{UNFINISHED}")
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def _extend_runs(runs: list[list[int]], frames: NDArray[np.int64]) -> list[list[int]]:
    """Frame numbers as stretches [first, step, count]; keeps the rows in which nobody is seen."""
    for frame in frames.tolist():
        if runs and runs[-1][2] == 1:
            runs[-1][1:] = [frame - runs[-1][0], 2]
        elif runs and frame == runs[-1][0] + runs[-1][1] * runs[-1][2]:
            runs[-1][2] += 1
        else:
            runs.append([frame, 1, 1])
    return runs


def _listed(entry: Mapping[str, Any]) -> NDArray[np.int64]:
    """(T,) frame numbers of a recording."""
    return np.concatenate(
        [first + step * np.arange(count, dtype=np.int64) for first, step, count in entry["frames"]]
    )


def _write_picture(folder: Path, picture: Picture | None) -> dict[str, Any] | None:
    """Store a picture once per content, named by it; (3, 3) matrices go into the manifest."""
    if picture is None:
        return None
    content = cv2.imencode(".png", cv2.cvtColor(picture.image, cv2.COLOR_RGB2BGR))[1].tobytes()
    digest = hashlib.sha256(content).hexdigest()
    file = f"map-{digest[:16]}.png"
    if not (folder / file).exists():
        write_atomic(folder / file, content)
    return {"file": file, "sha256": digest, "pixel_from_world": picture.pixel_from_world.tolist()}


def _iter_entries(
    folder: Path,
) -> Iterator[tuple[Mapping[str, Any], Iterator[tuple[bool, Rows]]]]:
    """Recordings of all shards: the entry of each, and its rows as `read_tracks` gives them."""
    for shard in read_manifest(folder)["shards"]:
        path = _checked(folder / shard["file"], shard["sha256"])
        for number, parts in groupby(read_tracks(path), key=itemgetter(0)):
            yield shard["recordings"][number], _mark_last(rows for _, rows in parts)


def _mark_last(parts: Iterator[Rows]) -> Iterator[tuple[bool, Rows]]:
    part = next(parts)
    for following in parts:
        yield False, part
        part = following
    yield True, part


def _rebuild(
    folder: Path, entry: Mapping[str, Any], frames: NDArray[np.int64], parts: Sequence[Rows]
) -> Recording:
    frame, identity, position = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Recording.from_rows(
        entry["name"],
        frame,
        identity,
        position,
        dt=entry["dt"],
        picture=_read_picture(folder, entry["picture"]),
        frames=frames,
    )


def _read_picture(folder: Path, entry: Mapping[str, Any] | None) -> Picture | None:
    if entry is None:
        return None
    content = _checked(folder / entry["file"], entry["sha256"]).read_bytes()
    image = cv2.imdecode(np.frombuffer(content, dtype=np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise ValueError(f"{folder / entry['file']}: expected a PNG picture")
    rgb = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), dtype=np.uint8)
    return Picture(rgb, np.array(entry["pixel_from_world"], dtype=np.float64))


def _checked(path: Path, sha256: str) -> Path:
    """The path of a file that is what the manifest says."""
    if not path.is_file():
        raise FileNotFoundError(f"expected {path} as its manifest says, found none")
    if _sha256(path) != sha256:
        raise ValueError(f"{path}: damaged, its SHA-256 is not {sha256[:16]}… of the manifest")
    return path


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
