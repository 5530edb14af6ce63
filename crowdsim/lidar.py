"""A range scanner that sees the static geometry: walls and outlines of obstacles, not people."""

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from crowdsim.distance_field import distance_to_segment

FloatArray = NDArray[np.float64]

TOLERANCE = 1e-9


def cast_rays(
    segments: FloatArray, origins: ArrayLike, headings: ArrayLike, rays: int, max_range: float
) -> FloatArray:
    """Measure the distance to the nearest segment along evenly spread rays.

    Args:
        segments: `(S, 2, 2)` wall segments [m], as `Map.segments`.
        origins: `(W, 2)` scanner positions [m].
        headings: `(W,)` directions of ray 0 [rad]; the others follow counter-clockwise.
        rays: rays per full turn.
        max_range: value where nothing is hit [m].

    Returns:
        `(W, rays)` ranges in `[0, max_range]` [m], exact up to rounding.

    Raises:
        ValueError: if `rays` or `max_range` is not positive.
    """
    if rays < 1 or not max_range > 0:
        raise ValueError(f"expected rays >= 1 and max_range > 0, found {rays} and {max_range}")
    starts = np.ascontiguousarray(origins, dtype=np.float64)
    angles = np.ascontiguousarray(headings, dtype=np.float64)
    ranges = np.full((len(starts), rays), float(max_range))
    _cast(segments, starts, angles, ranges)
    return ranges


@njit(cache=True)
def _cast(
    segments: FloatArray, origins: FloatArray, headings: FloatArray, ranges: FloatArray
) -> None:
    max_range = ranges.max() if ranges.size > 0 else 0.0
    for scanner in range(origins.shape[0]):
        x, y = origins[scanner, 0], origins[scanner, 1]
        for index in range(segments.shape[0]):
            if distance_to_segment(x, y, segments[index])[0] < max_range:
                _scan_segment(x, y, headings[scanner], segments[index], ranges[scanner])


@njit(cache=True)
def _scan_segment(
    x: float, y: float, heading: float, segment: FloatArray, ranges: FloatArray
) -> None:
    """Shorten the ranges of those rays that lie in the segment's angular span."""
    ax, ay = segment[0, 0] - x, segment[0, 1] - y
    bx, by = segment[1, 0] - x, segment[1, 1] - y
    spacing = 2 * math.pi / len(ranges)
    first = math.atan2(ay, ax) - heading
    span = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
    low = math.floor(min(first, first + span) / spacing)
    high = math.ceil(max(first, first + span) / spacing)
    for ray in range(low, high + 1):
        angle = heading + ray * spacing
        distance = _ray_range(math.cos(angle), math.sin(angle), ax, ay, bx - ax, by - ay)
        index = ray % len(ranges)
        ranges[index] = min(ranges[index], distance)


@njit(cache=True)
def _ray_range(ux: float, uy: float, ax: float, ay: float, sx: float, sy: float) -> float:
    """Solve t u = a + w s for t >= 0 and w in [0, 1]; inf if the ray misses the segment."""
    cross = ux * sy - uy * sx
    offset = ax * uy - ay * ux
    if abs(cross) <= TOLERANCE * math.hypot(sx, sy):  # the wall is seen edge-on
        near, far = ax * ux + ay * uy, (ax + sx) * ux + (ay + sy) * uy
        return max(0.0, min(near, far)) if abs(offset) <= TOLERANCE <= max(near, far) else np.inf
    t, w = (ax * sy - ay * sx) / cross, offset / cross
    # The tolerance keeps rays from slipping through where two walls meet.
    return t if t >= 0 and -TOLERANCE <= w <= 1 + TOLERANCE else np.inf
