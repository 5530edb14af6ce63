"""How long things take: medians of repeats, each long enough for the clock."""

import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

REPEATS = 5
AT_LEAST = 0.2
"""Wall-clock time that one repeat lasts at least [s]."""


def seconds_per_call(work: Callable[[], object]) -> float:
    """Median wall-clock time of one call [s], after a first call that is not counted."""
    return float(np.median(seconds_in_turn([work])))


def seconds_in_turn(works: Sequence[Callable[[], object]]) -> NDArray[np.float64]:
    """Wall-clock time of one call of each work (W, `REPEATS`) [s], one work after the other.

    Ratios within a column are fair on a machine whose speed drifts. First calls are not counted.
    """
    calls = [_enough_calls(work) for work in works]
    rounds = [
        [_seconds(work, count) / count for work, count in zip(works, calls, strict=True)]
        for _ in range(REPEATS)
    ]
    return np.array(rounds).T


def _enough_calls(work: Callable[[], object]) -> int:
    """So many calls last `AT_LEAST`."""
    work()
    calls = 1
    while (elapsed := _seconds(work, calls)) < AT_LEAST:
        calls = max(calls + 1, round(1.2 * calls * AT_LEAST / elapsed))
    return calls


def _seconds(work: Callable[[], object], calls: int) -> float:
    start = time.perf_counter()
    for _ in range(calls):
        work()
    return time.perf_counter() - start
