"""How long things take: medians of repeats, each long enough for the clock."""

import statistics
import time
from collections.abc import Callable

REPEATS = 5
AT_LEAST = 0.2
"""Wall-clock time that one repeat lasts at least [s]."""


def seconds_per_call(work: Callable[[], object]) -> float:
    """Median wall-clock time of one call [s], after a first call that is not counted."""
    work()
    calls = 1
    while (elapsed := _seconds(work, calls)) < AT_LEAST:
        calls = max(calls + 1, round(1.2 * calls * AT_LEAST / elapsed))
    return statistics.median(_seconds(work, calls) / calls for _ in range(REPEATS))


def _seconds(work: Callable[[], object], calls: int) -> float:
    start = time.perf_counter()
    for _ in range(calls):
        work()
    return time.perf_counter() - start
