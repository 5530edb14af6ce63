"""How long a first world takes to start, with kernels still to be compiled and without.

Run as a program, it starts one world in this process and prints its times as JSON.
"""

import itertools
import json
import os
import statistics
import tempfile
import time
from typing import Any, Final

from scripts.benchmarks.child import answer_of

CACHED_REPEATS: Final = 3


def start(seed: int) -> dict[str, list[dict[str, Any]]]:
    """Measure fresh processes with a numba cache of their own: empty, then filled by the first.

    Returns:
        `start`: rows with `kernels` (`compiled` or `cached`, then medians of `CACHED_REPEATS`),
        `import_s`, `world_s` to set up 30 people between walls, `first_step_s` and their sum
        `total_s`; the start of Python itself is not part of it.
    """
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
        first, *others = (
            answer_of("scripts.benchmarks.start", seed, environment=environment)
            for _ in range(1 + CACHED_REPEATS)
        )
    cached = {key: statistics.median(other[key] for other in others) for key in first}
    return {"start": [_row("compiled", first), _row("cached", cached)]}


def _row(kernels: str, seconds: dict[str, float]) -> dict[str, Any]:
    rounded = {key: round(value, 3) for key, value in seconds.items()}
    return {"kernels": kernels, **rounded, "total_s": round(sum(seconds.values()), 3)}


def start_once(seed: int) -> dict[str, float]:
    """Import the simulator, set up a world and make a step, each with its time [s]."""
    times = [time.perf_counter()]
    import numpy as np

    from crowdsim.world import World
    from scripts.benchmarks.crowd import counterflow

    times.append(time.perf_counter())
    scenario = counterflow(30, True, "social_force", seed)
    world = World(scenario, rng=np.random.default_rng(seed))
    times.append(time.perf_counter())
    world.step()
    times.append(time.perf_counter())
    spans = (after - before for before, after in itertools.pairwise(times))
    return dict(zip(("import_s", "world_s", "first_step_s"), spans, strict=True))


if __name__ == "__main__":
    import sys

    print(json.dumps(start_once(int(sys.argv[1]))))
