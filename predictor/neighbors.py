"""Whom a network sees beside the agent: the people nearest to it now."""

import numpy as np
from numpy.typing import NDArray


def nearest(
    history: NDArray[np.float64],
    valid: NDArray[np.bool_],
    worlds: NDArray[np.int64],
    agents: NDArray[np.int64],
    neighbors: int,
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The K people nearest to each agent now, nearest first.

    Args:
        history: (W, T, N, 2) positions in the frame of each world [m]; the last row is now.
        valid: (W, T, N) bool.
        worlds: (B,) world of each agent.
        agents: (B,) column of each agent in its world.
        neighbors: How many (K).

    Returns:
        (B, K, T, 2) positions and (B, K, T) bool; nothing is valid where there are fewer people.
    """
    count, frames, people = len(agents), history.shape[1], history.shape[2]
    x, y = np.moveaxis(history[:, -1], -1, 0)  # 2 x (W, N)
    ahead = x[worlds] - x[worlds, agents][:, None]  # (B, N)
    aside = y[worlds] - y[worlds, agents][:, None]
    candidate = valid[worlds, -1]  # (B, N), a copy
    candidate[np.arange(count), agents] = False
    distance = np.where(candidate, ahead * ahead + aside * aside, np.inf)
    nearest = _smallest(distance, neighbors)  # (B, <=K)
    there = np.take_along_axis(candidate, nearest, axis=1)
    tracks = np.zeros((count, neighbors, frames, 2))
    seen = np.zeros((count, neighbors, frames), dtype=np.bool_)
    found = min(neighbors, people)
    tracks[:, :found] = history[worlds[:, None], :, nearest]
    seen[:, :found] = valid[worlds[:, None], :, nearest] & there[:, :, None]
    return tracks, seen


def _smallest(values: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """Columns of the `count` smallest of each row, smallest first."""
    if values.shape[1] > 2 * count:  # sorting all of many takes longer than setting the few apart
        columns = np.sort(np.argpartition(values, count, axis=1)[:, :count], axis=1)
        values = np.take_along_axis(values, columns, axis=1)
        return np.take_along_axis(columns, np.argsort(values, axis=1, kind="stable"), axis=1)
    return np.argsort(values, axis=1, kind="stable")[:, :count]
