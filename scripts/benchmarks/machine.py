"""On what a benchmark ran."""

import os
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

from predictor.checkpoint import source_revision

LIBRARIES: Final = ("numpy", "numba", "pymunk", "torch", "gymnasium", "opencv-python-headless")


def machine(threads: int) -> dict[str, Any]:
    """Processor, cores, load before the start, versions, threads, revision of this source tree."""
    return {
        "cpu": _cpu(),
        "cores": os.cpu_count(),
        "load_average": round(os.getloadavg()[0], 2),
        "system": platform.platform(),
        "python": platform.python_version(),
        **{library: version(library) for library in LIBRARIES},
        "threads": threads,
        "revision": source_revision(),
    }


def _cpu() -> str:
    """Name of the processor; Linux tells it nowhere else."""
    file = Path("/proc/cpuinfo")
    if file.is_file():
        for line in file.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
