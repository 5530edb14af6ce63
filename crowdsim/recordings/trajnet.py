"""TrajNet++ files: lines of JSON, each a scene or a position of somebody.

Source: Kothari et al., "Human Trajectory Forecasting in Crowds: A Deep Learning Perspective", 2021,
and the package `trajnetplusplustools`. A scene names a stretch of the tracks and the pedestrian in
it that is to be forecast. World metres.
"""

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from crowdsim.recordings.eth_ucy_text import ETH_UCY_COLUMNS
from crowdsim.recordings.rate import rated
from crowdsim.recordings.recording import Recording
from crowdsim.recordings.stretches import cut, join
from crowdsim.recordings.text_table import (
    BLOCK_ROWS,
    LONGEST_QUOTE,
    format_rows,
    open_text,
    plain_stem,
    write_lines,
)

SCENE_ROWS: Final = 21
"""Rows of a TrajNet++ scene: 9 observed and 12 to be forecast."""
LARGEST_WHOLE: Final = 2**53
TRACK: Final = '{"track": {"f": %d, "p": %d, "x": %.3f, "y": %.3f}}\n'


@dataclass(frozen=True, kw_only=True)
class TrajnetScene:
    """A stretch of a recording with the pedestrian whose path is to be forecast.

    Attributes:
        number: Of the scene; unique in its file.
        primary: Id of the pedestrian.
        start: First frame.
        end: Last frame, included.
        fps: Rows per second; None in old files.
        tag: Kind of path: 1 static, 2 linear, 3 interacting, 4 other; 0 not classified.
        subtags: Kinds of interaction: 1 leader and follower, 2 avoidance, 3 group, 4 other.
    """

    number: int
    primary: int
    start: int
    end: int
    fps: float | None = None
    tag: int = 0
    subtags: tuple[int, ...] = ()


class TrajnetFile(NamedTuple):
    """What a TrajNet++ file holds."""

    recording: Recording
    scenes: tuple[TrajnetScene, ...]


def read_trajnet(path: Path | str, *, dt: float | None = None) -> TrajnetFile:
    """Read tracks and scenes of a TrajNet++ file.

    Args:
        path: Lines of JSON, plain or gzipped; the recording takes the file's name.
        dt: Time of a frame step [s]; None takes the scenes' rows per second, or, of a file
            without them, asks for 0.4 s, which the frame numbers must explain.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: A line is neither track nor scene, or a prediction; scenes of different
            rates; or a time step that frames or speeds contradict.
    """
    path = Path(path)
    scenes = tuple(iter_trajnet_scenes(path))
    return TrajnetFile(join(iter_trajnet(path, dt=dt)), scenes)


def iter_trajnet(path: Path | str, *, dt: float | None = None) -> Iterator[Recording]:
    """Read the tracks of a TrajNet++ file, sorted by frame, in stretches; see `read_trajnet`."""
    path = Path(path)
    stated = _stated_dt(path) if dt is None else dt
    yield from rated(cut(str(path), _track_blocks(path)), plain_stem(path), dt=stated)


def iter_trajnet_scenes(path: Path | str) -> Iterator[TrajnetScene]:
    """Read the scenes of a TrajNet++ file; see `read_trajnet`."""
    # To look before parsing makes this three times as quick; most lines are tracks.
    for place, kind, fields in _lines(Path(path), holding='"scene"'):
        if kind == "scene":
            yield _read_scene(place, fields)


def _stated_dt(path: Path) -> float | None:
    """What the scenes say, if there are any that say it."""
    rates = {scene.fps for scene in iter_trajnet_scenes(path)} - {None}
    if len(rates) > 1:
        raise ValueError(f"{path}: expected scenes of one rate, found {sorted(map(str, rates))}")
    fps = rates.pop() if rates else None
    return None if fps is None else 1.0 / fps


def _track_blocks(path: Path) -> Iterator[np.ndarray[Any, np.dtype[np.void]]]:
    tracks = (_read_track(place, fields) for place, kind, fields in _lines(path) if kind == "track")
    while block := list(islice(tracks, BLOCK_ROWS)):
        yield np.array(block, dtype=ETH_UCY_COLUMNS)


def _lines(path: Path, holding: str = "") -> Iterator[tuple[str, str, Mapping[str, Any]]]:
    """File and line number, `scene` or `track`, and the fields, of lines that hold some text."""
    with open_text(path) as file:
        for number, line in enumerate(file, start=1):
            if holding in line and line.strip():
                place = f"{path}, line {number}"
                try:
                    ((kind, fields),) = json.loads(line).items()
                except (ValueError, AttributeError):
                    kind, fields = "", {}
                if kind not in ("scene", "track") or not isinstance(fields, dict):
                    raise ValueError(
                        f'{place}: expected {{"scene": …}} or {{"track": …}}, '
                        f"found {line.strip()[:LONGEST_QUOTE]!r}"
                    )
                yield place, kind, fields


def _read_track(place: str, fields: Mapping[str, Any]) -> tuple[int, int, float, float]:
    if "prediction_number" in fields:
        raise ValueError(f"{place}: expected positions that were observed, found a prediction")
    return (
        _whole(place, fields, "f"),
        _whole(place, fields, "p"),
        _number(place, fields, "x"),
        _number(place, fields, "y"),
    )


def _read_scene(place: str, fields: Mapping[str, Any]) -> TrajnetScene:
    tag = fields.get("tag")
    try:
        main, subtags = tag if isinstance(tag, list) else (0 if tag is None else tag, [])
        kinds = int(main), tuple(int(kind) for kind in subtags)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{place}: expected a tag such as 3 or [3, [1, 2]], got {tag}") from error
    return TrajnetScene(
        number=_whole(place, fields, "id"),
        primary=_whole(place, fields, "p"),
        start=_whole(place, fields, "s"),
        end=_whole(place, fields, "e"),
        fps=None if fields.get("fps") is None else _rate(place, fields),
        tag=kinds[0],
        subtags=kinds[1],
    )


def _rate(place: str, fields: Mapping[str, Any]) -> float:
    fps = _number(place, fields, "fps")
    if fps <= 0.0:
        raise ValueError(f"{place}: expected a positive rate 'fps', found {fps}")
    return fps


def _whole(place: str, fields: Mapping[str, Any], key: str) -> int:
    value = _number(place, fields, key)
    if value != int(value) or abs(value) > LARGEST_WHOLE:
        raise ValueError(f"{place}: expected a whole number {key!r}, found {value}")
    return int(value)


def _number(place: str, fields: Mapping[str, Any], key: str) -> float:
    value = fields.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{place}: expected a number {key!r}, found {value!r}")
    return value


def write_trajnet(
    path: Path | str,
    stretches: Iterable[Recording],
    scenes: Iterable[TrajnetScene] | None = None,
) -> None:
    """Write one recording as a TrajNet++ file, positions to a millimetre.

    Args:
        path: File to write; gzipped if it ends in `.gz`.
        stretches: The recording, whole or in stretches.
        scenes: What to forecast; None takes of every person all stretches of 21 rows, one after
            the other, not classified.
    """
    lines = _with_new_scenes(stretches) if scenes is None else _with_scenes(stretches, scenes)
    write_lines(Path(path), lines)


def _with_scenes(stretches: Iterable[Recording], scenes: Iterable[TrajnetScene]) -> Iterator[str]:
    for scene in scenes:
        yield _scene_line(scene)
    for part in stretches:
        yield format_rows(TRACK, *part.to_rows(by_frame=True))


def _with_new_scenes(stretches: Iterable[Recording]) -> Iterator[str]:
    cutter = SceneCutter()
    for part in stretches:
        yield from (_scene_line(scene) for scene in cutter.add(part))
        yield format_rows(TRACK, *part.to_rows(by_frame=True))


def _scene_line(scene: TrajnetScene) -> str:
    fields = {"id": scene.number, "p": scene.primary, "s": scene.start, "e": scene.end}
    kind = [scene.tag, list(scene.subtags)]
    return json.dumps({"scene": {**fields, "fps": scene.fps, "tag": kind}}) + "\n"


class SceneCutter:
    """Finds the scenes of a recording that comes in stretches: who is there for 21 rows on end."""

    def __init__(self) -> None:
        self._count = 0
        self._open: dict[int, tuple[int, int]] = {}
        self._last_frame: int | None = None
        self._step: int | None = None

    def add(self, part: Recording) -> Iterator[TrajnetScene]:
        """Take the next stretch; gives the scenes that end in it."""
        self._step = part.frame_step if self._step is None else self._step
        for frame, valid in zip(part.frames.tolist(), part.valid, strict=True):
            follows = self._last_frame is not None and frame - self._last_frame == self._step
            before = self._open if follows else {}
            self._open = {}
            for person in part.ids[valid].tolist():
                start, rows = before.get(person, (frame, 0))
                if rows + 1 < SCENE_ROWS:
                    self._open[person] = (start, rows + 1)
                    continue
                yield TrajnetScene(
                    number=self._count, primary=person, start=start, end=frame, fps=1.0 / part.dt
                )
                self._count += 1
            self._last_frame = frame
