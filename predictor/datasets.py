"""Where crowds to train on and to test on come from, by the name that a command is given."""

from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from crowdsim.recordings import (
    ETH_UCY_FOLDS,
    Recording,
    eth_ucy_fold,
    read_recordings,
    sdd_part,
)
from crowdsim.recordings.store import read_manifest

Unit = Literal["m", "px"]

DRAWN: Final = "@drawn"
"""Ending of the name of real data: where people can walk is drawn in the palette of simulated maps
and takes the place of the photographs."""

VALIDATION_SHARE = 0.1
"""Share of the recordings of a folder that is kept for validation."""

SDD_VALIDATION: Final = ("bookstore_2", "gates_1", "hyang_6", "nexus_9")
"""Videos of the training part of SDD that validate: 1344 of its 8494 snippets. There is no official
choice; like the test part, they show places that other videos of the training part show too."""


def read_training(data: str) -> tuple[list[Recording], list[Recording]]:
    """Recordings to train on and to validate on; no recording is in both.

    Args:
        data: `eth_ucy:<fold>` or `<folder of the data>:<fold>` for the parts of that leave-one-out
            fold (cut in time by the standard files), `sdd` or the folder of that data (the
            videos `SDD_VALIDATION` validate), or a folder written by `crowdnav generate` (every
            tenth recording, drawn once and for all, validates). Real data may end in `@drawn`.

    Raises:
        FileNotFoundError: The data is not there.
        ValueError: Unknown fold, a folder with fewer than two recordings, or simulated maps
            that are to be drawn.
    """
    place, drawn = _split_drawn(data)
    root, fold = _split_fold(place)
    if fold is not None:
        train, validation = (
            eth_ucy_fold(root, fold, part, drawn=drawn) for part in ("train", "val")
        )
        return train, validation
    if _is_sdd(place):
        return _parted(sdd_part(_sdd_root(place), "train", drawn=drawn), set(SDD_VALIDATION))
    recordings = _read_simulated(place, drawn)
    if len(recordings) < 2:
        raise ValueError(f"{data}: expected at least 2 recordings, found {len(recordings)}")
    count = max(1, round(VALIDATION_SHARE * len(recordings)))
    chosen = np.random.default_rng(0).permutation(len(recordings))[:count]
    return _parted(recordings, {recordings[i].name for i in chosen})


def _parted(
    recordings: list[Recording], validation: set[str]
) -> tuple[list[Recording], list[Recording]]:
    """Those to train on, and those named in `validation`."""
    return (
        [recording for recording in recordings if recording.name not in validation],
        [recording for recording in recordings if recording.name in validation],
    )


def _read_simulated(place: str, drawn: bool) -> list[Recording]:
    if drawn:
        raise ValueError(f"{place}: expected real data before {DRAWN}, simulated maps are drawn")
    return read_recordings(Path(place))


def describe(data: str) -> dict[str, Any]:
    """How a folder of recordings was made, as its manifest says; empty for real data."""
    data, _ = _split_drawn(data)
    if _split_fold(data)[1] is not None or _is_sdd(data):
        return {}
    metadata: dict[str, Any] = read_manifest(Path(data))["metadata"]
    return metadata


def read_tests(data: str) -> dict[str, list[Recording]]:
    """Recordings to test on, by fold.

    Args:
        data: The ETH/UCY folder (its five folds), that folder with `:<fold>` (that fold only),
            `sdd` or the folder of that data (the standard test part), or a folder written by
            `crowdnav generate` (one fold by its name). Real data may end in `@drawn`.

    Raises:
        FileNotFoundError: The data is not there.
        ValueError: Unknown fold, or simulated maps that are to be drawn.
    """
    place, drawn = _split_drawn(data)
    root, fold = _split_fold(place)
    if fold is not None:
        return {fold: eth_ucy_fold(root, fold, "test", drawn=drawn)}
    names = fold_names(data)
    if names == ETH_UCY_FOLDS:
        root = Path(place) if _is_eth_ucy(Path(place)) else None
        return {name: eth_ucy_fold(root, name, "test", drawn=drawn) for name in names}
    if _is_sdd(place):
        return {names[0]: sdd_part(_sdd_root(place), "test", drawn=drawn)}
    return {names[0]: _read_simulated(place, drawn)}


def crowd_name(data: str) -> Literal["eth_ucy", "sdd", "simulated"]:
    """Which crowds a name stands for; nothing is read for it."""
    place, _ = _split_drawn(data)
    if _is_sdd(place):
        return "sdd"
    real = _split_fold(place)[1] is not None or fold_names(place) == ETH_UCY_FOLDS
    return "eth_ucy" if real else "simulated"


def drawn_name(data: str) -> str:
    """Name of the same crowds where their maps are drawn; those of simulated crowds always are."""
    place, _ = _split_drawn(data)
    return data if crowd_name(data) == "simulated" else place + DRAWN


def fold_names(data: str) -> tuple[str, ...]:
    """The folds that `read_tests` reads; nothing is read for it."""
    data, _ = _split_drawn(data)
    folder, fold = Path(data), _split_fold(data)[1]
    if fold is not None:
        return (fold,)
    if _is_sdd(data):
        return ("sdd",)
    if data == "eth_ucy" or _is_eth_ucy(folder):
        return ETH_UCY_FOLDS
    return (folder.resolve().name,)


def unit_of(data: str) -> Unit:
    """What the errors on some tests are told in: pixels of the picture for SDD, else metres."""
    return "px" if crowd_name(data) == "sdd" else "m"


def usual_min_ped(data: str) -> int:
    """What the literature asks of a window: ETH/UCY more than one agent, SDD nothing."""
    return 0 if crowd_name(data) == "sdd" else 1


def _is_eth_ucy(folder: Path) -> bool:
    return any((f / "splits" / "loo.json").is_file() for f in (folder, folder / "eth_ucy"))


def _is_sdd(data: str) -> bool:
    return data == "sdd" or (Path(data) / "standard_test.csv.gz").is_file()


def _sdd_root(data: str) -> Path | None:
    return None if data == "sdd" else Path(data)


def _split_drawn(data: str) -> tuple[str, bool]:
    """The name without its ending `@drawn`, and whether it had it."""
    return data.removesuffix(DRAWN), data.endswith(DRAWN)


def _split_fold(data: str) -> tuple[Path | None, str | None]:
    """`<folder>:<fold>` to both; no folder for plain `eth_ucy`, which is looked for."""
    folder, colon, fold = data.rpartition(":")
    if not colon:
        return None, None
    return (None if folder == "eth_ucy" else Path(folder)), fold
