"""A data set that is being made: its plan, and the shards that stand already.

From the first moment the folder holds `plan.json`, and beside every whole shard its entry, both
gone when the manifest stands. So whatever moment the making is killed at, it can go on.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from crowdsim.recordings.store import (
    MANIFEST,
    UNFINISHED,
    is_intact,
    read_manifest,
    require_no_dataset,
    write_atomic,
    write_manifest,
)

PLAN: Final = "plan.json"
ENTRIES: Final = "tracks-*.json"

Entry = dict[str, Any]
"""What the manifest says of a shard."""


def claim(folder: Path, plan: Mapping[str, Any], *, resume: bool) -> None:
    """Write the plan into a folder, or check that what stands there was begun with it.

    Args:
        folder: Of the data set; made if needed.
        plan: What is to be made, JSON-able.
        resume: Whether something may stand there already.

    Raises:
        FileExistsError: There is a data set, begun or complete, and `resume` is false.
        ValueError: It was begun with another plan; the message says what differs.
    """
    if not resume:
        require_no_dataset(folder)
        _require_nothing_begun(folder)
    begun = _plan_of(folder)
    asked = json.loads(json.dumps(plan, allow_nan=False))
    if begun is None:
        folder.mkdir(parents=True, exist_ok=True)
        write_atomic(folder / PLAN, (json.dumps(asked, indent=1) + "\n").encode())
    elif begun != asked:
        raise ValueError(f"{folder}: expected the plan it was begun with; {_differs(begun, asked)}")
    for leftover in folder.glob(f".*{UNFINISHED}"):
        leftover.unlink()


def _require_nothing_begun(folder: Path) -> None:
    if (folder / PLAN).exists():
        raise FileExistsError(
            f"{folder}: expected a folder without a data set, found an unfinished one; go on with "
            "--resume (resume=True), choose another folder or remove this one"
        )


def _plan_of(folder: Path) -> dict[str, Any] | None:
    """The plan that the data set in a folder was begun with; None where there is none."""
    if (folder / MANIFEST).exists():
        plan: dict[str, Any] = read_manifest(folder)["metadata"].get("plan", {})
        return plan
    path = folder / PLAN
    if not path.exists():
        return None
    try:
        plan = dict(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, TypeError) as error:
        raise ValueError(f"{path}: expected the plan of a data set, found {error!r}") from error
    return plan


def _differs(begun: Mapping[str, Any], asked: Mapping[str, Any]) -> str:
    """What two plans disagree about, in words."""
    keys = [key for key in {**begun, **asked} if begun.get(key) != asked.get(key)]
    return "; ".join(
        f"{key} was {json.dumps(begun.get(key))}, asked for is {json.dumps(asked.get(key))}"
        for key in keys
    )


def standing(folder: Path) -> dict[str, Entry]:
    """Entries of the shards that stand in a folder undamaged, by the name of their file."""
    if (folder / MANIFEST).exists():
        entries = read_manifest(folder)["shards"]
    else:
        entries = [_read_entry(path) for path in sorted(folder.glob(ENTRIES))]
    return {entry["file"]: entry for entry in entries if entry and is_intact(folder, entry)}


def _read_entry(path: Path) -> Entry:
    """An entry, or an empty one if it cannot be read: its shard is then made again."""
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, TypeError):
        return {}


def write_entry(folder: Path, entry: Entry) -> None:
    """Say that a shard stands; to be called after its files are written."""
    path = (folder / entry["file"]).with_suffix(".json")
    write_atomic(path, json.dumps(entry, allow_nan=False).encode())


def finish(folder: Path, entries: Sequence[Entry], metadata: Mapping[str, Any]) -> None:
    """Turn the folder into a data set, and take away what only the making needed."""
    write_manifest(folder, entries, metadata)
    for path in (*folder.glob(ENTRIES), folder / PLAN):
        path.unlink(missing_ok=True)
