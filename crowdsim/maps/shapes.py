"""Outlines of things that stand in places: each gives polygons in metres, counter-clockwise."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crowdsim.recordings.surfaces import Surface

FloatArray = NDArray[np.float64]
Part = tuple[Surface, FloatArray]


def box(x_min: float, y_min: float, x_max: float, y_max: float) -> FloatArray:
    """Axis-aligned rectangle (4, 2)."""
    corners = [(x_min, y_min), (x_max, y_min), (x_max, y_max), (x_min, y_max)]
    return np.array(corners, dtype=np.float64)


def disc(x: float, y: float, radius: float, corners: int = 12) -> FloatArray:
    """Regular polygon (corners, 2) in a circle."""
    angle = 2.0 * math.pi * (np.arange(corners) + 0.5) / corners
    return np.array([x, y]) + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def slab(x: float, y: float, angle: float, length: float, width: float) -> FloatArray:
    """Rectangle (4, 2) around (x, y), its length along an angle [rad]."""
    along = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([-along[1], along[0]])
    signs = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    offsets = signs[:, :1] * length * along + signs[:, 1:] * width * across
    return np.asarray(np.array([x, y]) + offsets)


def lane(start: ArrayLike, end: ArrayLike, width: float) -> FloatArray:
    """Rectangle (4, 2) between two points, as wide as a street."""
    ahead = np.subtract(end, start)
    middle = 0.5 * np.add(start, end)
    angle = math.atan2(ahead[1], ahead[0])
    return slab(middle[0], middle[1], angle, float(np.hypot(*ahead)), width)


def fountain(x: float, y: float, radius: float, corners: int = 12) -> list[Part]:
    """A basin of water with a rim and a stone in the middle."""
    return [
        (Surface.BUILDING, disc(x, y, radius, corners)),
        (Surface.WATER, disc(x, y, radius - 0.4, corners)),
        (Surface.BUILDING, disc(x, y, 0.2 * radius, 8)),
    ]


def tree(x: float, y: float, radius: float) -> list[Part]:
    """A tree whose lowest branches nobody walks under."""
    return [(Surface.TREE, disc(x, y, radius, 9))]


def planter(x: float, y: float, angle: float, length: float = 2.4) -> list[Part]:
    """A long box with bushes in it."""
    return [
        (Surface.BUILDING, slab(x, y, angle, length, 1.0)),
        (Surface.TREE, slab(x, y, angle, length - 0.3, 0.7)),
    ]


def bench(x: float, y: float, angle: float, length: float = 1.8) -> list[Part]:
    """A bench that one sits down on from the direction of an angle."""
    return [(Surface.BUILDING, slab(x, y, angle, 0.5, length))]


def terrace(x: float, y: float, angle: float, rows: int, columns: int) -> list[Part]:
    """The round tables of a café, 2 m apart in a grid."""
    along = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([-along[1], along[0]])
    parts = []
    for row in range(rows):
        for column in range(columns):
            offset = 2.0 * (
                (column - 0.5 * (columns - 1)) * along + (row - 0.5 * (rows - 1)) * across
            )
            parts.append((Surface.BUILDING, disc(x + offset[0], y + offset[1], 0.45, 8)))
    return parts
