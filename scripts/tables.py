"""The table that commands print at their end; the report says more."""

from collections.abc import Mapping
from typing import Any, Final

from rich.box import SIMPLE
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from envs.evaluation.metric_table import METRICS, aggregate_name

COLUMNS: Final = {
    "success": "success [%]",
    "collision_pedestrian": "contact [%]",
    "time_to_goal_penalized": "time [s]",
}
"""Columns of the episode table, and headings short enough for a terminal of 80 columns."""
CAPTION: Final = (
    "Means with 95 % intervals over n episodes. Contact: with a person. Time: until the goal, "
    "failures at the time limit."
)


def print_summary(summary: Mapping[str, Any]) -> None:
    """Print the main metrics of every arm in every scenario, each mean with its 95 % interval.

    Args:
        summary: Of `envs.evaluation.evaluate.Evaluation`.
    """
    table = Table(box=SIMPLE, show_edge=False, pad_edge=False, caption=CAPTION)
    table.add_column("policy/forecaster", overflow="fold")
    for heading in COLUMNS.values():
        table.add_column(escape(heading), justify="right", no_wrap=True)
    for scenario, group in summary["scenarios"].items():
        count = next(iter(group["arms"].values()))["n"]
        table.add_row(f"[bold]{escape(scenario)}[/bold]", f"n = {count}")
        for arm, entry in group["arms"].items():
            cells = [_cell(key, entry["metrics"][aggregate_name(key)]) for key in COLUMNS]
            table.add_row(escape(arm), *map(escape, cells))
        table.add_section()
    Console().print(table)


def _cell(key: str, interval: Mapping[str, Any]) -> str:
    """A mean with its interval; nothing where the metric is unknown."""
    if interval["mean"] is None:
        return ""
    share = METRICS[key].kind == "share"
    mean, low, high = (_number(interval[name], share) for name in ("mean", "low", "high"))
    return f"{mean} [{low}, {high}]"


def _number(value: float | None, share: bool) -> str:
    if value is None:
        return "?"
    return f"{100 * value:.0f}" if share else f"{value:.1f}"
