"""What commands leave on the disk: whole files under their final names, or nothing."""

import json
from pathlib import Path
from typing import Any


def require_folder(path: Path) -> None:
    """Fail before any work is done when results cannot go into `path`.

    Raises:
        NotADirectoryError: The path, or one that it lies in, is a file.
    """
    for place in (path, *path.parents):
        if place.is_dir():
            return
        if place.exists():
            raise NotADirectoryError(f"expected a folder for the results, found a file: {place}")


def require_file(path: Path | None) -> None:
    """Fail before any work is done when `path` cannot become a file; None asks for no file.

    Raises:
        IsADirectoryError: The path is a folder.
        NotADirectoryError: It lies in something that is a file.
    """
    if path is None:
        return
    if path.is_dir():
        raise IsADirectoryError(f"expected the name of a file, found a folder: {path}")
    require_folder(path.parent)


def write_text(path: Path, text: str) -> None:
    """Write a file whole or not at all, with the folders that it needs."""
    from crowdsim.recordings.store import write_atomic

    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, text.encode())


def write_json(path: Path | None, table: Any) -> None:
    """Write a table as JSON, whole or not at all; None asks for no file.

    Raises:
        ValueError: The table holds NaN or infinity, which JSON does not know.
    """
    if path is not None:
        write_text(path, json.dumps(table, indent=2, allow_nan=False) + "\n")
