"""Real places drawn as the simulator draws its own, so that one network can read both."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings.recording import Picture
from crowdsim.recordings.surfaces import Surface

LEAST_DRAWN: Final = 0.5
"""A picture of which a smaller share has the colors of surfaces is no drawn map."""


def drawn_picture(photograph: Picture, classes: NDArray[np.integer]) -> Picture:
    """Draw the ground of a photograph in the palette of simulated maps, pixel for pixel.

    Nothing is drawn that the photograph does not show: beyond it the world stays unknown.

    Args:
        photograph: Seen from where.
        classes: (H, W) values of `Surface`, pixel for pixel as the photograph.

    Raises:
        ValueError: Mask and photograph differ in size, or a value is no surface.
    """
    if classes.shape != photograph.image.shape[:2]:
        raise ValueError(
            f"classes must be {photograph.image.shape[:2]} like the picture, got {classes.shape}"
        )
    strange = sorted(set(np.unique(classes).tolist()) - set(Surface))
    if strange:
        raise ValueError(f"classes must be surfaces 1 to {max(Surface)}, got {strange}")
    return Picture(_COLORS[classes], photograph.pixel_from_world)


def walkable_classes(walkable: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """(H, W) pavement where people can walk, building elsewhere."""
    return np.where(walkable, np.uint8(Surface.PAVEMENT), np.uint8(Surface.BUILDING))


_COLORS = np.zeros((max(Surface) + 1, 3), dtype=np.uint8)
for _surface in Surface:
    _COLORS[_surface] = _surface.color_rgb


def walkable_in(picture: Picture) -> NDArray[np.bool_] | None:
    """(H, W), where people can walk on a drawn map; None for a photograph.

    Walls have a color of their own, so that nobody walks there.
    """
    walkable = _has_color(picture.image, [s.color_rgb for s in Surface if s.walkable])
    obstacle = _has_color(picture.image, [s.color_rgb for s in Surface if not s.walkable])
    return walkable if (walkable | obstacle).mean() >= LEAST_DRAWN else None


def _has_color(
    image: NDArray[np.uint8], colors: Sequence[tuple[int, int, int]]
) -> NDArray[np.bool_]:
    packed = image.astype(np.uint32) @ np.array([65536, 256, 1], dtype=np.uint32)
    return np.isin(packed, [65536 * r + 256 * g + b for r, g, b in colors])
