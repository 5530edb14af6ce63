"""Where crowds to train on and to test on come from, by the name that a command is given."""

from pathlib import Path
from typing import Any

import numpy as np

from crowdsim.recordings import (
    ETH_UCY_FOLDS,
    Recording,
    eth_ucy_fold,
    read_recordings,
)
from crowdsim.recordings.store import read_manifest

VALIDATION_SHARE = 0.1
"""Share of the recordings of a folder that is kept for validation."""


def read_training(data: str) -> tuple[list[Recording], list[Recording]]:
    """Recordings to train on and to validate on; no recording is in both.

    Args:
        data: `eth_ucy:<fold>` or `<folder of the data>:<fold>` for the parts of that leave-one-out
            fold (cut in time by the standard files), or a folder written by `crowdnav generate`
            (every tenth recording, drawn once and for all, validates).

    Raises:
        FileNotFoundError: The data is not there.
        ValueError: Unknown fold, or a folder with fewer than two recordings.
    """
    root, fold = _split_fold(data)
    if fold is not None:
        return eth_ucy_fold(root, fold, "train"), eth_ucy_fold(root, fold, "val")
    recordings = read_recordings(Path(data))
    if len(recordings) < 2:
        raise ValueError(f"{data}: expected at least 2 recordings, found {len(recordings)}")
    count = max(1, round(VALIDATION_SHARE * len(recordings)))
    validation = set(np.random.default_rng(0).permutation(len(recordings))[:count].tolist())
    return (
        [r for i, r in enumerate(recordings) if i not in validation],
        [r for i, r in enumerate(recordings) if i in validation],
    )


def describe(data: str) -> dict[str, Any]:
    """How a folder of recordings was made, as its manifest says; empty for ETH/UCY."""
    if _split_fold(data)[1] is not None:
        return {}
    metadata: dict[str, Any] = read_manifest(Path(data))["metadata"]
    return metadata


def read_tests(data: str) -> dict[str, list[Recording]]:
    """Recordings to test on, by fold.

    Args:
        data: The ETH/UCY folder (its five folds), that folder with `:<fold>` (that fold only), or a
            folder written by `crowdnav generate` (one fold by its name).

    Raises:
        FileNotFoundError: The data is not there.
        ValueError: Unknown fold.
    """
    root, fold = _split_fold(data)
    if fold is not None:
        return {fold: eth_ucy_fold(root, fold, "test")}
    folder = Path(data)
    if data == "eth_ucy" or _is_eth_ucy(folder):
        root = folder if _is_eth_ucy(folder) else None
        return {name: eth_ucy_fold(root, name, "test") for name in ETH_UCY_FOLDS}
    return {folder.resolve().name: read_recordings(folder)}


def _is_eth_ucy(folder: Path) -> bool:
    return any((f / "splits" / "loo.json").is_file() for f in (folder, folder / "eth_ucy"))


def _split_fold(data: str) -> tuple[Path | None, str | None]:
    """`<folder>:<fold>` to both; no folder for plain `eth_ucy`, which is looked for."""
    folder, colon, fold = data.rpartition(":")
    if not colon:
        return None, None
    return (None if folder == "eth_ucy" else Path(folder)), fold
