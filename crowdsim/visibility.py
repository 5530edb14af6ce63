"""Who can be seen from where: range, field of view, and walls or bodies in between."""

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

TOLERANCE = 1e-9
"""Sight that grazes the end of a wall is blocked, so that nobody looks through a corner."""


def visible(
    occluders: FloatArray,
    observers: ArrayLike,
    headings: ArrayLike,
    points: ArrayLike,
    *,
    max_range: float,
    field_of_view: float = 2.0 * math.pi,
    radius: ArrayLike | None = None,
) -> BoolArray:
    """Tell which points each observer sees: those whose straight line of sight is free.

    Args:
        occluders: `(S, 2, 2)` segments that block sight [m], as `Map.occluders`.
        observers: `(W, 2)` where they look from [m].
        headings: `(W,)` where they look to [rad].
        points: `(N, 2)` what they look at, the middles of people for example [m].
        max_range: how far they see, this distance included [m].
        field_of_view: full angle around the heading, its edges included [rad].
        radius: `(N,)` of bodies around the points that hide one another [m]; None for points
            that hide nothing. A body hides neither itself nor anything from somebody inside it.

    Returns:
        `(W, N)` True where seen. A point at the observer's own place is seen.

    Raises:
        ValueError: if range or field of view is out of range, or shapes do not agree.
    """
    if not max_range > 0 or not 0 < field_of_view <= 2.0 * math.pi:
        raise ValueError(
            "expected max_range > 0 m and field_of_view in (0, 2 pi] rad, "
            f"found {max_range} and {field_of_view}"
        )
    eyes = np.ascontiguousarray(observers, dtype=np.float64)
    angles = np.ascontiguousarray(headings, dtype=np.float64)
    targets = np.ascontiguousarray(points, dtype=np.float64)
    bodies = np.zeros(len(targets)) if radius is None else np.asarray(radius, dtype=np.float64)
    shapes = (eyes.shape[1:], angles.shape, targets.shape[1:], bodies.shape)
    if shapes != ((2,), (len(eyes),), (2,), (len(targets),)):
        raise ValueError(
            "expected observers (W, 2), headings (W,), points (N, 2) and radius (N,), found "
            f"{eyes.shape}, {angles.shape}, {targets.shape} and {bodies.shape}"
        )
    seen = np.zeros((len(eyes), len(targets)), dtype=np.bool_)
    _look(occluders, eyes, angles, targets, bodies, max_range, 0.5 * field_of_view, seen)
    return seen


@njit(cache=True)
def _look(
    occluders: FloatArray,
    observers: FloatArray,
    headings: FloatArray,
    points: FloatArray,
    radius: FloatArray,
    max_range: float,
    half_view: float,
    seen: BoolArray,
) -> None:
    for observer in range(observers.shape[0]):
        eye = observers[observer]
        for target in range(points.shape[0]):
            seen[observer, target] = (
                _in_view(eye, headings[observer], points[target], max_range, half_view)
                and not _behind_wall(eye, points[target], occluders)
                and not _behind_body(eye, target, points, radius)
            )


@njit(cache=True)
def _in_view(
    eye: FloatArray, heading: float, point: FloatArray, max_range: float, half_view: float
) -> bool:
    dx, dy = point[0] - eye[0], point[1] - eye[1]
    if dx * dx + dy * dy > max_range * max_range:
        return False
    ahead = dx * math.cos(heading) + dy * math.sin(heading)
    left = dy * math.cos(heading) - dx * math.sin(heading)
    return abs(math.atan2(left, ahead)) <= half_view + TOLERANCE


@njit(cache=True)
def _behind_wall(eye: FloatArray, point: FloatArray, occluders: FloatArray) -> bool:
    """Whether a segment a + w s crosses the sight eye + t d, for t in (0, 1) and w in [0, 1]."""
    dx, dy = point[0] - eye[0], point[1] - eye[1]
    for index in range(occluders.shape[0]):
        ax, ay = occluders[index, 0, 0] - eye[0], occluders[index, 0, 1] - eye[1]
        bx, by = occluders[index, 1, 0] - eye[0], occluders[index, 1, 1] - eye[1]
        side_a, side_b = ax * dy - ay * dx, bx * dy - by * dx
        cross = side_a - side_b  # d x s
        margin = TOLERANCE * abs(cross)
        if (side_a > margin and side_b > margin) or (side_a < -margin and side_b < -margin):
            continue  # both ends on one side: most walls
        t = (ax * by - ay * bx) / cross if cross != 0.0 else 0.0
        # A wall seen edge-on hides nothing; its neighbors at the corner do.
        if 0.0 < t < 1.0:
            return True
    return False


@njit(cache=True)
def _behind_body(eye: FloatArray, target: int, points: FloatArray, radius: FloatArray) -> bool:
    """Whether another body reaches over the line to the middle of the target."""
    dx, dy = points[target, 0] - eye[0], points[target, 1] - eye[1]
    squared = dx * dx + dy * dy
    for body in range(points.shape[0]):
        x, y = points[body, 0] - eye[0], points[body, 1] - eye[1]
        reach = radius[body]
        if body == target or reach <= 0.0 or x * x + y * y <= reach * reach:
            continue
        along = x * dx + y * dy
        off = x * dy - y * dx
        if 0.0 < along < squared and off * off < reach * reach * squared:
            return True
    return False
