"""Numbers with their intervals, and verdicts, in words."""

from collections.abc import Mapping
from typing import Any

from envs.evaluation.metric_table import Metric


def share(entry: Mapping[str, Any]) -> str:
    """A proportion with its interval in percent."""
    if entry["low"] is None:
        return f"{100 * entry['mean']:.0f} %{_interval_text(entry, 100.0, '.0f')}"
    return f"{100 * entry['mean']:.0f} % [{100 * entry['low']:.0f}, {100 * entry['high']:.0f}]"


def number(entry: Mapping[str, Any], metric: Metric) -> str:
    """A mean with its unit and interval."""
    style = f"z.{_decimals(entry)}f"
    return f"{entry['mean']:{style}}{_unit(metric)}{_interval_text(entry, 1.0, style)}"


def difference_text(entry: Mapping[str, Any], metric: Metric) -> str:
    """A signed difference with its interval; proportions in percentage points."""
    if metric.kind == "share":
        return f"{100 * entry['mean']:+z.1f} points{_interval_text(entry, 100.0, '+z.1f')}"
    style = f"+z.{_decimals(entry)}f"
    return f"{entry['mean']:{style}}{_unit(metric)}{_interval_text(entry, 1.0, style)}"


def _decimals(entry: Mapping[str, Any]) -> int:
    """Enough to tell the number and its interval from zero."""
    ends = [entry[key] for key in ("mean", "low", "high") if entry[key] is not None]
    return 3 if any(0 < abs(end) < 0.05 for end in ends) else 2


def _unit(metric: Metric) -> str:
    return f" {metric.unit}" if metric.unit else ""


def _interval_text(entry: Mapping[str, Any], factor: float, style: str) -> str:
    """Bracketed interval, or why there is none."""
    if entry["low"] is None:
        return " (too few episodes for an interval)"
    return f" [{factor * entry['low']:{style}}, {factor * entry['high']:{style}}]"


def verdict_words(verdict: str) -> str:
    """A verdict as the end of a sentence about a difference."""
    return "inconclusive" if verdict == "inconclusive" else f"which is {verdict}"


def listed(items: list[str]) -> str:
    """The items with commas and a last `and`."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"
