"""The picture of the ground around an agent, as the agent looks at it."""

from collections.abc import Sequence
from typing import Final, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from predictor.config import NetworkConfig

FLAGS: Final = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP


def crop_maps(
    map_images: Sequence[NDArray[np.uint8] | None],
    pixel_from_world: Sequence[NDArray[np.float64] | None],
    worlds: NDArray[np.int64],
    world_from_agent: NDArray[np.float64],
    config: NetworkConfig,
) -> NDArray[np.uint8] | None:
    """Cut out of its world's picture what lies around each agent, turned into the agent frame.

    Args:
        map_images: W pictures (H, W, 3) uint8 RGB, or None.
        pixel_from_world: W homographies (3, 3), or None.
        worlds: (B,) world of each agent.
        world_from_agent: (B, 3, 3) transforms; they may mirror and scale (augmentation).
        config: Side of the crop in metres and in pixels.

    Returns:
        (B, S, S, 3) uint8; black beyond the picture and without one. None for variant `none`.
    """
    if config.variant == "none":
        return None
    crops = np.zeros((len(worlds), config.crop_px, config.crop_px, 3), dtype=np.uint8)
    there = has_picture(map_images, pixel_from_world)
    homographies = np.stack(
        [np.eye(3) if h is None else np.asarray(h, dtype=np.float64) for h in pixel_from_world]
    )
    pixel_from_crop = homographies[worlds] @ world_from_agent @ _agent_from_crop(config)
    affine = np.all(pixel_from_crop[:, 2, :2] == 0.0, axis=1)
    images = cast("Sequence[NDArray[np.uint8]]", map_images)  # of those that are there
    for row in np.flatnonzero(there[worlds]):
        _warp(images[worlds[row]], pixel_from_crop[row], crops[row], affine=affine[row])
    return crops


def has_picture(
    map_images: Sequence[NDArray[np.uint8] | None],
    pixel_from_world: Sequence[NDArray[np.float64] | None],
) -> NDArray[np.bool_]:
    """(W,) bool, which worlds have a picture and know where it lies."""
    pairs = zip(map_images, pixel_from_world, strict=True)
    return np.array([i is not None and h is not None for i, h in pairs], dtype=np.bool_)


def _agent_from_crop(config: NetworkConfig) -> NDArray[np.float64]:
    """Crop pixel (column, row) to metres in the agent frame; pixel (0, 0) is a pixel's centre."""
    metres = config.crop_side / config.crop_px
    left = 0.5 * metres - 0.25 * config.crop_side
    top = 0.5 * config.crop_side - 0.5 * metres
    return np.array([[metres, 0.0, left], [0.0, -metres, top], [0.0, 0.0, 1.0]])


def _warp(
    image: NDArray[np.uint8],
    pixel_from_crop: NDArray[np.float64],
    crop: NDArray[np.uint8],
    *,
    affine: bool,
) -> None:
    """Fill `crop` (S, S, 3) from the picture; the affine warp is faster where it suffices."""
    size = crop.shape[:2]
    if affine:
        pixel_from_crop = pixel_from_crop[:2] / pixel_from_crop[2, 2]
        cv2.warpAffine(image, pixel_from_crop, size, dst=crop, flags=FLAGS)
    else:
        cv2.warpPerspective(image, pixel_from_crop, size, dst=crop, flags=FLAGS)
