"""A range scanner that sees walls and outlines of obstacles and, if asked to, people."""

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from crowdsim.distance_field import distance_to_segment

FloatArray = NDArray[np.float64]

TOLERANCE = 1e-9


def cast_rays(
    segments: FloatArray,
    origins: ArrayLike,
    headings: ArrayLike,
    rays: int,
    max_range: float,
    *,
    discs: ArrayLike | None = None,
) -> FloatArray:
    """Measure the distance to the nearest target along evenly spread rays.

    Args:
        segments: `(S, 2, 2)` wall segments [m], as `Map.segments`.
        origins: `(W, 2)` scanner positions [m].
        headings: `(W,)` directions of ray 0 [rad]; the others follow counter-clockwise.
        rays: rays per full turn.
        max_range: value where nothing is hit [m].
        discs: `(N, 3)` people as further targets: x, y and radius [m]. The disc that a scanner
            stands in, its own body, is no target.

    Returns:
        `(W, rays)` ranges in `[0, max_range]` [m], exact up to rounding.

    Raises:
        ValueError: if `rays` or `max_range` is not positive, or a disc is malformed.
    """
    if rays < 1 or not max_range > 0:
        raise ValueError(f"expected rays >= 1 and max_range > 0, found {rays} and {max_range}")
    starts = np.ascontiguousarray(origins, dtype=np.float64)
    angles = np.ascontiguousarray(headings, dtype=np.float64)
    ranges = np.full((len(starts), rays), float(max_range))
    _cast(segments, starts, angles, ranges)
    if discs is not None:
        _cast_at_discs(_checked(discs), starts, angles, ranges)
    return ranges


def _checked(discs: ArrayLike) -> FloatArray:
    checked = np.ascontiguousarray(discs, dtype=np.float64)
    if checked.ndim != 2 or checked.shape[1] != 3:
        raise ValueError(f"discs: expected shape (N, 3), found {checked.shape}")
    if not (np.isfinite(checked).all() and (checked[:, 2] > 0).all()):
        raise ValueError("discs: expected finite centres and radii > 0 m")
    return checked


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


@njit(cache=True)
def _cast_at_discs(
    discs: FloatArray, origins: FloatArray, headings: FloatArray, ranges: FloatArray
) -> None:
    for scanner in range(origins.shape[0]):
        for disc in range(discs.shape[0]):
            x, y = discs[disc, 0] - origins[scanner, 0], discs[disc, 1] - origins[scanner, 1]
            if math.hypot(x, y) > discs[disc, 2]:
                _scan_disc(x, y, discs[disc, 2], headings[scanner], ranges[scanner])


@njit(cache=True)
def _scan_disc(x: float, y: float, radius: float, heading: float, ranges: FloatArray) -> None:
    """Shorten the ranges of those rays that meet a disc at (x, y) from the scanner."""
    squared = x * x + y * y
    spacing = 2 * math.pi / len(ranges)
    middle = math.atan2(y, x) - heading
    half = math.asin(radius / math.sqrt(squared))
    for ray in range(
        math.ceil((middle - half) / spacing), math.floor((middle + half) / spacing) + 1
    ):
        angle = heading + ray * spacing
        along = x * math.cos(angle) + y * math.sin(angle)
        chord = max(0.0, radius * radius - (squared - along * along))
        index = ray % len(ranges)
        ranges[index] = min(ranges[index], along - math.sqrt(chord))
