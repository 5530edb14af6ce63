"""`crowdnav benchmark`: how fast everything is on this machine."""

import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from jsonargparse.typing import NonNegativeInt, PositiveInt

from scripts.options import Names
from scripts.output import require_file, write_json
from scripts.threads import bound_threads

Tables = dict[str, list[dict[str, Any]]]

SECTIONS: Final = (
    "crowd",
    "crowd_peers",
    "start",
    "pictures",
    "memory",
    "environment",
    "collection",
    "forecast",
    "exported",
    "training",
)
FILE_WIDTH: Final = 160
"""Columns of the tables where they do not go to a terminal."""


def benchmark(
    only: Names = Names(SECTIONS),
    threads: PositiveInt = 1,
    json: Path | None = None,
    seed: NonNegativeInt = 0,
) -> None:
    """Measure speed and memory of crowd, environment, forecast and training on this machine.

    Wall-clock medians of several repeats, compilation left out. Nothing else should run meanwhile.
    Other simulators are measured where `pip install 'crowdnav-testbed[bench]'` put them; each is
    taken in turn with ours, so that their ratios hold on a noisy machine too.

    Args:
        only: Sections to measure, separated by commas: crowd, crowd_peers (the crowd beside other
            simulators, minutes), start, pictures, memory, environment, collection (by PPO),
            forecast, exported (by ONNX Runtime), training.
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
    conditions = machine(threads)
    tables: Tables = {}
    with tqdm(_without_repeats(only), unit="section") as sections:
        for section in sections:
            sections.set_description(section)
            tables |= measure(section)(seed)
    print_figures(tables)
    print(", ".join(f"{name} {value}" for name, value in conditions.items()))
    write_json(json, {"machine": conditions, **tables})


def _without_repeats(sections: Sequence[str]) -> list[str]:
    """The sections in their own order, each once; `crowd_peers` measures `crowd` by the way."""
    inside = {"crowd"} if "crowd_peers" in sections else set()
    return [section for section in SECTIONS if section in set(sections) - inside]


def measure(section: str) -> Callable[[int], Tables]:
    """The function that measures the tables of a section, given a seed."""
    # Imported here: a section needs only its own part of the testbed, and `--help` none.
    measured: Callable[[int], Tables] = getattr(
        import_module(f"scripts.benchmarks.{section}"), section
    )
    return measured


def print_figures(tables: Tables) -> None:
    """Print every table that has rows; cells that a row has not are empty."""
    from rich.console import Console
    from rich.table import Table

    # Wide where nobody's terminal sets a width: figures must not be broken over lines.
    console = Console(width=None if sys.stdout.isatty() else FILE_WIDTH)
    for title, rows in tables.items():
        table = Table(title=title, title_justify="left")
        columns = list(dict.fromkeys(key for row in rows for key in row))
        for column in columns:
            numbers = all(isinstance(row.get(column, 0), int | float) for row in rows)
            table.add_column(column, justify="right" if numbers else "left", no_wrap=True)
        for row in rows:
            table.add_row(*(str(row.get(column, "")) for column in columns))
        if rows:
            console.print(table)
