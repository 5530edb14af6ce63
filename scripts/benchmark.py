"""`crowdnav benchmark`: how fast everything is on this machine."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from jsonargparse.typing import NonNegativeInt, PositiveInt

from scripts.options import Names
from scripts.output import require_file, write_json
from scripts.threads import bound_threads

SECTIONS: Final = ("crowd", "crowd_peers", "environment", "forecast", "training")


def benchmark(
    only: Names = Names(SECTIONS),
    threads: PositiveInt = 1,
    json: Path | None = None,
    seed: NonNegativeInt = 0,
) -> None:
    """Measure the speed of crowd, environment, forecast and training.

    Wall-clock medians of several repeats, compilation left out. Nothing else should run meanwhile.

    Args:
        only: Sections to measure, separated by commas: crowd, crowd_peers, environment, forecast,
            training.
        threads: Threads of torch, BLAS and OpenCV.
        json: File for the figures.
        seed: Seed of crowds, actions and weights.
    """
    unknown = [section for section in only if section not in SECTIONS]
    if unknown:
        raise ValueError(f"expected sections among {', '.join(SECTIONS)}, found {unknown[0]!r}")
    require_file(json)
    bound_threads(threads, override=True)
    import torch
    from tqdm import tqdm

    from scripts.benchmarks.machine import machine

    torch.set_num_threads(threads)
    found: dict[str, Any] = {"machine": machine(threads)}
    for section in tqdm(only, unit="section"):
        found[section] = measure(section)(seed)
    print_figures(found)
    write_json(json, found)


def measure(section: str) -> Callable[[int], list[dict[str, Any]]]:
    """The function that measures a section, given a seed."""
    # Imported here: a section needs only its own part of the testbed, and `--help` none.
    from scripts.benchmarks.crowd import crowd
    from scripts.benchmarks.environment import environment
    from scripts.benchmarks.forecast import forecast
    from scripts.benchmarks.training import training

    return {
        "crowd": crowd,
        "crowd_peers": lambda seed: [],  # no peer is a dependency of this distribution
        "environment": environment,
        "forecast": forecast,
        "training": training,
    }[section]


def print_figures(found: dict[str, Any]) -> None:
    """Print a table for each section that has rows."""
    from rich.console import Console
    from rich.table import Table

    console = Console()
    for section, rows in found.items():
        if section == "machine" or not rows:
            continue
        table = Table(*rows[0], title=section)
        for row in rows:
            table.add_row(*(str(value) for value in row.values()))
        console.print(table)
