"""Polygons from pictures whose pixels are classes: the outlines of regions of one class."""

from pathlib import Path

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from skimage.measure import label
from skimage.segmentation import expand_labels

from crowdsim.canvas import project
from crowdsim.recordings.surfaces import Surface

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def trace(
    classes: NDArray[np.integer], *, least_area_px: float = 0.0, simplify_px: float = 0.0
) -> list[tuple[int, FloatArray]]:
    """Give the outlines of all regions of one class, in painter's order.

    Regions hold together over the sides of pixels, not over their corners. Neighbors share their
    border exactly, after it was made simpler too.

    Args:
        classes: (H, W) class of each pixel, whole numbers >= 0.
        least_area_px: Smaller regions are given to their surroundings [square pixels].
        simplify_px: Borders move by about this much to need fewer corners; 0 keeps each pixel's
            shape.

    Returns:
        (class, outline (P, 2) in pixels) of each region, holes ignored: what lies in a hole comes
        later. Whole coordinates (u right, v down) are pixel centres, so outlines run at halves.
    """
    kept = _without_specks(classes.astype(np.int64), least_area_px)
    chains = shapely.line_merge(shapely.multilinestrings(_edges(kept)))
    straight = shapely.get_parts(shapely.simplify(chains, 0.0))
    regions = shapely.get_parts(shapely.polygonize(straight))
    inside = shapely.get_coordinates(shapely.point_on_surface(regions))
    u, v = np.rint(inside).astype(int).T  # a rounded point stays in its region
    if simplify_px > 0.0:
        regions = shapely.coverage_simplify(regions, simplify_px, simplify_boundary=False)
    filled = shapely.polygons(shapely.get_exterior_ring(regions))
    return [
        (int(kept[v[index], u[index]]), shapely.get_coordinates(filled[index])[:-1])
        for index in np.argsort(-shapely.area(filled), kind="stable")
    ]


def trace_surfaces(
    classes: NDArray[np.integer],
    world_from_pixel: FloatArray,
    background: Surface,
    *,
    least_area_px: float = 0.0,
    simplify_px: float = 0.0,
) -> tuple[tuple[Surface, FloatArray], ...]:
    """Give `Map.surfaces` for a picture whose pixels are surfaces; other arguments as `trace`.

    Args:
        classes: (H, W) values of `Surface`.
        world_from_pixel: (3, 3) homography to metres.
        background: Regions of this surface at the border of the picture are left to it.
        least_area_px: As `trace`.
        simplify_px: As `trace`.
    """
    height, width = classes.shape
    last = np.array([width - 0.5, height - 0.5])
    surfaces = []
    for code, outline in trace(classes, least_area_px=least_area_px, simplify_px=simplify_px):
        at_border = bool((outline <= -0.5).any() or (outline >= last).any())
        if code != background or not at_border:
            surfaces.append((Surface(code), project(world_from_pixel, outline)))
    return tuple(surfaces)


def read_image(path: Path, flags: int) -> NDArray[np.uint8]:
    """Read a picture as OpenCV does, in BGR order where it has colors.

    Args:
        path: The file.
        flags: `cv2.IMREAD_...`.

    Raises:
        FileNotFoundError: No such file.
        ValueError: OpenCV cannot read it, or it has more than 8 bits.
    """
    if not path.is_file():
        raise FileNotFoundError(f"expected a picture at {path}")
    image = cv2.imread(str(path), flags)
    if image is None or image.dtype != np.uint8:
        found = f"{path.stat().st_size} bytes that are none" if image is None else image.dtype
        raise ValueError(f"{path}: expected a whole picture of 8 bits, found {found}")
    return np.asarray(image, dtype=np.uint8)


def _without_specks(classes: IntArray, least_area_px: float) -> IntArray:
    """Regions smaller than the least area take the class of the nearest pixel that is kept."""
    regions = np.asarray(label(classes + 1, background=0, connectivity=1))  # type: ignore[no-untyped-call]
    large = np.bincount(regions.ravel()) >= least_area_px
    large[0] = False  # no pixel is background
    if not large.any():
        return classes
    values = np.where(large[regions], classes + 1, 0)
    return np.asarray(expand_labels(values, distance=sum(classes.shape)) - 1)  # type: ignore[no-untyped-call]


def _edges(classes: IntArray) -> NDArray[np.object_]:
    """Unit lines between pixels of different classes, and around the picture."""
    framed = np.pad(classes, 1, constant_values=-1)
    v, u = np.nonzero(framed[1:] != framed[:-1])  # the pixels above and below differ
    level = np.stack([u - 1.5, v - 0.5, u - 0.5, v - 0.5], axis=-1)
    v, u = np.nonzero(framed[:, 1:] != framed[:, :-1])
    upright = np.stack([u - 0.5, v - 1.5, u - 0.5, v - 0.5], axis=-1)
    ends = np.concatenate([level, upright]).reshape(-1, 2, 2)
    return np.asarray(shapely.linestrings(ends))
