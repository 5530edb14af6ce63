"""Putting people down without overlap, and checking what a scenario is asked for."""

from collections.abc import Callable, Iterator, Sequence
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.distance_field import distance_field
from crowdsim.map import Map
from crowdsim.pedestrians import ALONE

FloatArray = NDArray[np.float64]

SPACING: Final = 0.7
"""Least distance between two starts [m]: two of the widest bodies and a hand's breadth."""
ROBOT_CLEARANCE: Final = 1.0
"""Least distance between a person's start and the robot's [m]."""
WALL_CLEARANCE: Final = 0.4
"""Least distance between a person's start and a wall [m]."""
ATTEMPTS: Final = 2000


def place(
    count: int,
    draw: Callable[[int], FloatArray],
    *,
    keep_away: Sequence[Sequence[float]] = (),
) -> FloatArray:
    """Draw starts one after the other until each stands free of all earlier ones.

    Args:
        count: Number of people N.
        draw: Proposes a start (2,) [m] for the person of the given index.
        keep_away: Points (x, y) [m] that starts keep `ROBOT_CLEARANCE` from.

    Returns:
        (N, 2) starts at least `SPACING` apart [m].

    Raises:
        ValueError: Somebody found no room in `ATTEMPTS` draws.
    """
    alone = np.full(count, ALONE)
    return place_parties(alone, lambda first, _: draw(first)[None], keep_away=keep_away)


def place_parties(
    group: NDArray[np.int64],
    draw: Callable[[int, int], FloatArray],
    *,
    keep_away: Sequence[Sequence[float]] = (),
    ground: Map | None = None,
) -> FloatArray:
    """Draw the starts of groups and of who walks alone, as `place` does.

    Args:
        group: (N,) who walks with whom, members in consecutive rows (`draw_groups`).
        draw: Proposes starts (size, 2) [m] for the party of a size whose first row is given.
        keep_away: Points (x, y) [m] that starts keep `ROBOT_CLEARANCE` from.
        ground: Map whose walls starts keep `WALL_CLEARANCE` from; None where there are none near.

    Returns:
        (N, 2) starts [m].

    Raises:
        ValueError: A party found no room in `ATTEMPTS` draws.
    """
    starts = np.empty((len(group), 2))
    away = np.asarray(keep_away, dtype=np.float64).reshape(-1, 2)
    for first, size in parties(group):
        for _ in range(ATTEMPTS):
            points = draw(first, size)
            if (
                _free(points, starts[:first], SPACING)
                and _free(points, away, ROBOT_CLEARANCE)
                and all(_free(points[k:], points[:k], SPACING) for k in range(1, size))
                and (ground is None or _off_walls(points, ground))
            ):
                starts[first : first + size] = points
                break
        else:
            raise ValueError(
                f"no room for person {first + 1} of {len(group)} after {ATTEMPTS} attempts: "
                "ask for fewer pedestrians or more space"
            )
    return starts


def parties(group: NDArray[np.int64]) -> Iterator[tuple[int, int]]:
    """Give the first row and the size of each group, and of each person who is alone."""
    first = 0
    while first < len(group):
        size = 1 if group[first] == ALONE else int((group == group[first]).sum())
        yield first, size
        first += size


@njit(cache=True)
def _free(points: FloatArray, others: FloatArray, distance: float) -> bool:
    for k in range(len(points)):
        for other in range(len(others)):
            dx, dy = points[k, 0] - others[other, 0], points[k, 1] - others[other, 1]
            if dx * dx + dy * dy < distance * distance:
                return False
    return True


def _off_walls(points: FloatArray, ground: Map) -> bool:
    return bool((distance_field(ground).distance(points) >= WALL_CLEARANCE).all())


def require_count(name: str, value: int, low: int, high: int) -> None:
    """Raise ValueError unless `value` is a whole number in low..high."""
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise ValueError(f"{name} must be a whole number in {low}..{high}, got {value!r}")


def require_range(name: str, value: float, low: float, high: float, unit: str = "m") -> None:
    """Raise ValueError unless `value` is a number in [low, high]."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ValueError(f"{name} must be in {low}..{high} {unit}, got {value!r}")
