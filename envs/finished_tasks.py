"""Finished pieces of a long evaluation, kept so that it can be resumed after an interruption."""

import dataclasses
import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

from crowdsim.recordings.store import write_atomic
from envs.episode_rows import Row, read_rows, rows_as_parquet
from predictor.checkpoint import source_revision


@dataclasses.dataclass(frozen=True)
class FinishedTasks:
    """A folder with the rows of every finished task, under a name that only this task has.

    The name depends on the task, on the revision of the program, and on the content of the files
    that the task names (policies, checkpoints, scenarios), so that nothing stale is ever taken.

    Attributes:
        folder: Where the files are.
    """

    folder: Path

    def rows_of(self, task: Any) -> list[Row] | None:
        """Returns the rows of a task, or None if it is not finished."""
        path = self._path(task)
        return read_rows(path) if path.exists() else None

    def keep(self, task: Any, rows: list[Row]) -> None:
        """Keeps the rows of a task, whole or not at all."""
        self.folder.mkdir(parents=True, exist_ok=True)
        write_atomic(self._path(task), rows_as_parquet(rows))

    def forget(self) -> None:
        """Removes all of them."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _path(self, task: Any) -> Path:
        fields = dataclasses.asdict(task)
        digest = hashlib.sha256(source_revision().encode())
        digest.update(json.dumps(fields, sort_keys=True, default=str).encode())
        for text in sorted(_texts(fields)):
            digest.update(_content(Path(text)))
        return self.folder / f"{digest.hexdigest()[:32]}.parquet"


def _texts(value: Any) -> set[str]:
    """All non-empty texts in nested dicts and sequences."""
    if isinstance(value, str):
        return {value} - {""}
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list | tuple):
        return set[str]().union(*(_texts(item) for item in value))
    return set()


def _content(path: Path) -> bytes:
    """What a file, or the files of a folder directly in it, hold; nothing if there is none."""
    if path.is_file():
        return path.read_bytes()
    if not path.is_dir():
        return b""
    return b"".join(each.read_bytes() for each in sorted(path.iterdir()) if each.is_file())
