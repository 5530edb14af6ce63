"""Tables of the report: one per scenario with the main metrics, and one with everything."""

from collections.abc import Callable, Mapping, Sequence
from html import escape
from typing import Any

from envs.evaluation.metric_table import HEADLINE, METRICS, Metric, aggregate_name
from envs.evaluation.summary import ALL_SCENARIOS

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
    return _scrolled(f'<th scope="col">metric</th>{head}', body)


def gain_table(scenarios: Mapping[str, Any], key: str, colors: Mapping[str, str]) -> str:
    """What forecasts change in one metric: arms as rows, scenarios as columns."""
    titles = ["all together" if name == ALL_SCENARIOS else name for name in scenarios]
    head = "".join(f'<th scope="col">{escape(title.replace("_", " "))}</th>' for title in titles)
    groups = [group["without_forecasts"] for group in scenarios.values()]
    body = [
        f'<tr><th scope="row">{_arm(arm, colors)}</th>'
        + "".join(f"<td>{_change(group[arm], key)}</td>" for group in groups)
        + "</tr>"
        for arm in groups[0]
    ]
    return _scrolled(f'<th scope="col">arm</th>{head}', body)


def change_table(
    lines: Mapping[str, Sequence[Mapping[str, Any]]],
    name: Callable[[Any], str],
    colors: Mapping[str, str],
) -> str:
    """A setting's values as rows, line by line, headline metrics as columns.

    Args:
        lines: Of `envs.evaluation.curves.setting_curves`.
        name: What a value is called.
        colors: By line.
    """
    head = "".join(f'<th scope="col">{_heading(METRICS[key])}</th>' for key in HEADLINE)
    body = [
        f'<tr><th scope="row">{_arm(line, colors)}, {escape(name(point["value"]))}</th>'
        f"<td>{point['n']}</td>{''.join(_changed_cell(point, key) for key in HEADLINE)}</tr>"
        for line, points in lines.items()
        for point in points
    ]
    return _scrolled(f'<th scope="col">arm</th><th scope="col">n</th>{head}', body)


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
    return _scrolled(f'<th scope="col">arm</th><th scope="col">n</th>{head}', body)


def _scrolled(head: str, body: Sequence[str]) -> str:
    """A table that scrolls by itself where the page is narrow."""
    return (
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(body)}</tbody></table></div>"
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
    interval = _interval(entry, key)
    if entry["n"] != group["arms"][arm]["n"]:
        interval += f", n {entry['n']}"
    return f"<td>{_mean(entry, key)}{_mark(group, arm, name)}<small>{interval}</small></td>"


def _changed_cell(point: Mapping[str, Any], key: str) -> str:
    """Mean and interval at one value of a setting, and the difference that it makes."""
    entry = point["metrics"][aggregate_name(key)]
    if entry["mean"] is None:
        return '<td class="missing">–</td>'
    change = _change(point["change"], key) if point["change"] else ""
    return f"<td>{_mean(entry, key)}<small>{_interval(entry, key)}</small>{change}</td>"


def _change(differences: Mapping[str, Any], key: str) -> str:
    """A signed difference with its mark and interval."""
    entry = differences[aggregate_name(key)]
    if entry["mean"] is None:
        return "–"
    verdict = entry["verdict"]
    mark = f' <span class="{verdict}">{MARKS[verdict]}</span>' if verdict in MARKS else ""
    return f"{_mean(entry, key, '+')}{mark}<small>{_interval(entry, key, '+')}</small>"


def _mean(entry: Mapping[str, Any], key: str, sign: str = "") -> str:
    factor, digits = _scale(key)
    return f"{factor * entry['mean']:{sign}z.{digits}f}"


def _interval(entry: Mapping[str, Any], key: str, sign: str = "") -> str:
    if entry["low"] is None:
        return "no interval"
    factor, digits = _scale(key)
    low, high = (f"{factor * entry[end]:{sign}z.{digits}f}" for end in ("low", "high"))
    return f"{low} – {high}"


def _scale(key: str) -> tuple[float, int]:
    """Factor and decimals that a metric is shown with: percent for shares."""
    return (100.0, 0) if METRICS[key].kind == "share" else (1.0, 2)


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
