"""The ETH and UCY crowds: scenes with their pictures and masks, and the leave-one-out folds.

Sources: Pellegrini et al., ICCV 2009 (ETH); Lerner et al., 2007 (UCY). The folder layout is that of
the data README: `splits/` with the standard leave-one-out files, `scenes/` with pictures.
"""

import json
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings.data_folder import find_data, read_mask, read_rgb
from crowdsim.recordings.drawn import drawn_picture, walkable_classes
from crowdsim.recordings.eth_ucy_text import read_eth_ucy
from crowdsim.recordings.recording import Picture, Recording

Part = Literal["train", "val", "test"]
ETH_UCY_FOLDS: Final = ("eth", "hotel", "univ", "zara1", "zara2")
ETH_UCY_SCENES: Final = (
    "biwi_eth",
    "biwi_hotel",
    "crowds_zara01",
    "crowds_zara02",
    "crowds_zara03",
    "students001",
    "students003",
    "uni_examples",
)
PICTURE_FOLDERS: Final = {"crowds_zara03": "crowds_zara02", "students001": "students003"}
"""Scenes without a picture of their own, and the scene that shows the same view."""
GROUND_SCENES: Final = ("crowds_zara02", "crowds_zara03")
"""Scenes annotated at the head: `H_ground.txt` moves their tracks to the feet."""
NO_PICTURE: Final = ("uni_examples",)


def read_scene(root: Path | str | None, scene: str) -> Recording:
    """One of `ETH_UCY_SCENES` in full, with its picture.

    Args:
        root: As `find_data`.
        scene: Name of the scene.

    Raises:
        FileNotFoundError: The data is not there.
        ValueError: Unknown scene.
    """
    if scene not in ETH_UCY_SCENES:
        raise ValueError(f"scene must be one of {', '.join(ETH_UCY_SCENES)}, got {scene!r}")
    folder = find_data(root)
    path = folder / "splits" / "all" / f"{scene}.txt"
    return read_eth_ucy(path, picture=scene_picture(folder, scene))


def eth_ucy_fold(
    root: Path | str | None, fold: str, part: str, *, drawn: bool = False
) -> list[Recording]:
    """Recordings of one part of a leave-one-out fold, each with the picture that fits it.

    Args:
        root: As `find_data`.
        fold: One of `ETH_UCY_FOLDS`: the scene that is left out for the test.
        part: `train`, `val` or `test`.
        drawn: Instead of the photograph, show where people can walk (`drawn_scene_picture`).

    Raises:
        FileNotFoundError: The data is not there.
        ValueError: Unknown fold or part.
    """
    if fold not in ETH_UCY_FOLDS or part not in get_args(Part):
        raise ValueError(
            f"fold must be one of {', '.join(ETH_UCY_FOLDS)} and part one of "
            f"{', '.join(get_args(Part))}, got {fold!r} and {part!r}"
        )
    folder = find_data(root)
    files = json.loads((folder / "splits" / "loo.json").read_text(encoding="utf-8"))[fold][part]
    return list(_read_parts(folder, files, drawn_scene_picture if drawn else scene_picture))


def _read_parts(
    folder: Path, files: Iterable[str], picture: Callable[[Path, str], Picture | None]
) -> Iterable[Recording]:
    for file in files:
        path = folder / "splits" / file
        scene = path.stem.removesuffix("_train").removesuffix("_val")
        yield replace(read_eth_ucy(path), picture=picture(folder, scene))


@lru_cache(maxsize=32)
def scene_picture(folder: Path, scene: str) -> Picture | None:
    """Empty view of a scene with the homography that puts its tracks on the ground.

    Args:
        folder: `find_data`'s answer.
        scene: One of `ETH_UCY_SCENES`.

    Returns:
        None for a scene that no picture fits.

    Raises:
        FileNotFoundError: Picture or homography is missing or damaged.
    """
    if scene in NO_PICTURE:
        return None
    scenes = folder / "scenes"
    matrix = "H_ground.txt" if scene in GROUND_SCENES else "H.txt"
    world_from_pixel = np.loadtxt(scenes / scene / matrix)
    image = read_rgb(scenes / PICTURE_FOLDERS.get(scene, scene) / "background.png")
    return Picture(image, _inverse(world_from_pixel))


@lru_cache(maxsize=32)
def drawn_scene_picture(folder: Path, scene: str) -> Picture | None:
    """As `scene_picture`, with pavement drawn where people can walk and buildings elsewhere."""
    photograph, walkable = scene_picture(folder, scene), scene_walkable(folder, scene)
    if photograph is None or walkable is None:
        return None
    return drawn_picture(photograph, walkable_classes(walkable))


def scene_walkable(root: Path | str | None, scene: str) -> NDArray[np.bool_] | None:
    """(H, W) mask of the ground that people can walk on, pixel for pixel as `scene_picture`.

    Returns:
        None for a scene that no picture fits.

    Raises:
        FileNotFoundError: The mask is missing or damaged.
    """
    if scene in NO_PICTURE:
        return None
    folder = find_data(root) / "scenes" / PICTURE_FOLDERS.get(scene, scene)
    return read_mask(folder / "walkable.png") > 0


def _inverse(world_from_pixel: NDArray[np.float64]) -> NDArray[np.float64]:
    inverse = np.linalg.inv(world_from_pixel)
    return np.asarray(inverse / inverse[2, 2], dtype=np.float64)
