"""Shopping streets without cars: bent, with alleys, pockets, a middle row of trees and benches."""

import itertools
import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.maps.plan import CLEAR, OVERLAP, Part, Place, Plan
from crowdsim.maps.shapes import bench, box, disc, fountain, lane, planter, slab, terrace, tree
from crowdsim.recordings.surfaces import Surface

FloatArray = NDArray[np.float64]

HALF_LENGTH: Final = 24.0
HALF_HEIGHT: Final = 17.0
"""Half sides of the map [m]."""
EDGE: Final = 0.8
"""Distance of the gates from the border of the map [m]."""


def street(rng: np.random.Generator) -> Place:
    """Draw a street 6 to 11 m wide with 0 to 3 bends, 1 to 5 alleys, shops, and things in it."""
    plan = Plan(rng)
    plan.gardens(HALF_LENGTH)
    middle, width = _middle(rng), rng.uniform(6.0, 11.0)
    for here, there in itertools.pairwise(middle):
        plan.open(lane(here, there, width))
        plan.open(disc(there[0], there[1], 0.5 * width, 24))
    for end in middle[[0, -1]]:
        x = math.copysign(HALF_LENGTH - EDGE, end[0])
        half = 0.5 * width - CLEAR - 0.2
        plan.gate((x, end[1] - half), (x, end[1] + half))
    _alleys(plan, middle)
    if width > 8.0 and rng.random() < 0.5:
        for here, there in itertools.pairwise(middle):
            plan.open(lane(here, there, 3.0), Surface.ROAD)
            plan.open(disc(there[0], there[1], 1.5, 16), Surface.ROAD)
    _pocket(plan, middle, width)
    _shops(plan, middle, width)
    _furniture(plan, middle, width)
    return plan.finish("street", (-HALF_LENGTH, -HALF_HEIGHT, HALF_LENGTH, HALF_HEIGHT))


def _middle(rng: np.random.Generator) -> FloatArray:
    """The line (P, 2) that the street follows from border to border; straight at both ends."""
    bends = int(rng.integers(0, 4))
    x = np.linspace(-HALF_LENGTH, HALF_LENGTH, bends + 4)
    x[[1, -2]] = -HALF_LENGTH + 3.0, HALF_LENGTH - 3.0
    y = rng.uniform(-5.5, 5.5, len(x)) * (bends > 0) + rng.uniform(-3.0, 3.0)
    y[0], y[-1] = y[1], y[-2]
    return np.column_stack([x, y])


def _at(middle: FloatArray, x: float) -> float:
    return float(np.interp(x, middle[:, 0], middle[:, 1]))


def _alleys(plan: Plan, middle: FloatArray) -> None:
    rng = plan.rng
    spots = rng.permutation(np.linspace(-16.0, 16.0, 6))[: rng.integers(1, 6)]
    for x in spots:
        side, lean = rng.choice([-1.0, 1.0]), rng.uniform(-0.35, 0.35)
        foot = np.array([x + rng.uniform(-2.0, 2.0), _at(middle, x)])
        ahead = np.array([math.sin(lean), side * math.cos(lean)])
        width = rng.uniform(2.6, 5.0)
        plan.open(lane(foot, foot + 30.0 * ahead, width))
        at = foot + (side * (HALF_HEIGHT - EDGE) - foot[1]) / ahead[1] * ahead
        half = 0.5 * width / math.cos(lean) - CLEAR - 0.15
        across = np.array([half, 0.0])
        plan.gate(at - across, at + across)


def _pocket(plan: Plan, middle: FloatArray, width: float) -> None:
    """A little court beside the street, paved or green, or none."""
    rng = plan.rng
    if rng.random() < 0.4:
        return
    x, side = rng.uniform(-12.0, 12.0), rng.choice([-1.0, 1.0])
    half, depth = rng.uniform(3.5, 6.0), rng.uniform(4.0, 6.5)
    near = _at(middle, x) + side * (0.5 * width - 2.0)
    far = near + side * (2.0 + depth)
    court = box(x - half, min(near, far), x + half, max(near, far))
    plan.open(court)
    if rng.random() < 0.5:
        inset = box(x - half + 1.8, min(near, far) + 1.8, x + half - 1.8, max(near, far) - 1.8)
        plan.open(inset, Surface.GRASS)
    if rng.random() < 0.5:
        plan.furnish(
            fountain(x, near + side * (1.0 + 0.5 * depth), rng.uniform(1.2, 1.9), 8), gap=1.2
        )
    plan.scatter(court, 3, lambda u, v, _: tree(u, v, rng.uniform(0.5, 1.0)), gap=1.2)
    plan.scatter(court, 2, bench, gap=1.0, front=0.9)


def _shops(plan: Plan, middle: FloatArray, width: float) -> None:
    """Recessed doors on both sides."""
    rng = plan.rng
    for here, there in itertools.pairwise(middle):
        length = float(np.linalg.norm(there - here))
        ahead = (there - here) / length
        for side in (-1.0, 1.0):
            outward = side * np.array([-ahead[1], ahead[0]])
            front = here + 0.5 * width * outward
            for along in np.arange(rng.uniform(1.5, 4.0), length - 1.5, rng.uniform(4.0, 7.0)):
                sill = front + along * ahead
                if not plan.is_open(sill + 0.9 * outward):
                    recess = lane(sill - OVERLAP * outward, sill + 0.9 * outward, 1.8)
                    plan.open(recess)
                    plan.door(*(sill - 0.4 * outward))


def _furniture(plan: Plan, middle: FloatArray, width: float) -> None:
    rng = plan.rng
    _middle_row(plan, middle)

    def kiosk(x: float, y: float, angle: float) -> list[Part]:
        return [(Surface.BUILDING, slab(x, y, angle, rng.uniform(1.6, 2.4), rng.uniform(1.6, 3.0)))]

    def tables(x: float, y: float, angle: float) -> list[Part]:
        return terrace(x, y, angle, int(rng.integers(1, 3)), int(rng.integers(2, 5)))

    low, high = middle[:, 1].min() - 0.5 * width, middle[:, 1].max() + 0.5 * width
    area = box(-HALF_LENGTH + 2.0, low, HALF_LENGTH - 2.0, high)
    plan.scatter(area, rng.integers(0, 3), kiosk, front=2.0)
    plan.scatter(area, rng.integers(0, 3), tables, gap=1.2, front=0.0)
    plan.scatter(area, rng.integers(1, 5), planter, gap=1.2)
    plan.scatter(area, rng.integers(1, 5), bench, gap=1.2, front=0.9)


def _middle_row(plan: Plan, middle: FloatArray) -> None:
    """Trees, planters and benches in turn along a line that is not quite the middle."""
    rng = plan.rng
    things = rng.permutation(["tree", "planter", "bench"])[: rng.integers(1, 4)]
    shift, pitch = rng.uniform(-1.5, 1.5), rng.uniform(4.0, 7.0)
    for index, x in enumerate(np.arange(-HALF_LENGTH + 3.0, HALF_LENGTH - 3.0, pitch)):
        y, thing = _at(middle, x) + shift, things[index % len(things)]
        if thing == "tree":
            plan.furnish(tree(x, y, rng.uniform(0.4, 0.9)), gap=1.2)
        elif thing == "planter":
            plan.furnish(planter(x, y, 0.0), gap=1.2)
        elif plan.furnish(bench(x, y, 0.5 * math.pi), gap=1.2):
            plan.stop(x, y + 0.9)
