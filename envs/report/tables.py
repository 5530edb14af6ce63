"""Tables of the report: one per scenario with the main metrics, and one with everything."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from envs.metric_table import METRICS, Metric, aggregate_name

MAIN = (
    "success",
    "collision_pedestrian",
    "collision_wall",
    "timeout",
    "time_to_goal_penalized",
    "spl",
    "clearance_min",
    "intrusion_ratio@4.8",
    "pedestrian_delay",
    "forecast_fde",
)
"""Columns of the first table of a scenario."""

MARKS = {"better": "▲", "worse": "▼", "different": "◆"}


def scenario_table(group: Mapping[str, Any], reference: str, colors: Mapping[str, str]) -> str:
    """Arms as rows, main metrics as columns; marks where the paired difference is conclusive."""
    keys = [key for key in MAIN if _known(group, key)]
    return _table(group, reference, colors, keys)


def full_table(group: Mapping[str, Any], reference: str, colors: Mapping[str, str]) -> str:
    """Metrics as rows, arms as columns: everything that was measured."""
    arms = list(group["arms"])
    head = "".join(f'<th scope="col">{_arm(arm, colors)}</th>' for arm in arms)
    body = []
    for key, metric in METRICS.items():
        if not _known(group, key):
            continue
        cells = "".join(_cell(group, arm, key) for arm in arms)
        body.append(f'<tr><th scope="row">{_heading(metric)}</th>{cells}</tr>')
    return (
        '<div class="scroll"><table class="full"><thead><tr><th scope="col">metric</th>'
        f"{head}</tr></thead><tbody>{''.join(body)}</tbody></table></div>"
    )


def definitions() -> str:
    """What every metric means, as a description list."""
    items = []
    for key, metric in METRICS.items():
        unit = f" [{metric.unit}]" if metric.unit else ""
        items.append(
            f"<dt><code>{escape(aggregate_name(key))}</code>{escape(unit)}</dt>"
            f"<dd>{escape(metric.definition)}</dd>"
        )
    return f"<dl>{''.join(items)}</dl>"


def legend(colors: Mapping[str, str]) -> str:
    """Names beside their colors."""
    return "".join(
        f'<span><span class="swatch" style="background:{color}"></span>{escape(name)}</span>'
        for name, color in colors.items()
    )


def _table(
    group: Mapping[str, Any], reference: str, colors: Mapping[str, str], keys: Sequence[str]
) -> str:
    head = "".join(f'<th scope="col">{_heading(METRICS[key])}</th>' for key in keys)
    body = []
    for arm, entry in group["arms"].items():
        note = ' <span class="note">reference</span>' if arm == reference else ""
        cells = "".join(_cell(group, arm, key) for key in keys)
        body.append(
            f'<tr><th scope="row">{_arm(arm, colors)}{note}</th><td>{entry["n"]}</td>{cells}</tr>'
        )
    return (
        '<div class="scroll"><table><thead><tr><th scope="col">arm</th><th scope="col">n</th>'
        f"{head}</tr></thead><tbody>{''.join(body)}</tbody></table></div>"
    )


def _arm(arm: str, colors: Mapping[str, str]) -> str:
    return f'<span class="swatch" style="background:{colors[arm]}"></span>{escape(arm)}'


def _heading(metric: Metric) -> str:
    arrow = {"higher": "&nbsp;↑", "lower": "&nbsp;↓", "neither": ""}[metric.better]
    unit = "%" if metric.kind == "share" else metric.unit
    return f"{escape(metric.label)}{f' [{escape(unit)}]' if unit else ''}{arrow}"


def _cell(group: Mapping[str, Any], arm: str, key: str) -> str:
    """Mean, interval below it, and the mark of the paired difference."""
    name = aggregate_name(key)
    entry = group["arms"][arm]["metrics"][name]
    if entry["mean"] is None:
        return '<td class="missing">–</td>'
    factor, digits = (100.0, 0) if METRICS[key].kind == "share" else (1.0, 2)
    interval = "no interval"
    if entry["low"] is not None:
        interval = f"{factor * entry['low']:z.{digits}f} – {factor * entry['high']:z.{digits}f}"
    if entry["n"] != group["arms"][arm]["n"]:
        interval += f", n {entry['n']}"
    return (
        f"<td>{factor * entry['mean']:z.{digits}f}{_mark(group, arm, name)}"
        f"<small>{interval}</small></td>"
    )


def _mark(group: Mapping[str, Any], arm: str, name: str) -> str:
    """A triangle where the difference to the reference excludes zero."""
    difference = group["differences"].get(arm, {}).get(name)
    if difference is None or difference["verdict"] == "inconclusive":
        return ""
    verdict = difference["verdict"]
    return f' <span class="{verdict}" title="{verdict} than the reference">{MARKS[verdict]}</span>'


def _known(group: Mapping[str, Any], key: str) -> bool:
    name = aggregate_name(key)
    return any(arm["metrics"][name]["mean"] is not None for arm in group["arms"].values())
