"""Putting people down without overlap, and checking what a scenario is asked for."""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

SPACING: Final = 0.7
"""Least distance between two starts [m]: two of the widest bodies and a hand's breadth."""
ROBOT_CLEARANCE: Final = 1.0
"""Least distance between a person's start and the robot's [m]."""
ATTEMPTS: Final = 400


def place(
    count: int,
    draw: Callable[[int], NDArray[np.float64]],
    *,
    keep_away: Sequence[Sequence[float]] = (),
) -> NDArray[np.float64]:
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
    starts = np.empty((count, 2))
    away = np.asarray(keep_away, dtype=np.float64).reshape(-1, 2)
    for index in range(count):
        for _ in range(ATTEMPTS):
            point = draw(index)
            if _free(point, starts[:index], SPACING) and _free(point, away, ROBOT_CLEARANCE):
                starts[index] = point
                break
        else:
            raise ValueError(
                f"no room for person {index + 1} of {count} after {ATTEMPTS} attempts: "
                "ask for fewer pedestrians or more space"
            )
    return starts


def _free(point: NDArray[np.float64], others: NDArray[np.float64], distance: float) -> bool:
    return bool((((others - point) ** 2).sum(axis=1) >= distance**2).all())


def require_count(name: str, value: int, low: int, high: int) -> None:
    """Raise ValueError unless `value` is a whole number in low..high."""
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise ValueError(f"{name} must be a whole number in {low}..{high}, got {value!r}")


def require_range(name: str, value: float, low: float, high: float, unit: str = "m") -> None:
    """Raise ValueError unless `value` is a number in [low, high]."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ValueError(f"{name} must be in {low}..{high} {unit}, got {value!r}")
