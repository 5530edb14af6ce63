"""The report's section on the forecasts themselves: by step, distance and history."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from envs.evaluation.summary import ALL_SCENARIOS
from envs.report import plots
from envs.report.tables import legend

NOTE = (
    "Forecasts that the robot saw, against what people then did beside it: those whose whole "
    "horizon lies within the episode, of people who stayed. Means are over forecasts; bands and "
    "intervals are 95 % and resample whole episodes. Coverage is the share of true positions "
    "within the forecast's own radius, which should hold 90 %; nll the mean negative log density "
    "there of the round normal distribution that has 90 % within that radius, lower being better. "
    "The oracle states a radius of 0, and so has no nll."
)

HEADINGS = {
    "by_distance": "Distance to the robot when the forecast was made, surface to surface [m]",
    "by_frames_seen": "Frames of history that the forecast was made from",
}
PART_NOTE = (
    "From 2.8 s into each episode, when histories can be full, and every 4.8 s after that the "
    "crowd was rolled on twice from the same state: with the robot taken out, and with one that "
    "brakes and stands. The model's own error is that against the people without a robot; the "
    "displacement is the distance from those to where people truly were. The two may point "
    "against each other: together they bound the whole error and do not add up to it. Whole less "
    "own error is negative where the robot moved people nearer to their forecasts."
)
PARTS = {
    "error": "whole error [m]",
    "model_error": "model's own error [m]",
    "caused": "whole less own error [m]",
    "displacement": "displacement by the robot [m]",
    "standing_displacement": "displacement had it stood [m]",
}
SHOWN_SECONDS = 1.2
"""The table of parts shows about this often a step [s]."""
MEASURES = {"ade": "ADE [m]", "fde": "FDE [m]", "coverage": "coverage [%]", "nll": "nll [nat]"}


def forecast_section(summary: Mapping[str, Any], colors: Mapping[str, str]) -> str:
    """The section; nothing where no arm has a forecast that could be judged."""
    scenarios = summary["forecast_errors"]
    if not scenarios:
        return ""
    drawn = (
        ("by_step", "error", "error [m]", 1.0),
        ("by_step", "coverage", "coverage [%]", 100.0),
        ("by_step", "nll", "nll [nat]", 1.0),
    )
    parts = [
        '<section aria-labelledby="forecasts">',
        '<h2 id="forecasts">Forecasts in the closed loop</h2>',
        f'<p class="note">{escape(NOTE)}</p>',
        f'<p class="legend">{legend(plots.color_key(summary))}</p>',
        f'<div class="plot">{step_plot(scenarios, colors, drawn)}</div>',
    ]
    for scenario, arms in scenarios.items():
        title = escape(_title(scenario))
        parts.append(f"<details><summary>By distance and history, {title}</summary>")
        parts += [bin_table(arms, column, colors) for column in HEADINGS]
        parts.append("</details>")
    return "\n".join([*parts, _robot_part(scenarios, colors), "</section>"])


def _robot_part(scenarios: Mapping[str, Any], colors: Mapping[str, str]) -> str:
    """How much of the errors is the robot's own doing; nothing without twins."""
    split = {
        scenario: {arm: entry for arm, entry in arms.items() if entry["robot_part"]}
        for scenario, arms in scenarios.items()
    }
    split = {scenario: arms for scenario, arms in split.items() if arms}
    if not split:
        return ""
    drawn = (
        ("robot_part", "model_error", "model's own [m]", 1.0),
        ("robot_part", "displacement", "by the robot [m]", 1.0),
    )
    tables = "".join(
        f"<details><summary>Parts of the error, {escape(_title(scenario))}</summary>"
        f"{part_table(arms, colors)}</details>"
        for scenario, arms in split.items()
    )
    return (
        f'<h3>What the robot itself caused</h3><p class="note">{escape(PART_NOTE)}</p>'
        f'<div class="plot">{step_plot(split, colors, drawn)}</div>{tables}'
    )


def step_plot(
    scenarios: Mapping[str, Any],
    colors: Mapping[str, str],
    rows: Sequence[tuple[str, str, str, float]],
) -> str:
    """Means with their bands over the time ahead, one column of panels per scenario.

    Args:
        scenarios: Of the summary.
        colors: By arm.
        rows: Of panels: where the steps stand, what of them, its name, and a factor for it.
    """
    with plots.styled():
        figure = Figure(figsize=(max(5.0, 2.6 * len(scenarios)), 2.3 * len(rows)))
        panels = figure.subplots(
            len(rows), len(scenarios), sharex=True, sharey="row", squeeze=False
        )
        for column, (scenario, arms) in enumerate(scenarios.items()):
            for row, (steps, measure, _, factor) in enumerate(rows):
                for arm, entry in arms.items():
                    _draw_band(panels[row, column], entry[steps], measure, factor, colors[arm])
            panels[0, column].set_title(plots.wrapped_name(scenario, 20), fontsize=9.5)
            panels[-1, column].set_xlabel("seconds ahead")
        for row, (_, _, label, _) in enumerate(rows):
            panels[row, 0].set_ylabel(label)
        names = " and ".join(measure.replace("_", " ") for _, measure, _, _ in rows)
        return plots.as_svg(figure, f"Forecasts by time ahead: {names}")


def part_table(arms: Mapping[str, Any], colors: Mapping[str, str]) -> str:
    """Arms and parts of their errors as rows, seconds ahead as columns."""
    steps = next(iter(arms.values()))["robot_part"]
    every = max(1, round(SHOWN_SECONDS / steps[0]["seconds"]))
    shown = list(range(len(steps) - 1, -1, -every))[::-1]
    head = "".join(f'<th scope="col">{steps[index]["seconds"]:g} s</th>' for index in shown)
    body = [
        _row_head(arm, label, colors)
        + "".join(_cell(entry["robot_part"][index], part) for index in shown)
        + "</tr>"
        for arm, entry in arms.items()
        for part, label in PARTS.items()
    ]
    return _table(head, body)


def bin_table(arms: Mapping[str, Any], column: str, colors: Mapping[str, str]) -> str:
    """Arms and measures as rows, bins as columns; how many forecasts below each mean."""
    bins = list(dict.fromkeys(name for entry in arms.values() for name in entry[column]))
    bins.sort(key=lambda name: float(name.split("-")[0]))
    head = "".join(f'<th scope="col">{_bin_text(name)}</th>' for name in bins)
    body = [
        _row_head(arm, label, colors)
        + "".join(_cell(entry[column].get(name), measure) for name in bins)
        + "</tr>"
        for arm, entry in arms.items()
        for measure, label in MEASURES.items()
    ]
    return f"<h3>{HEADINGS[column]}</h3>{_table(head, body)}"


def _row_head(arm: str, label: str, colors: Mapping[str, str]) -> str:
    """Begins a row of a table."""
    swatch = f'<span class="swatch" style="background:{colors[arm]}"></span>'
    return f'<tr><th scope="row">{swatch}{escape(arm)}, {escape(label)}</th>'


def _table(head: str, body: Sequence[str]) -> str:
    return (
        '<div class="scroll"><table><thead><tr><th scope="col">arm</th>'
        f"{head}</tr></thead><tbody>{''.join(body)}</tbody></table></div>"
    )


def _title(scenario: str) -> str:
    return "all scenarios together" if scenario == ALL_SCENARIOS else scenario


def _draw_band(axes: Axes, steps: Any, measure: str, factor: float, color: str) -> None:
    """A line over the time ahead with its interval as a band, where there is one."""
    told = [step for step in steps if step[measure]["mean"] is not None]
    seconds = [step["seconds"] for step in told]
    axes.plot(seconds, [factor * step[measure]["mean"] for step in told], color=color)
    known = [step for step in steps if step[measure]["low"] is not None]
    axes.fill_between(
        [step["seconds"] for step in known],
        [factor * step[measure]["low"] for step in known],
        [factor * step[measure]["high"] for step in known],
        color=color,
        alpha=0.18,
        linewidth=0,
    )


def _cell(entry: Mapping[str, Any] | None, measure: str) -> str:
    """A mean with interval and count."""
    number = None if entry is None else entry[measure]
    if number is None or number["mean"] is None:
        return '<td class="missing">–</td>'
    factor, digits = (100.0, 0) if measure == "coverage" else (1.0, 2)
    interval = "no interval"
    if number["low"] is not None:
        interval = f"{factor * number['low']:z.{digits}f} – {factor * number['high']:z.{digits}f}"
    return (
        f"<td>{factor * number['mean']:z.{digits}f}<small>{interval}, n {number['n']}</small></td>"
    )


def _bin_text(name: str) -> str:
    """A bin as a heading: `2–4`, `8 and more`."""
    return f"{name[:-1]} and more" if name.endswith("-") else name.replace("-", "–")
