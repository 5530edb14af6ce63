"""Maps from the file pair of ROS's map_server: a YAML description and a picture of cells.

https://wiki.ros.org/map_server and the same in Nav2, mode `trinary`.
"""

import math
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from crowdsim.canvas import project
from crowdsim.map import Map
from crowdsim.maps.raster import read_image, trace_surfaces
from crowdsim.recordings.surfaces import Surface

FloatArray = NDArray[np.float64]

OCCUPIED_THRESH: Final = 0.65
FREE_THRESH: Final = 0.25
"""Nav2's thresholds, for a description without any."""


def read_map_server(
    path: Path | str, *, unknown_is_free: bool = False, simplify_px: float = 0.0
) -> Map:
    """Read the map that a ROS robot uses: free cells are pavement, all others building.

    A cell's darkness is p = (255 - value) / 255, or value / 255 with `negate`; pictures with
    colors are averaged. Above `occupied_thresh` it is occupied, below `free_thresh` free, between
    them unknown. Outside the picture nobody can walk.

    Args:
        path: The YAML file; its `image` is looked for beside it.
        unknown_is_free: Whether people may walk on unknown cells. By default they stop there,
            as at a wall.
        simplify_px: How far outlines may move to need fewer corners [cells]; 1 turns the stairs
            of a mapped slanted wall into a line. 0 keeps each cell's shape.

    Raises:
        FileNotFoundError: The description or its picture is missing.
        ValueError: A field is missing or out of range, the mode is not trinary, or the picture
            is damaged.
    """
    path = Path(path)
    try:
        fields = yaml.safe_load(path.read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        raise ValueError(f"{path}: expected YAML, found {error}") from error
    if not isinstance(fields, dict) or not isinstance(fields.get("image"), str):
        raise ValueError(f"{path}: expected fields of a map, 'image' among them")
    if fields.get("mode", "trinary") != "trinary":
        raise ValueError(f"{path}: mode: expected 'trinary', found {fields['mode']!r}")
    free, unknown = _cells(path, fields)
    walkable = free | (unknown & unknown_is_free)
    classes = np.where(walkable, Surface.PAVEMENT, Surface.BUILDING)
    world_from_pixel = _world_from_pixel(path, fields, len(classes))
    return Map(
        bounds=_bounds(world_from_pixel, classes.shape),
        surfaces=trace_surfaces(
            classes, world_from_pixel, Surface.BUILDING, simplify_px=simplify_px
        ),
        background=Surface.BUILDING,
    )


def _cells(path: Path, fields: dict[str, Any]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which cells (H, W) are free, and which unknown."""
    occupied_above = _number(path, fields, "occupied_thresh", OCCUPIED_THRESH)
    free_below = _number(path, fields, "free_thresh", FREE_THRESH)
    if not 0.0 <= free_below <= occupied_above <= 1.0:
        raise ValueError(
            f"{path}: expected 0 <= free_thresh <= occupied_thresh <= 1, "
            f"found {free_below} and {occupied_above}"
        )
    image = read_image(path.parent / fields["image"], cv2.IMREAD_UNCHANGED)
    value = image if image.ndim == 2 else image[..., :3].mean(axis=-1)
    share = value / 255.0
    darkness = share if _number(path, fields, "negate", 0.0) else 1.0 - share
    free = darkness < free_below
    return free, ~free & (darkness <= occupied_above)


def _world_from_pixel(path: Path, fields: dict[str, Any], rows: int) -> FloatArray:
    """(3, 3) from whole pixels (u right, v down) to metres.

    `origin` is the pose (x, y, yaw) of the outer corner of the lower left pixel.
    """
    resolution = _number(path, fields, "resolution", None)
    if not resolution > 0.0:
        raise ValueError(f"{path}: resolution: expected > 0 m, found {resolution}")
    origin = fields.get("origin")
    try:
        x, y, yaw = (float(value) for value in origin)  # type: ignore[union-attr]
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path}: origin: expected [x, y, yaw], found {origin}") from error
    if not np.isfinite([x, y, yaw]).all():
        raise ValueError(f"{path}: origin: expected finite numbers, found {origin}")
    cosine, sine = math.cos(yaw), math.sin(yaw)
    world_from_grid = np.array([[cosine, -sine, x], [sine, cosine, y], [0.0, 0.0, 1.0]])
    grid_from_pixel = np.array(
        [
            [resolution, 0.0, 0.5 * resolution],
            [0.0, -resolution, (rows - 0.5) * resolution],
            [0.0, 0.0, 1.0],
        ]
    )
    return np.asarray(world_from_grid @ grid_from_pixel)


def _number(path: Path, fields: dict[str, Any], key: str, default: float | None) -> float:
    value = fields.get(key, default)
    if not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{path}: {key}: expected a finite number, found {value!r}")
    return float(value)


def _bounds(
    world_from_pixel: FloatArray, shape: tuple[int, ...]
) -> tuple[float, float, float, float]:
    """The box around the corners of the picture [m]."""
    bottom, right = shape[0] - 0.5, shape[1] - 0.5
    corners = np.array([(-0.5, -0.5), (right, -0.5), (right, bottom), (-0.5, bottom)])
    corners = project(world_from_pixel, corners)
    (x_min, y_min), (x_max, y_max) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return x_min, y_min, x_max, y_max
