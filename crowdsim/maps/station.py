"""Railway stations: doors, a concourse with shops and pillars, barriers, platforms with trains."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.maps.plan import OVERLAP, Part, Place, Plan
from crowdsim.maps.shapes import bench, box, disc, planter, slab
from crowdsim.recordings.surfaces import Surface

FloatArray = NDArray[np.float64]

TRACK: Final = 3.4
"""Width of one track's bed [m]."""
BUFFER: Final = 1.5
"""Where the tracks end, from the concourse [m]."""
DOOR: Final = 1.4
"""Width of a train's door [m]."""
MARGIN: Final = 4.0
"""Outer walls and what lies behind them [m]."""


@dataclass(frozen=True, kw_only=True)
class Hall:
    """Where things are in the plan [m]: the concourse below y = 0, the platforms above.

    Attributes:
        half: Half the width of concourse and tracks.
        depth: Depth of the concourse.
        length: Length of the platforms.
        platforms: (left, right) of each.
    """

    half: float
    depth: float
    length: float
    platforms: tuple[tuple[float, float], ...]


def station(rng: np.random.Generator) -> Place:
    """Draw a terminus with 2 or 3 platforms; trains stand at some of them."""
    plan, hall = Plan(rng), _hall(rng)
    plan.open(box(-hall.half, -hall.depth, hall.half, 0.0))
    for left, right in hall.platforms:
        _platform(plan, hall, left, right)
    _tracks(plan, hall)
    _doors(plan, hall)
    _shops(plan, hall)
    if rng.random() < 0.6:
        _barriers(plan, hall)
    _pillars(plan, hall)
    _furniture(plan, hall)
    side = hall.half + MARGIN
    return plan.finish("station", (-side, -hall.depth - MARGIN, side, hall.length + 1.0))


def _hall(rng: np.random.Generator) -> Hall:
    """Track, platform, two tracks, platform, ..., track from left to right."""
    widths = rng.uniform(4.5, 8.0, int(rng.integers(2, 4)))
    half = 0.5 * float(widths.sum()) + TRACK * len(widths)
    left, platforms = -half + TRACK, []
    for width in widths.tolist():
        platforms.append((left, left + width))
        left += width + 2.0 * TRACK
    return Hall(
        half=half,
        depth=rng.uniform(12.0, 18.0),
        length=rng.uniform(16.0, 26.0),
        platforms=tuple(platforms),
    )


def _platform(plan: Plan, hall: Hall, left: float, right: float) -> None:
    """A platform with railings, and on it pillars, benches or a flight of stairs in the middle."""
    rng = plan.rng
    plan.open(box(left, -OVERLAP, right, hall.length))
    for x in (left, right):
        plan.wall((x, BUFFER), (x, hall.length))
    plan.wall((left, hall.length), (right, hall.length))
    middle, pitch = 0.5 * (left + right), rng.uniform(3.5, 6.0)
    things = rng.permutation(["pillar", "bench", "stairs"])[: rng.integers(1, 4)]
    for index, y in enumerate(np.arange(rng.uniform(3.0, 6.0), hall.length - 2.0, pitch)):
        thing = things[index % len(things)]
        if thing == "pillar":
            plan.furnish([(Surface.BUILDING, disc(middle, y, 0.35, 8))], gap=1.2)
        elif thing == "stairs":
            plan.furnish([(Surface.BUILDING, slab(middle, y, 0.0, 1.8, 3.0))], gap=1.2)
        elif plan.furnish(bench(middle, y, 0.0), gap=1.2):
            plan.stop(middle + 0.9, y)


def _tracks(plan: Plan, hall: Hall) -> None:
    """A track on either side of each platform, some with a train whose doors are gates."""
    for left, right in hall.platforms:
        for edge, side in ((left, -1.0), (right, 1.0)):
            far = edge + side * TRACK
            plan.pave(Surface.ROAD, box(min(edge, far), BUFFER, max(edge, far), hall.length + 1.0))
            if plan.rng.random() < 0.6:
                _train(plan, hall, edge, side)


def _train(plan: Plan, hall: Hall, edge: float, side: float) -> None:
    near, far = edge + 0.15 * side, edge + (TRACK - 0.3) * side
    first = BUFFER + plan.rng.uniform(0.8, 2.5)
    plan.build(Surface.BUILDING, box(min(near, far), first, max(near, far), hall.length + 1.0))
    on_platform = edge - 0.7 * side
    for y in np.arange(first + 2.0, hall.length - 2.0, plan.rng.uniform(4.5, 7.0)):
        plan.gate((on_platform, y - 0.5 * DOOR), (on_platform, y + 0.5 * DOOR))


def _doors(plan: Plan, hall: Hall) -> None:
    """Two to four doors to the town, in the front and sometimes at the sides."""
    rng = plan.rng
    spots = rng.permutation(np.linspace(-0.7, 0.7, 3))[: rng.integers(1, 4)] * hall.half
    for x in spots.tolist():
        half = rng.uniform(1.2, 2.6)
        outside = -hall.depth - MARGIN
        plan.open(box(x - half, outside, x + half, -hall.depth + OVERLAP))
        plan.gate((x - half + 0.6, outside + 0.8), (x + half - 0.6, outside + 0.8))
    for side in (-1.0, 1.0):
        if rng.random() < 0.7 or len(spots) == 1:
            half, y = rng.uniform(1.2, 2.2), -rng.uniform(0.4, 0.75) * hall.depth
            near, far = side * (hall.half - OVERLAP), side * (hall.half + MARGIN)
            plan.open(box(min(near, far), y - half, max(near, far), y + half))
            x = far - 0.8 * side
            plan.gate((x, y - half + 0.6), (x, y + half - 0.6))


def _shops(plan: Plan, hall: Hall) -> None:
    """Shop fronts in the front wall, set back behind it."""
    rng = plan.rng
    for x in np.arange(-hall.half + rng.uniform(1.5, 4.0), hall.half - 2.0, rng.uniform(4.5, 7.0)):
        half, depth = rng.uniform(0.9, 1.8), rng.uniform(0.8, 2.5)
        front = -hall.depth
        corners = [(x - half, front - depth), (x + half, front - depth), (x, front - 0.5)]
        if not any(plan.is_open(corner) for corner in corners):
            plan.open(box(x - half, front - depth, x + half, front + OVERLAP))
            plan.door(x, front + 0.3)


def _barriers(plan: Plan, hall: Hall) -> None:
    """A row of ticket barriers across the concourse; all gaps let a wheelchair through."""
    gap, y = plan.rng.uniform(1.1, 1.5), -plan.rng.uniform(2.2, 3.2)
    pitch = gap + 0.45
    count = int((2.0 * hall.half) // pitch)
    closed = 2.0 * hall.half - count * pitch
    for index in range(count):
        x = -hall.half + 0.5 * closed + (index + 0.5) * pitch
        plan.build(Surface.BUILDING, slab(x, y, 0.0, 0.45, 1.5))


def _pillars(plan: Plan, hall: Hall) -> None:
    rng = plan.rng
    pitch_x, pitch_y = rng.uniform(5.5, 9.0), rng.uniform(4.5, 7.0)
    radius, corners = rng.uniform(0.3, 0.55), int(rng.choice([4, 8, 12]))
    for x in np.arange(-hall.half + 0.5 * pitch_x, hall.half - 1.0, pitch_x):
        for y in np.arange(-hall.depth + 0.7 * pitch_y, -4.0, pitch_y):
            plan.furnish([(Surface.BUILDING, disc(x, y, radius, corners))], gap=1.3)


def _furniture(plan: Plan, hall: Hall) -> None:
    rng = plan.rng

    def kiosk(x: float, y: float, angle: float) -> list[Part]:
        return [(Surface.BUILDING, slab(x, y, angle, rng.uniform(1.8, 3.0), rng.uniform(2.0, 4.5)))]

    def desk(x: float, y: float, angle: float) -> list[Part]:
        return [(Surface.BUILDING, disc(x, y, rng.uniform(1.0, 1.7), 12))]

    area = box(-hall.half, -hall.depth, hall.half, -4.0)
    plan.scatter(area, rng.integers(1, 4), kiosk, front=2.3)
    plan.scatter(area, rng.integers(0, 2), desk, front=2.5)
    plan.scatter(area, rng.integers(2, 9), bench, gap=1.3, front=0.9)
    plan.scatter(area, rng.integers(0, 4), planter, gap=1.3)
