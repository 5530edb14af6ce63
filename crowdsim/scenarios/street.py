"""Plans of varied town streets: what stands where, and where people come from and go to.

A plan is drawn with the road along x, then mirrored and turned by a multiple of 90 degrees, so that
a network that sees the picture cannot learn one street by heart.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.recordings.surfaces import Surface

Polygon = NDArray[np.float64]
Surfaces = list[tuple[Surface, Polygon]]

LENGTH: Final = 36.0
"""Length of the street [m]."""
DEPTH: Final = 9.0
"""Ground behind each pavement, for buildings and gardens [m]."""
TREE_STRIP: Final = 1.1
"""Strip along the kerb that a row of trees takes [m]."""
WIDE_PAVEMENT: Final = 3.6
"""Pavements from this width on may have trees along the kerb [m]."""
CLEAR: Final = 1.05
"""Distance that people's ways keep from buildings and trees [m]; ways this clear of obstacles cost
the world no way-finding."""
STRIPE: Final = 0.5
"""Width of a crosswalk's stripes and of the gaps between them [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Street:
    """One street: its map, and the routes along it in the map's world frame.

    Attributes:
        map: The street, turned and mirrored.
        world_from_plan: (2, 2) orthogonal matrix: plan (road along x) to world.
        road_half: Half width of the road [m].
        pavement: Width of the southern and the northern pavement [m].
        crosswalk: x of the crosswalk's middle and its width, in the plan [m].
        trees: Whether trees stand along the kerb, south and north.
        alleys: (side, x) of the passages between buildings, in the plan; side is -1 or 1.
    """

    map: Map
    world_from_plan: NDArray[np.float64]
    road_half: float
    pavement: tuple[float, float]
    crosswalk: tuple[float, float]
    trees: tuple[bool, bool]
    alleys: tuple[tuple[int, float], ...]

    def lanes(self, side: int) -> tuple[float, float]:
        """Plan y between which people walk along one side: by the kerb, by the buildings [m]."""
        row = max(side, 0)
        kerb = TREE_STRIP + CLEAR if self.trees[row] else 0.4
        return side * (self.road_half + kerb), side * (self.road_half + self.pavement[row] - CLEAR)


@lru_cache(maxsize=256)
def street(layout: int) -> Street:
    """Plan number `layout`: widths, setbacks, gardens, trees, orientation all differ.

    The same number gives the same object, so that what physics derives from its map is cached too.
    """
    rng = np.random.default_rng(np.random.SeedSequence(layout, spawn_key=(0x57EE7,)))
    road_half = rng.uniform(3.0, 4.5)
    south, north = rng.uniform(2.6, 4.5, 2)
    crosswalk = (rng.uniform(-4.0, 4.0), rng.uniform(3.0, 4.5))
    surfaces = _road(road_half, crosswalk)
    alleys: list[tuple[int, float]] = []
    rows: list[bool] = []
    for side, pavement in ((-1, south), (1, north)):
        plots, gaps = _plots(rng, side, road_half + pavement)
        rows.append(bool(pavement >= WIDE_PAVEMENT and rng.random() < 0.6))
        surfaces += plots
        if rows[-1]:
            surfaces += _kerb_trees(rng, side, road_half, crosswalk)
        alleys += [(side, x) for x in gaps]
    world_from_plan = _orientation(rng)
    return Street(
        map=_to_map(
            surfaces, world_from_plan, road_half + south + DEPTH, road_half + north + DEPTH
        ),
        world_from_plan=world_from_plan,
        road_half=road_half,
        pavement=(south, north),
        crosswalk=crosswalk,
        trees=(rows[0], rows[1]),
        alleys=tuple(alleys),
    )


def _orientation(rng: np.random.Generator) -> NDArray[np.float64]:
    """One of the eight symmetries of the square, with exact entries."""
    turns = [[[1, 0], [0, 1]], [[0, -1], [1, 0]], [[-1, 0], [0, -1]], [[0, 1], [-1, 0]]]
    mirror = np.diag([1.0, float(rng.choice([-1.0, 1.0]))])
    return np.array(turns[rng.integers(4)], dtype=np.float64) @ mirror


def _to_map(
    surfaces: Surfaces, world_from_plan: NDArray[np.float64], south: float, north: float
) -> Map:
    corners = np.array([(-0.5 * LENGTH, -south), (0.5 * LENGTH, north)]) @ world_from_plan.T
    (x_min, y_min), (x_max, y_max) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    turned = tuple((surface, polygon @ world_from_plan.T) for surface, polygon in surfaces)
    return Map(bounds=(x_min, y_min, x_max, y_max), surfaces=turned)


def _box(x0: float, y0: float, x1: float, y1: float) -> Polygon:
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], dtype=np.float64)


def _road(half: float, crosswalk: tuple[float, float]) -> Surfaces:
    middle, width = crosswalk
    left, right = middle - 0.5 * width, middle + 0.5 * width
    stripes = np.arange(-half + 0.5 * STRIPE, half - STRIPE, 2.0 * STRIPE)
    return [
        (Surface.ROAD, _box(-0.5 * LENGTH, -half, 0.5 * LENGTH, half)),
        *((Surface.CROSSWALK, _box(left, y, right, y + STRIPE)) for y in stripes),
    ]


def _plots(rng: np.random.Generator, side: int, front: float) -> tuple[Surfaces, list[float]]:
    """Buildings with gardens behind one pavement, and the x of the alleys between them."""
    surfaces: Surfaces = []
    alleys: list[float] = []
    x, end = -0.5 * LENGTH, 0.5 * LENGTH
    while x < end:
        right = min(x + rng.uniform(7.0, 13.0), end)
        if end - right < 5.0:
            right = end
        surfaces += _plot(rng, x, right, side, front)
        gap = rng.uniform(2.6, 3.8)
        if right < end:
            alleys.append(right + 0.5 * gap)
        x = right + gap
    return surfaces, alleys


def _plot(rng: np.random.Generator, left: float, right: float, side: int, front: float) -> Surfaces:
    """One building; set back behind a lawn with trees, or straight at the pavement."""
    setback = rng.uniform(2.0, 4.5) if rng.random() < 0.5 else 0.0
    back = front + DEPTH
    building = _building(rng, left, right, front + setback, back)
    surfaces: Surfaces = []
    if setback > 0.0:
        lawn = _box(left, front, right, back)
        surfaces.append((Surface.GRASS, lawn))
        for x in np.arange(left + 1.3, right - 1.2, 2.6):
            if rng.random() < 0.5:
                radius = rng.uniform(0.5, min(0.9, 0.4 * setback))
                surfaces.append((Surface.TREE, _disc(x, front + 0.5 * setback, radius)))
    surfaces.append((Surface.BUILDING, building))
    return [(surface, polygon * [1.0, side]) for surface, polygon in surfaces]


def _building(
    rng: np.random.Generator, left: float, right: float, front: float, back: float
) -> Polygon:
    """A block, or an L whose missing corner faces the street."""
    width, depth = right - left, back - front
    if rng.random() < 0.6:
        return _box(left, front, right, back)
    notch_x, notch_y = left + width * rng.uniform(0.3, 0.6), front + depth * rng.uniform(0.25, 0.5)
    corners = [
        (left, notch_y),
        (notch_x, notch_y),
        (notch_x, front),
        (right, front),
        (right, back),
        (left, back),
    ]
    return np.array(corners, dtype=np.float64)


def _kerb_trees(
    rng: np.random.Generator, side: int, kerb: float, crosswalk: tuple[float, float]
) -> Surfaces:
    """A row of trees along the kerb, with the crosswalk left free."""
    middle, width = crosswalk
    spots = np.arange(-0.5 * LENGTH + rng.uniform(1.0, 4.0), 0.5 * LENGTH - 1.0, 5.0)
    free = spots[np.abs(spots - middle) > 0.5 * width + 2.0]
    return [(Surface.TREE, _disc(x, side * (kerb + 0.6), rng.uniform(0.3, 0.45))) for x in free]


def _disc(x: float, y: float, radius: float, corners: int = 8) -> Polygon:
    angle = 2.0 * math.pi * np.arange(corners) / corners
    return np.array([x, y]) + radius * np.column_stack([np.cos(angle), np.sin(angle)])
