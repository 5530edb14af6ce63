"""Maps from photographs: the picture stays, a mask beside it says what the ground is."""

from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from crowdsim.canvas import project
from crowdsim.map import Map
from crowdsim.maps.raster import trace_surfaces
from crowdsim.recordings import Picture, find_data, read_scene, sdd_mask, sdd_picture
from crowdsim.recordings.eth_ucy import scene_picture, scene_walkable
from crowdsim.recordings.surfaces import Surface

FloatArray = NDArray[np.float64]
Bounds = tuple[float, float, float, float]

SIMPLIFY_PX: Final = 1.5
"""Tolerance of the obstacles' outlines in a picture [pixels]."""
LEAST_AREA_PX: Final = 60.0
"""Smaller unwalkable spots of a mask are noise [square pixels]."""
SDD_SIMPLIFY_PX: Final = 4.0
SDD_LEAST_AREA_PX: Final = 300.0
"""The same for the hand-painted masks of drone pictures, about 0.15 m and 0.5 square metres."""
MARGIN: Final = 2.0
"""Bounds reach this far beyond the people seen in a scene [m]."""


def walkable_map(picture: Picture, walkable: NDArray[np.bool_], bounds: Bounds) -> Map:
    """Make a map of a picture with a homography and a mask of where people can walk.

    Args:
        picture: The photograph.
        walkable: (H, W), pixel for pixel as the picture; the rest is building.
        bounds: The part of the ground that is used, x_min, y_min, x_max, y_max [m]. Towards the
            horizon of a slanted view the whole picture would not end.

    Raises:
        ValueError: Mask and picture differ in size.
    """
    _check_size(picture, walkable)
    world_from_pixel = np.asarray(np.linalg.inv(picture.pixel_from_world), dtype=np.float64)
    # Outlines through the outermost pixels' centres, few corners: lidar and sight are fast.
    outlines, hierarchy = cv2.findContours(
        walkable.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE
    )
    surfaces = []
    for index, outline in enumerate(outlines):
        smooth = cv2.approxPolyDP(outline, SIMPLIFY_PX, True)
        if cv2.contourArea(outline) >= LEAST_AREA_PX and len(smooth) >= 3:
            polygon = project(world_from_pixel, smooth[:, 0].astype(np.float64))
            is_hole = hierarchy[0][index][3] >= 0
            surfaces.append((Surface.BUILDING if is_hole else Surface.PAVEMENT, polygon))
    return Map(
        bounds=bounds, surfaces=tuple(surfaces), background=Surface.BUILDING, picture=picture
    )


def classified_map(picture: Picture, classes: NDArray[np.integer]) -> Map:
    """Make a map of a picture with a homography and a mask of surfaces.

    Args:
        picture: A photograph that shows no horizon; all of it is used.
        classes: (H, W) values of `Surface`, pixel for pixel as the picture. Outside it people
            may walk.

    Raises:
        ValueError: Mask and picture differ in size, or a value is no surface.
    """
    _check_size(picture, classes)
    strange = sorted(set(np.unique(classes).tolist()) - set(Surface))
    if strange:
        raise ValueError(f"mask: expected classes 1 to {max(Surface)}, found {strange}")
    height, width = classes.shape
    world_from_pixel = np.asarray(np.linalg.inv(picture.pixel_from_world), dtype=np.float64)
    right, bottom = width - 0.5, height - 0.5
    corners = [(-0.5, -0.5), (right, -0.5), (right, bottom), (-0.5, bottom)]
    frame = project(world_from_pixel, corners)
    (x_min, y_min), (x_max, y_max) = frame.min(axis=0).tolist(), frame.max(axis=0).tolist()
    return Map(
        bounds=(x_min, y_min, x_max, y_max),
        surfaces=trace_surfaces(
            classes,
            world_from_pixel,
            Surface.PAVEMENT,
            least_area_px=SDD_LEAST_AREA_PX,
            simplify_px=SDD_SIMPLIFY_PX,
        ),
        picture=picture,
    )


def eth_ucy_map(root: Path | str | None, scene: str, *, bounds: Bounds | None = None) -> Map:
    """Read the map of an ETH/UCY scene: its empty view and its walkable mask.

    Args:
        root: As `crowdsim.recordings.find_data`.
        scene: One of `crowdsim.recordings.eth_ucy.ETH_UCY_SCENES` with a picture.
        bounds: The part that is used [m]; None takes where people are seen and 2 m around.

    Raises:
        FileNotFoundError: The data is not there.
        ValueError: Unknown scene, or one that no picture fits.
    """
    folder = find_data(root)
    if bounds is None:
        recording = read_scene(folder, scene)
        bounds = bounds_around(recording.positions[recording.valid])
    picture, walkable = scene_picture(folder, scene), scene_walkable(folder, scene)
    if picture is None or walkable is None:
        raise ValueError(f"{scene}: expected a scene with a picture, no picture fits this one")
    return walkable_map(picture, walkable, bounds)


def bounds_around(positions: FloatArray) -> Bounds:
    """What points (..., 2) cover, with a margin of 2 m."""
    x_min, y_min = (positions.min(axis=0) - MARGIN).tolist()
    x_max, y_max = (positions.max(axis=0) + MARGIN).tolist()
    return x_min, y_min, x_max, y_max


def sdd_map(folder: Path | str, video: str) -> Map:
    """Read the map of a Stanford Drone Dataset video: reference picture, mask and scale.

    World metres are x = scale u and y = -scale v: the drone looks straight down.

    Args:
        folder: Holds `images`, `masks` and `scales.csv`.
        video: Such as `bookstore_0`.

    Raises:
        FileNotFoundError: A file is missing; 13 of the 60 videos have no mask.
        ValueError: A file is damaged, the video has no scale (6 have none), or sizes
            differ.
    """
    return classified_map(sdd_picture(folder, video), sdd_mask(folder, video))


def _check_size(picture: Picture, mask: NDArray[np.generic]) -> None:
    if mask.shape != picture.image.shape[:2]:
        raise ValueError(
            f"mask: expected the picture's size {picture.image.shape[:2]}, found {mask.shape}"
        )
