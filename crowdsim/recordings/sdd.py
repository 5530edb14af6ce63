"""Stanford Drone Dataset: videos with their pictures, masks and scales, and the standard split.

Source: Robicquet et al., ECCV 2016. The folder layout is that of the data README; scales are
version A of its table. World metres are x = s u and y = -s v, as in `sdd_text`, so that a distance
in pixels is one in metres divided by the scale.
"""

import csv
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings.data_folder import find_sdd, read_mask, read_rgb
from crowdsim.recordings.drawn import drawn_picture
from crowdsim.recordings.recording import Picture, Recording
from crowdsim.recordings.sdd_text import iter_sdd_snippets, read_sdd_boxes, scale_of

SddPart = Literal["train", "test"]
WALKABLE_CLASSES: Final = (1, 2, 4)
"""Classes of the masks that people walk on: pavement, road, grass."""


def read_sdd(root: Path | str | None, video: str) -> Recording:
    """All pedestrians of a video at 2.5 Hz, whole tracks, with its picture. World metres.

    Args:
        root: As `find_sdd`.
        video: Such as `gates_2`; 23 videos have whole tracks, 21 of them a scale.

    Raises:
        FileNotFoundError: The data, or this video's part of it, is not there.
        ValueError: The video has no scale, or its file is damaged.
    """
    folder = find_sdd(root)
    scale = scale_of(sdd_scales(folder), video)
    path = folder / "full_tracks_2p5hz" / f"{video}.csv.gz"
    return replace(read_sdd_boxes(path, scale, name=video), picture=sdd_picture(folder, video))


def sdd_part(root: Path | str | None, part: str, *, drawn: bool = False) -> list[Recording]:
    """Recordings of the standard split, one per video, each with its picture. World metres.

    A person is a snippet of exactly 20 rows. Windows of 20 consecutive listed rows, stride 1,
    whose agents are present in all of them, hold every snippet once: 8494 in `train`, 2829 in
    `test`.

    Args:
        root: As `find_sdd`.
        part: `train` or `test`. There is no official validation part: cut `train` by video.
        drawn: Instead of the photographs, show the classes of the masks as simulated maps do.

    Raises:
        FileNotFoundError: The data is not there.
        ValueError: Unknown part, or a damaged file.
    """
    return list(_iter_part(root, part, drawn))


def _iter_part(root: Path | str | None, part: str, drawn: bool) -> Iterator[Recording]:
    if part not in get_args(SddPart):
        raise ValueError(f"part must be one of {', '.join(get_args(SddPart))}, got {part!r}")
    folder = find_sdd(root)
    path = folder / f"standard_{part}.csv.gz"
    for recording in iter_sdd_snippets(path, sdd_scales(folder)):
        picture = sdd_picture(folder, recording.name)
        if drawn:
            picture = drawn_picture(picture, sdd_mask(folder, recording.name))
        yield replace(recording, picture=picture)


def sdd_scales(root: Path | str | None) -> dict[str, float]:
    """Metres per pixel of the 54 videos that were measured.

    Raises:
        FileNotFoundError: The data is not there.
    """
    with (find_sdd(root) / "scales.csv").open(encoding="utf-8", newline="") as file:
        measured = ((row["video"], row["metres_per_px_A"]) for row in csv.DictReader(file))
        return {video: float(scale) for video, scale in measured if scale}


def sdd_picture(root: Path | str | None, video: str) -> Picture:
    """The reference image of a video with its scale.

    Raises:
        FileNotFoundError: The data, or this picture, is missing or damaged.
        ValueError: The video has no scale: 6 of the 60 were never measured.
    """
    folder = find_sdd(root)
    scale = scale_of(sdd_scales(folder), video)
    image = read_rgb(folder / "images" / f"{video}.jpg")
    return Picture(image, np.diag([1.0 / scale, -1.0 / scale, 1.0]))


def sdd_mask(root: Path | str | None, video: str) -> NDArray[np.uint8]:
    """(H, W) classes of the ground, pixel for pixel as `sdd_picture`.

    1 pavement, 2 road, 3 building, 4 grass, 5 tree or bush.

    Raises:
        FileNotFoundError: The data is missing or damaged; 13 of the 60 videos have no mask.
    """
    return read_mask(find_sdd(root) / "masks" / f"{video}.png")


def sdd_walkable(root: Path | str | None, video: str) -> NDArray[np.bool_]:
    """(H, W) mask of the ground that people can walk on, pixel for pixel as `sdd_picture`.

    Raises:
        FileNotFoundError: As `sdd_mask`.
    """
    return np.isin(sdd_mask(root, video), WALKABLE_CLASSES)
