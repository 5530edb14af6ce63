"""Finished pieces of a long evaluation, kept so that it can be resumed after an interruption."""

import dataclasses
import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

from crowdsim.recordings.store import write_atomic
from envs.evaluation.episode_rows import Measured, read_rows, rows_as_parquet
from envs.evaluation.forecast_cells import CELL_COLUMNS
from predictor.checkpoint import source_revision


@dataclasses.dataclass(frozen=True)
class FinishedTasks:
    """A folder with what every finished task has measured, under a name that only it has.

    The name depends on the task, on the revision of the program, and on the content of the files
    that the task names (policies, checkpoints, scenarios), so that nothing stale is ever taken.

    Attributes:
        folder: Where the files are.
    """

    folder: Path

    def measured(self, task: Any) -> Measured | None:
        """Returns what a task has measured, or None if it is not finished."""
        path, cells = self._paths(task)
        if not path.exists():
            return None
        return Measured(rows=read_rows(path), cells=read_rows(cells))

    def keep(self, task: Any, measured: Measured) -> None:
        """Keeps what a task has measured, whole or not at all."""
        self.folder.mkdir(parents=True, exist_ok=True)
        path, cells = self._paths(task)
        # The rows come last: a task is finished when they are there.
        write_atomic(cells, rows_as_parquet(measured.cells, CELL_COLUMNS))
        write_atomic(path, rows_as_parquet(measured.rows, list(measured.rows[0])))

    def forget(self) -> None:
        """Removes all of them."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _paths(self, task: Any) -> tuple[Path, Path]:
        """Files of the task's rows and of its cells."""
        fields = dataclasses.asdict(task)
        digest = hashlib.sha256(source_revision().encode())
        digest.update(json.dumps(fields, sort_keys=True, default=str).encode())
        for text in sorted(_texts(fields)):
            digest.update(_content(Path(text)))
        name = digest.hexdigest()[:32]
        return self.folder / f"{name}.parquet", self.folder / f"{name}.cells.parquet"


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
