"""Errors of forecasts against what people then did."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

MOVING_DISPLACEMENT = 0.5
"""An agent moves if it ends a window of history and future this far from where it began [m]."""

MISS_DISTANCE: Final = 2.0
"""A forecast that ends further than this from the truth misses [m] (Chang et al. 2019)."""

CONTACT_DISTANCE: Final = 0.2
"""Two people nearer than this collide [m]: twice the radius that TrajNet++ gives a person."""


def displacement_errors(
    forecast: NDArray[np.floating], future: NDArray[np.floating]
) -> NDArray[np.float64]:
    """Distance between forecast and future at each step: (..., F, 2) twice to (..., F) [m]."""
    if forecast.shape != future.shape:
        raise ValueError(f"forecast must be {future.shape} like future, got {forecast.shape}")
    difference = forecast.astype(np.float64) - future.astype(np.float64)
    return np.asarray(np.linalg.norm(difference, axis=-1))


def ade(errors: NDArray[np.float64]) -> float:
    """Average displacement error of (M, F) errors [m]: over all steps, then over trajectories."""
    return float(errors.mean())


def fde(errors: NDArray[np.float64]) -> float:
    """Final displacement error of (M, F) errors [m]: at the last step, over trajectories."""
    return float(errors[:, -1].mean())


def moves(history: NDArray[np.float64], future: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Who gets at least `MOVING_DISPLACEMENT` away between the first and the last frame.

    Args:
        history: (T, A, 2) positions [m].
        future: (F, A, 2) later positions of the same people [m].

    Returns:
        (A,) bool.
    """
    displacement = np.linalg.norm(future[-1] - history[0], axis=-1)
    return np.asarray(displacement >= MOVING_DISPLACEMENT)


def misses(errors: NDArray[np.float64]) -> NDArray[np.float64]:
    """(M,) 1 where (M, F) errors [m] end further than `MISS_DISTANCE` from the truth, else 0."""
    return np.where(errors[:, -1] > MISS_DISTANCE, 1.0, 0.0)


def collides(
    path: NDArray[np.float64], others: NDArray[np.float64] | None = None
) -> NDArray[np.float64]:
    """Who comes within `CONTACT_DISTANCE` of somebody else, as TrajNet++ tells collisions.

    Looked at are the steps of the paths and the middles between them (Kothari, Kreiss and Alahi
    2021; `trajnetplusplustools.metrics.collision` with its defaults).

    Args:
        path: (F, A, 2) positions [m].
        others: (F, A, 2) positions of the same people to be met instead, where somebody's own are
            left out; None takes `path`.

    Returns:
        (A,) 1 or 0; NaN for one person alone, who can meet nobody.
    """
    steps = path[:, :, None] - (path if others is None else others)[:, None]  # (F, A, A, 2)
    looked_at = np.concatenate([steps, (steps[1:] + steps[:-1]) / 2.0])
    distance = np.linalg.norm(looked_at, axis=-1).min(axis=0)  # (A, A)
    np.fill_diagonal(distance, np.inf)
    met = (distance <= CONTACT_DISTANCE).any(axis=1)
    return np.where(len(distance) > 1, met, np.nan)
