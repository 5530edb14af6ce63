"""Memory of many environments in one process.

Run as a program, it makes so many environments and prints the peak of its memory as JSON.
"""

import json
import resource
import sys
from pathlib import Path
from typing import Any, Final

from scripts.benchmarks.child import answer_of

ENVIRONMENTS: Final = (1, 1000)
PEDESTRIANS: Final = 20
FORECASTER: Final = "constant_velocity"
STEPS: Final = 60
"""By then most worlds have had a contact, and so a contact solver."""
STATUS: Final = Path("/proc/self/status")
"""Where Linux keeps the peak of this very program; `getrusage` may tell that of its parent."""
BYTES_PER_MIB: Final = 2**20


def memory(seed: int) -> dict[str, list[dict[str, Any]]]:
    """Measure the batched environment of `PEDESTRIANS` people in `circular_crossing`.

    Each number of environments has a process of its own, compiled kernels cached before.

    Returns:
        `memory`: rows with `environments`, `pedestrians`, `forecaster` and `mib`, the most
        physical memory that the whole process held.
    """
    answer_of("scripts.benchmarks.memory", ENVIRONMENTS[0], seed)  # not counted: may compile
    return {
        "memory": [
            {
                "environments": environments,
                "pedestrians": PEDESTRIANS,
                "forecaster": FORECASTER,
                **answer_of("scripts.benchmarks.memory", environments, seed),
            }
            for environments in ENVIRONMENTS
        ]
    }


def peak_mib(environments: int, seed: int) -> float:
    """Make, reset and step so many environments; the peak of this process since it began [MiB]."""
    import gymnasium

    import envs  # noqa: F401  (registers the environments)

    vector = gymnasium.make_vec(
        "crowdnav/CrowdNav-v0",
        num_envs=environments,
        scenario="circular_crossing",
        scenario_parameters={"pedestrians": PEDESTRIANS},
        forecaster=FORECASTER,
    )
    vector.reset(seed=seed)
    vector.action_space.seed(seed)
    for _ in range(STEPS):
        vector.step(vector.action_space.sample())
    return peak_bytes() / BYTES_PER_MIB


def peak_bytes() -> int:
    """The most physical memory that this process has held since its program began."""
    if STATUS.exists():
        fields = dict(line.split(":", 1) for line in STATUS.read_text().splitlines())
        return 1024 * int(fields["VmHWM"].split()[0])  # "12345 kB"
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # bytes on macOS


if __name__ == "__main__":
    print(json.dumps({"mib": round(peak_mib(int(sys.argv[1]), int(sys.argv[2])), 1)}))
