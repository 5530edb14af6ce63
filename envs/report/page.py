"""Builds the report of an evaluation: everything it found, by question."""

import json
from collections.abc import Callable, Mapping
from html import escape
from pathlib import Path
from typing import Any, Final

from envs.evaluation import findings
from envs.evaluation.comparison import VISIBILITY_NAMES
from envs.evaluation.evaluate import Evaluation
from envs.evaluation.metric_table import HEADLINE, METRICS
from envs.report import curve_plots, plots, tables
from envs.report.document import section, sentences, write_document
from envs.report.forecast_section import forecast_section

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

TABLE_NOTE = (
    "Mean, 95 % interval below it. ▲ better and ▼ worse than the reference where the interval of "
    "the paired difference excludes zero; arrows in the head say which direction is the better one."
)
GAIN_NOTE = (
    "Success with forecasts less that of the same policy without, in points; the 95 % interval of "
    "the paired difference below it."
)
DOSE_NOTE = (
    "Each dot is a policy that was shown one forecaster's forecasts; the line across is the same "
    "policy without forecasts. Forecasts that err more stand further to the right. Of several "
    "horizons only the longest is shown."
)
HORIZON_NOTE = (
    "A policy over how far the forecasts that it was shown reach, all else the same, all scenarios "
    "together; 0 is without forecasts."
)
STEP_NOTE = "Differences are to the next shorter horizon."
CHANGE_NOTE = (
    "All scenarios together, each arm on the same seeds. Mean and 95 % interval; below those the "
    "paired difference to the first line of the arm, ▲ better and ▼ worse where its interval "
    "excludes zero."
)
PLACES: Final = {
    findings.HELP: "outcomes",
    findings.ROBOT_PART: "forecasts",
    findings.DOSE: "dose",
    findings.IN_THE_LOOP: "forecasts",
    findings.HORIZON: "horizon",
    findings.VISIBILITY: "robot_visible",
    findings.OTHER_PEOPLE: "model",
}
"""Section with the plot or table of each question."""


def build_report(evaluation: Evaluation, out: Path) -> Path:
    """Writes the report of an evaluation.

    Args:
        evaluation: What `envs.evaluation.evaluate.evaluate` returned.
        out: File to write; it appears under its name only when it is complete.

    Returns:
        The file.
    """
    summary = evaluation.summary
    colors = plots.arm_colors(summary)
    details = [
        _outcomes(summary, colors),
        forecast_section(summary, colors),
        _dose(summary),
        _horizon(summary),
        _setting(
            summary, "robot_visible", "Visible and invisible robot", VISIBILITY_NAMES.__getitem__
        ),
        _setting(summary, "model", "People of other motion models", str),
        section("tables", "Tables", _note(TABLE_NOTE), _tables(summary, colors)),
        _protocol(summary),
    ]
    return write_document(
        out,
        title="Crowd navigation report",
        lead=_lead(summary),
        run=summary["run"],
        sections=[_answers(summary, "".join(details)), *details],
        recorded=evaluation.recorded,
        reference=summary["reference"],
    )


def _answers(summary: Mapping[str, Any], details: str) -> str:
    """The questions with their answers, and where in `details` there is more."""
    parts = []
    for number, (question, found) in enumerate(summary["findings"].items(), start=1):
        place = PLACES[question]
        more = f' <a href="#{place}">more</a>' if f'id="{place}"' in details else ""
        parts.append(f"<h3>{number}. {escape(question)}{more}</h3>{sentences(found)}")
    return section("findings", "What was found", *parts, _note(CAUTION))


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


def _note(text: str) -> str:
    return f'<p class="note">{escape(text)}</p>'


def _plot(svg: str) -> str:
    return f'<div class="plot">{svg}</div>'


def _outcomes(summary: Mapping[str, Any], colors: Mapping[str, str]) -> str:
    outcomes = {name.replace("_", ": ", 1): color for name, color in plots.OUTCOME_COLORS.items()}
    return section(
        "outcomes",
        "Outcomes",
        f'<p class="legend">{tables.legend(outcomes)}</p>',
        _plot(plots.outcome_plot(summary)),
        _gains(summary, colors),
        "<h3>Means with 95&#8239;% intervals</h3>",
        f'<p class="legend">{tables.legend(plots.color_key(summary))}</p>',
        _plot(plots.metric_plot(summary)),
        _differences(summary),
    )


def _gains(summary: Mapping[str, Any], colors: Mapping[str, str]) -> str:
    """What forecasts change per arm and scenario; nothing without such a comparison."""
    scenarios = summary["scenarios"]
    if not any(group["without_forecasts"] for group in scenarios.values()):
        return ""
    others = "".join(
        f"<h4>{escape(METRICS[key].label)}</h4>{tables.gain_table(scenarios, key, colors)}"
        for key in HEADLINE[1:]
        if key != "forecast_fde"
    )
    return (
        f"<h3>What forecasts change</h3>{_note(GAIN_NOTE)}"
        f"{tables.gain_table(scenarios, 'success', colors)}"
        f"<details><summary>The same in other metrics</summary>{others}</details>"
    )


def _differences(summary: Mapping[str, Any]) -> str:
    """The plot of paired differences, where there is more than one arm."""
    plot = plots.difference_plot(summary)
    if not plot:
        return ""
    heading = f"Paired differences to {escape(summary['reference'])}, all scenarios together"
    return f"<h3>{heading}</h3>{_plot(plot)}"


def _dose(summary: Mapping[str, Any]) -> str:
    """Forecast error against success, where enough forecasters were compared."""
    if summary["dose_response"]["success"]["mean"] is None:
        return ""
    key = f'<p class="legend">{tables.legend(plots.color_key(summary))}</p>'
    plot = _plot(curve_plots.dose_plot(summary))
    return section("dose", findings.DOSE, _note(DOSE_NOTE), key, plot)


def _horizon(summary: Mapping[str, Any]) -> str:
    """Curves over the horizon, where several were compared."""
    lines = summary["settings"]["horizon"]
    if not lines:
        return ""
    plot = curve_plots.curve_plot(lines, "forecast horizon [s]")
    table = tables.change_table(
        lines, lambda seconds: f"{seconds:g} s", curve_plots.line_colors(lines)
    )
    folded = f"<details><summary>As a table</summary>{_note(STEP_NOTE)}{table}</details>"
    return section("horizon", findings.HORIZON, _note(HORIZON_NOTE), _plot(plot), folded)


def _setting(
    summary: Mapping[str, Any], setting: str, heading: str, name: Callable[[Any], str]
) -> str:
    """Arms at every value of what was varied; nothing where it was not."""
    lines = summary["settings"][setting]
    if not lines:
        return ""
    table = tables.change_table(lines, name, plots.arm_colors(summary))
    return section(setting, heading, _note(CHANGE_NOTE), table)


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


def _protocol(summary: Mapping[str, Any]) -> str:
    configuration = escape(json.dumps(summary["config"], indent=2))
    return section(
        "protocol",
        "Protocol and definitions",
        f"<ul>{''.join(f'<li>{escape(line)}</li>' for line in PROTOCOL)}</ul>",
        f"<details><summary>Definitions of all metrics</summary>{tables.definitions()}</details>",
        f"<details><summary>Configuration</summary><pre>{configuration}</pre></details>",
    )
