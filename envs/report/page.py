"""Builds `report.html`: one file, no network, everything an evaluation found."""

import json
from collections.abc import Mapping
from html import escape
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

from crowdsim.recordings.store import write_atomic
from envs.evaluation import Evaluation
from envs.report import plots, tables
from envs.report.forecast_section import forecast_section
from envs.report.records import player_records

CAUTION = (
    "Differences are paired: both arms ran the same episodes from the same seeds. Intervals are "
    "95 % and not corrected for the number of comparisons; inconclusive means that the interval "
    "of the difference contains zero, not that there is no difference. An episode ends at the "
    "first contact, so an arm that collides early has had less time to intrude, to delay anybody "
    "or to stall: read those metrics beside the success rate."
)

PROTOCOL = (
    "Episodes start from the same initial conditions in every arm. A failure (contact, time limit) "
    "stays in every mean unless the name of the metric says otherwise.",
    "Distances are surface to surface, taken over the physics steps between two decisions.",
    "Proportions carry Wilson intervals, their paired differences Agresti–Min intervals; all other "
    "means and paired differences carry bias-corrected accelerated bootstrap intervals, "
    "which are somewhat too narrow below about 15 episodes.",
    "Pedestrian delay and displacement compare with a twin run of the same crowd without the "
    "robot. In a replay of recorded people both are unknown, since recorded people cannot react.",
    "Forecast errors are closed-loop: forecasts the robot saw, against what people then did "
    "beside that robot. Arms steer differently and so meet different futures.",
)


def build_report(evaluation: Evaluation, out: Path) -> Path:
    """Writes the report of an evaluation.

    Args:
        evaluation: What `envs.evaluation.evaluate` returned.
        out: File to write; it appears under its name only when it is complete.

    Returns:
        The file.
    """
    summary = evaluation.summary
    colors = plots.arm_colors(summary)
    fields = {
        "title": "Crowd navigation report",
        "style": read("style.css"),
        "lead": escape(_lead(summary)),
        "facts": _facts(summary["run"]),
        "findings": "".join(f"<li>{escape(sentence)}</li>" for sentence in summary["findings"]),
        "caution": CAUTION,
        "outcome_legend": tables.legend(
            {name.replace("_", ": ", 1): color for name, color in plots.OUTCOME_COLORS.items()}
        ),
        "outcome_plot": plots.outcome_plot(summary),
        "arm_legend": tables.legend(colors),
        "metric_plot": plots.metric_plot(summary),
        "differences": _differences(summary),
        "forecasts": forecast_section(summary, colors),
        "tables": _tables(summary, colors),
        "protocol": f"<ul>{''.join(f'<li>{escape(line)}</li>' for line in PROTOCOL)}</ul>",
        "definitions": tables.definitions(),
        "configuration": escape(json.dumps(summary["config"], indent=2)),
        "player": read("player.html") if evaluation.recorded else "",
        "script": _script(evaluation) if evaluation.recorded else "",
    }
    out.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(out, Template(read("template.html")).substitute(fields).encode())
    return out


def read(name: str) -> str:
    """A file that ships beside this module."""
    return resources.files("envs.report").joinpath(name).read_text(encoding="utf-8")


def embedded_json(value: Any) -> str:
    """JSON that can stand inside a script element, whatever its strings hold."""
    return json.dumps(value, separators=(",", ":")).replace("<", "\\u003c")


def _lead(summary: Mapping[str, Any]) -> str:
    scenarios = plots.real_scenarios(summary)
    arms = plots.arms_of(summary)
    episodes = sum(arm["n"] for group in scenarios.values() for arm in group["arms"].values())
    return (
        f"{episodes} episodes: {_counted(len(arms), 'arm')} (policy and forecaster) in "
        f"{_counted(len(scenarios), 'scenario')}, all arms from the same seeds, compared with "
        f"{summary['reference']}."
    )


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _facts(run: Mapping[str, Any]) -> str:
    """What was run, as term and description pairs."""
    items = []
    for term, value in run.items():
        wide = ' class="wide"' if term == "command" else ""
        shown = f"<code>{escape(str(value))}</code>" if term == "command" else escape(str(value))
        items.append(f"<div{wide}><dt>{escape(term)}</dt><dd>{shown}</dd></div>")
    return "".join(items)


def _differences(summary: Mapping[str, Any]) -> str:
    """The plot of paired differences, where there is more than one arm."""
    plot = plots.difference_plot(summary)
    if not plot:
        return ""
    heading = f"Paired differences to {escape(summary['reference'])}, all scenarios together"
    return f'<h3>{heading}</h3><div class="plot">{plot}</div>'


def _tables(summary: Mapping[str, Any], colors: Mapping[str, str]) -> str:
    """Per scenario a main table and, folded away, the full one."""
    parts = []
    for name, group in summary["scenarios"].items():
        title = "All scenarios together" if name == "all" else name
        parts.append(f"<h3>{escape(title)}</h3>")
        parts.append(tables.scenario_table(group, summary["reference"], colors))
        full = tables.full_table(group, summary["reference"], colors)
        parts.append(f"<details><summary>All metrics, {escape(title)}</summary>{full}</details>")
    return "".join(parts)


def _script(evaluation: Evaluation) -> str:
    records = embedded_json(player_records(evaluation.recorded, evaluation.summary["reference"]))
    return (
        f'<script type="application/json" id="records">{records}</script>\n'
        f"<script>\n{read('player.js')}</script>"
    )
