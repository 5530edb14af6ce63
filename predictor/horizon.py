"""How fast a forecast may be, so that none explodes however far a network is rolled on."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from predictor.inputs import last_step

ANYBODYS_SPEED: Final = 3.0
"""Anybody may be forecast to reach this speed [m/s]: a jog."""

ACCELERATION: Final = 1.5
"""And anybody so many times the fastest that they were seen at."""

TOP_SPEED: Final = 12.0
"""But nobody this [m/s]: a sprint or a fast bicycle. What seems faster was measured wrong."""


def speed_limit(
    history: NDArray[np.float64], valid: NDArray[np.bool_], frame_dt: float
) -> NDArray[np.float64]:
    """How fast each person may be forecast to be, from what was observed of them.

    Args:
        history: (..., T, N, 2) observed positions [m]; the last row is now.
        valid: (..., T, N) bool.
        frame_dt: Time between two frames [s].

    Returns:
        (..., N) speeds [m/s], from `ANYBODYS_SPEED` to `TOP_SPEED`.
    """
    steps = np.linalg.norm(np.diff(history, axis=-3), axis=-1)  # (..., T - 1, N)
    both = valid[..., 1:, :] & valid[..., :-1, :]
    fastest = np.where(both, steps, 0.0).max(axis=-2, initial=0.0)
    across_a_gap = np.linalg.norm(last_step(history, valid)[0], axis=-1)
    seen = np.maximum(fastest, across_a_gap) / frame_dt
    return np.asarray(np.clip(ACCELERATION * seen, ANYBODYS_SPEED, TOP_SPEED))


def bounded(
    path: NDArray[np.float64], start: NDArray[np.float64], longest: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Shorten the steps of a path that are too long; what comes after moves along.

    Args:
        path: (W, F, N, 2) forecast positions [m].
        start: (W, N, 2) positions before the first of them [m].
        longest: (W, N) longest step [m].

    Returns:
        (W, F, N, 2), bit for bit that of `path` for everyone who has no step that is too long.
    """
    steps = np.diff(path, axis=1, prepend=start[:, None])
    length = np.linalg.norm(steps, axis=-1)  # (W, F, N)
    too_long = length > longest[:, None]
    if not too_long.any():
        return path
    shorten = np.where(too_long, longest[:, None] / np.where(too_long, length, 1.0), 1.0)
    shortened = start[:, None] + np.cumsum(shorten[..., None] * steps, axis=1)
    return np.where(too_long.any(axis=1)[:, None, :, None], shortened, path)
