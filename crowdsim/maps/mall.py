"""Shopping malls: aisles that cross in an atrium, shops with shelves behind doors."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray

from crowdsim.maps.plan import CLEAR, OVERLAP, Part, Place, Plan
from crowdsim.maps.shapes import bench, box, disc, fountain, planter, slab
from crowdsim.recordings.surfaces import Surface

FloatArray = NDArray[np.float64]

WALL: Final = 0.35
"""Thickness of the walls of shops [m]."""
EDGE: Final = 0.8
"""Distance of the gates from the border of the map [m]."""
SHELF: Final = 0.6
"""Depth of a shelf [m]."""


@dataclass(frozen=True, kw_only=True)
class Aisles:
    """Where the aisles run in the plan [m].

    Attributes:
        half: Half width and half height of the mall.
        main: Lower and upper edge (y) of the main aisle, which runs along x.
        cross: Left and right edge (x) of each aisle that crosses it.
        atrium: x, y and radius of the round court.
    """

    half: tuple[float, float]
    main: tuple[float, float]
    cross: tuple[tuple[float, float], ...]
    atrium: tuple[float, float, float]


def mall(rng: np.random.Generator) -> Place:
    """Draw a mall of 36 to 50 by 24 to 34 m with 8 to 16 shops."""
    plan, aisles = Plan(rng), _aisles(rng)
    (half_x, half_y), (low, high) = aisles.half, aisles.main
    plan.open(box(-half_x, low, half_x, high))
    for x in (-half_x + EDGE, half_x - EDGE):
        plan.gate((x, low + CLEAR), (x, high - CLEAR))
    for left, right in aisles.cross:
        _cross_aisle(plan, aisles, left, right)
    plan.open(disc(*aisles.atrium, 24))
    _shops(plan, aisles)
    _atrium(plan, aisles)
    _furniture(plan, aisles)
    return plan.finish("mall", (-half_x, -half_y, half_x, half_y))


def _aisles(rng: np.random.Generator) -> Aisles:
    half_x, half_y = rng.uniform(18.0, 25.0), rng.uniform(12.0, 17.0)
    width, y = rng.uniform(5.5, 8.5), rng.uniform(-3.0, 3.0)
    spots = rng.permutation([-0.45, 0.0, 0.45])[: rng.integers(1, 3)] * half_x
    cross = []
    for x in np.sort(spots + rng.uniform(-2.0, 2.0, len(spots))).tolist():
        half = rng.uniform(2.0, 3.2)
        cross.append((x - half, x + half))
    left, right = cross[int(rng.integers(len(cross)))]
    return Aisles(
        half=(half_x, half_y),
        main=(y - 0.5 * width, y + 0.5 * width),
        cross=tuple(cross),
        atrium=(0.5 * (left + right), y, rng.uniform(0.6 * width, 8.0)),
    )


def _cross_aisle(plan: Plan, aisles: Aisles, left: float, right: float) -> None:
    """An aisle to one or both sides of the main one, with a gate at each end."""
    (_, half_y), (low, high) = aisles.half, aisles.main
    sides = [-1, 1] if plan.rng.random() < 0.5 else [int(plan.rng.choice([-1, 1]))]
    for side in sides:
        near, far = (low + OVERLAP, -half_y) if side < 0 else (high - OVERLAP, half_y)
        plan.open(box(left, min(near, far), right, max(near, far)))
        plan.gate((left + CLEAR, far - EDGE * side), (right - CLEAR, far - EDGE * side))


def _shops(plan: Plan, aisles: Aisles) -> None:
    """Shops on both sides of the main aisle, where no other aisle and no atrium is."""
    rng = plan.rng
    (half_x, half_y), (low, high) = aisles.half, aisles.main
    for side, front in ((-1, low), (1, high)):
        x = -half_x + 0.5
        while x < half_x - 4.0:
            right = min(x + rng.uniform(5.0, 10.0), half_x - 0.5)
            back = front + side * min(
                rng.uniform(5.0, 11.0), half_y - 0.5 - abs(front) * np.sign(front * side)
            )
            room = box(x, min(front, back), right - WALL, max(front, back))
            blocked = shapely.Polygon(room).intersection(plan.ground).area
            if blocked < 1e-6:
                _shop(plan, room, front, side)
                x = right
            else:
                x += 0.5


def _shop(plan: Plan, room: FloatArray, front: float, side: int) -> None:
    """One room behind a wall with a door in it; shelves inside."""
    rng = plan.rng
    (left, low), (right, high) = room[0], room[2]
    low, high = (low, high - WALL) if side < 0 else (low + WALL, high)
    half = rng.uniform(0.9, min(2.0, 0.5 * (right - left) - 0.6))
    x = rng.uniform(left + half + 0.3, right - half - 0.3)
    plan.open(box(left, low, right, high))
    plan.open(box(x - half, front - (WALL + OVERLAP), x + half, front + WALL + OVERLAP))
    plan.door(x, front - 0.4 * side)
    plan.stop(x, front + 1.2 * side)
    _shelves(plan, left, low, right, high)


def _shelves(plan: Plan, left: float, low: float, right: float, high: float) -> None:
    """Rows of shelves, or a counter and a few tables."""
    rng = plan.rng
    if rng.random() < 0.6:
        pitch = rng.uniform(1.9, 2.4)
        length = high - low - 3.2
        for x in np.arange(left + 1.2 + SHELF, right - 1.2, pitch):
            shelf = slab(x, 0.5 * (low + high), 0.5 * np.pi, length, SHELF)
            if length > 1.0 and plan.furnish([(Surface.BUILDING, shelf)], gap=0.9):
                plan.stop(x + 0.5 * pitch, 0.5 * (low + high))
    else:
        room = box(left, low, right, high)
        plan.scatter(
            room, 4, lambda x, y, _: [(Surface.BUILDING, disc(x, y, 0.5, 8))], gap=1.0, front=1.1
        )


def _atrium(plan: Plan, aisles: Aisles) -> None:
    """What stands in the round court: a fountain, a tree bed, escalators, or a stage."""
    rng = plan.rng
    x, y, radius = aisles.atrium
    kind, size = (
        rng.choice(["fountain", "bed", "escalators", "stage"]),
        rng.uniform(0.3, 0.5) * radius,
    )
    if kind == "fountain":
        plan.furnish(fountain(x, y, size, 12), gap=1.2)
    elif kind == "bed":
        bed = [(Surface.BUILDING, disc(x, y, size, 6)), (Surface.TREE, disc(x, y, size - 0.3, 6))]
        plan.furnish(bed, gap=1.2)
    elif kind == "escalators":
        for shift in (-1.4, 1.4):
            plan.furnish([(Surface.BUILDING, slab(x, y + shift, 0.0, 5.0, 1.1))], gap=0.8)
    else:
        plan.furnish([(Surface.BUILDING, slab(x, y, rng.uniform(0, 3), size * 1.6, size))], gap=1.2)
    plan.scatter(disc(x, y, radius), 3, bench, gap=1.0, front=0.9)


def _furniture(plan: Plan, aisles: Aisles) -> None:
    rng = plan.rng
    (half_x, half_y), (low, high) = aisles.half, aisles.main
    pitch, radius = rng.uniform(5.0, 8.0), rng.uniform(0.25, 0.45)
    for x in np.arange(-half_x + 3.0, half_x - 3.0, pitch):
        for y in (low + 1.3 + radius, high - 1.3 - radius):
            plan.furnish([(Surface.BUILDING, disc(x, y, radius, 8))], gap=1.0)

    def kiosk(x: float, y: float, angle: float) -> list[Part]:
        return [(Surface.BUILDING, slab(x, y, angle, rng.uniform(1.6, 2.4), rng.uniform(1.6, 3.0)))]

    area = box(-half_x, low, half_x, high)
    plan.scatter(area, rng.integers(1, 4), kiosk, gap=1.4, front=2.0)
    plan.scatter(area, rng.integers(1, 5), planter, gap=1.2)
    plan.scatter(
        box(-half_x, -half_y, half_x, half_y), rng.integers(2, 7), bench, gap=1.2, front=0.9
    )
