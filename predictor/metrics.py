"""Errors of forecasts against what people then did."""

import numpy as np
from numpy.typing import NDArray

MOVING_DISPLACEMENT = 0.5
"""An agent moves if it ends a window of history and future this far from where it began [m]."""


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
