"""Town squares: an uneven court between houses, streets that lead in, a thing in the middle."""

import math
from typing import Final

import numpy as np
import shapely
from numpy.typing import NDArray

from crowdsim.maps.plan import CLEAR, OVERLAP, Part, Place, Plan
from crowdsim.maps.shapes import bench, box, disc, fountain, lane, planter, slab, terrace, tree
from crowdsim.recordings.surfaces import Surface

FloatArray = NDArray[np.float64]

STREET_LENGTH: Final = 7.0
"""How far the streets are drawn beyond the farthest corner of the court [m]."""


def square(rng: np.random.Generator) -> Place:
    """Draw a square of 26 to 40 m with 3 to 6 streets, shops around it, and things on it."""
    plan = Plan(rng)
    court = _court(rng)
    reach = float(np.abs(court).max()) + STREET_LENGTH
    plan.gardens(reach)
    plan.open(court)
    _streets(plan, court, reach)
    _shops(plan, court)
    _middle(plan, court)
    _furniture(plan, court)
    return plan.finish("square", (-reach, -reach, reach, reach))


def _court(rng: np.random.Generator) -> FloatArray:
    """A convex-looking court (P, 2): a rectangle with its corners moved or cut off."""
    half = rng.uniform(11.0, 18.0, 2)
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half
    corners = corners + rng.uniform(-2.5, 2.5, (4, 2))
    outline: list[FloatArray] = []
    for index in range(4):
        here, before, after = corners[index], corners[index - 1], corners[(index + 1) % 4]
        if rng.random() < 0.35:
            cut = rng.uniform(0.12, 0.3)
            outline += [here + cut * (before - here), here + cut * (after - here)]
        else:
            outline.append(here)
    return np.array(outline)


def _streets(plan: Plan, court: FloatArray, reach: float) -> None:
    """Streets from the court to the border of the map, each with a gate at its end."""
    rng = plan.rng
    count = int(rng.integers(3, 7))
    turn = rng.uniform(0.0, 2.0 * math.pi)
    for index in range(count):
        angle = turn + 2.0 * math.pi * (index + rng.uniform(-0.2, 0.2)) / count
        ahead = np.array([math.cos(angle), math.sin(angle)])
        across = np.array([-ahead[1], ahead[0]])
        width, shift = rng.uniform(3.2, 6.5), rng.uniform(-3.0, 3.0)
        start = 5.0 * ahead + shift * across
        length = float((reach / np.abs(ahead)).min())
        end = start + length * ahead
        plan.open(lane(start, end, width))
        if width > 5.0:
            inside = shapely.LineString([start, end]).intersection(shapely.Polygon(court))
            plan.open(lane(start + inside.length * ahead, end, width - 2.6), Surface.ROAD)
        _gate(plan, start, ahead, across, 0.5 * width - CLEAR, reach)


def _gate(
    plan: Plan, start: FloatArray, ahead: FloatArray, across: FloatArray, half: float, reach: float
) -> None:
    """A gate across a street, as far out as all of it lies on the map."""
    ends = np.array([start - half * across, start + half * across])  # (2, 2)
    room = (np.where(ahead > 0, reach - 0.8, -reach + 0.8) - ends) / ahead  # (2, 2)
    gate = ends + room.min() * ahead
    plan.gate(gate[0], gate[1])


def _shops(plan: Plan, court: FloatArray) -> None:
    """Recessed doors in the fronts around the court."""
    for here, there in zip(court, np.roll(court, -1, axis=0), strict=True):
        length = float(np.linalg.norm(there - here))
        ahead = (there - here) / length
        outward = np.array([ahead[1], -ahead[0]])
        for along in np.arange(
            plan.rng.uniform(2.5, 5.0), length - 2.5, plan.rng.uniform(5.0, 9.0)
        ):
            sill = here + along * ahead
            recess = lane(
                sill - OVERLAP * outward, sill + 0.9 * outward, plan.rng.uniform(1.4, 2.6)
            )
            if not plan.is_open(sill + 0.9 * outward):
                plan.open(recess)
                plan.door(*(sill - 0.4 * outward))


def _middle(plan: Plan, court: FloatArray) -> None:
    """What gives the square its name: a fountain, a monument, a lawn, or a market."""
    rng = plan.rng
    x, y = court.mean(axis=0) + rng.uniform(-2.0, 2.0, 2)
    size = rng.uniform(2.2, 4.0)
    kind = rng.choice(["fountain", "monument", "lawn", "market"])
    if kind == "fountain":
        plan.furnish(fountain(x, y, size, int(rng.choice([6, 8, 12, 16]))))
        _ring_of_benches(plan, x, y, size + 2.1)
    elif kind == "monument":
        plan.open(disc(x, y, size + 1.5, 24), Surface.GRASS)
        plan.furnish([(Surface.BUILDING, slab(x, y, rng.uniform(0.0, math.pi), size, 0.6 * size))])
        _ring_of_benches(plan, x, y, size + 2.5)
    elif kind == "lawn":
        _lawn(plan, x, y)
    else:
        _market(plan, x, y)


def _ring_of_benches(plan: Plan, x: float, y: float, radius: float) -> None:
    count = int(plan.rng.integers(3, 8))
    for angle in 2.0 * math.pi * np.arange(count) / count + plan.rng.uniform(0.0, 1.0):
        u, v = math.cos(angle), math.sin(angle)
        parts = bench(x + radius * u, y + radius * v, angle)
        if plan.furnish(parts, gap=1.2):
            plan.stop(x + (radius + 0.85) * u, y + (radius + 0.85) * v)


def _lawn(plan: Plan, x: float, y: float) -> None:
    """A lawn in quarters, with paths between them and trees on it."""
    rng, middle = plan.rng, np.array([x, y])
    half, path = rng.uniform(5.0, 8.0, 2), rng.uniform(1.8, 3.0)
    for side_x in (-1, 1):
        for side_y in (-1, 1):
            near, far = 0.5 * path * np.array([side_x, side_y]), half * [side_x, side_y]
            low, high = middle + np.minimum(near, far), middle + np.maximum(near, far)
            plan.open(box(*low, *high), Surface.GRASS)
            for _ in range(int(rng.integers(1, 4))):
                u, v = rng.uniform(low + 1.2, high - 1.2)
                plan.furnish(tree(u, v, rng.uniform(0.7, 1.5)), gap=1.0)


def _market(plan: Plan, x: float, y: float) -> None:
    """Rows of stalls with lanes between them."""
    rng = plan.rng
    angle, pitch = rng.uniform(0.0, math.pi), rng.uniform(4.2, 5.2)
    along = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([-along[1], along[0]])
    for row in np.arange(-1.0, 1.5):
        for column in np.arange(-1.5, 2.0):
            at = np.array([x, y]) + column * (pitch - 0.4) * along + row * pitch * across
            stall = [(Surface.BUILDING, slab(at[0], at[1], angle, rng.uniform(1.8, 2.6), 1.6))]
            if rng.random() < 0.85 and plan.furnish(stall, gap=1.0):
                plan.stop(*(at + 1.6 * across))


def _furniture(plan: Plan, court: FloatArray) -> None:
    rng = plan.rng

    def kiosk(x: float, y: float, angle: float) -> list[Part]:
        return [(Surface.BUILDING, slab(x, y, angle, rng.uniform(1.8, 2.8), rng.uniform(1.8, 3.4)))]

    def tables(x: float, y: float, angle: float) -> list[Part]:
        return terrace(x, y, angle, int(rng.integers(2, 4)), int(rng.integers(2, 5)))

    plan.scatter(court, rng.integers(1, 4), kiosk, front=2.2)
    plan.scatter(court, rng.integers(0, 3), tables, gap=1.4, front=0.0)
    plan.scatter(court, rng.integers(2, 9), lambda x, y, _: tree(x, y, rng.uniform(0.5, 1.3)))
    plan.scatter(court, rng.integers(0, 4), planter)
    plan.scatter(court, rng.integers(2, 7), bench, front=0.9)
