"""The report's section on the forecasts themselves: by step, distance and history."""

from collections.abc import Mapping
from html import escape
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from envs.report import plots
from envs.summary import ALL_SCENARIOS

NOTE = (
    "Forecasts that the robot saw, against what people then did beside it: those whose whole "
    "horizon lies within the episode, of people who stayed. Means are over forecasts; bands and "
    "intervals are 95 % and resample whole episodes. Coverage is the share of true positions "
    "within the forecast's own radius, which should hold 90 %; the oracle states a radius of 0."
)

HEADINGS = {
    "by_distance": "Distance to the robot when the forecast was made, surface to surface [m]",
    "by_frames_seen": "Frames of history that the forecast was made from",
}
MEASURES = {"ade": "ADE [m]", "fde": "FDE [m]", "coverage": "coverage [%]"}


def forecast_section(summary: Mapping[str, Any], colors: Mapping[str, str]) -> str:
    """The section; nothing where no arm has a forecast that could be judged."""
    scenarios = summary["forecast_errors"]
    if not scenarios:
        return ""
    parts = [
        '<section aria-labelledby="forecasts">',
        '<h2 id="forecasts">Forecasts in the closed loop</h2>',
        f'<p class="note">{escape(NOTE)}</p>',
        f'<div class="plot">{step_plot(scenarios, colors)}</div>',
    ]
    for scenario, arms in scenarios.items():
        title = "all scenarios together" if scenario == ALL_SCENARIOS else scenario
        parts.append(f"<details><summary>By distance and history, {escape(title)}</summary>")
        parts += [bin_table(arms, column, colors) for column in HEADINGS]
        parts.append("</details>")
    return "\n".join([*parts, "</section>"])


def step_plot(scenarios: Mapping[str, Any], colors: Mapping[str, str]) -> str:
    """Error above coverage over the time ahead, one column of panels per scenario."""
    with plots.styled():
        figure = Figure(figsize=(max(5.0, 2.6 * len(scenarios)), 4.6))
        panels = figure.subplots(2, len(scenarios), sharex=True, sharey="row", squeeze=False)
        for column, (scenario, arms) in enumerate(scenarios.items()):
            for arm, entry in arms.items():
                _draw_band(panels[0, column], entry["by_step"], "error", 1.0, colors[arm])
                _draw_band(panels[1, column], entry["by_step"], "coverage", 100.0, colors[arm])
            panels[0, column].set_title(scenario.replace("_", " "), fontsize=9.5)
            panels[1, column].axhline(90, color=plots.INK, linewidth=0.8, alpha=0.6)
            panels[1, column].set_xlabel("seconds ahead")
        panels[0, 0].set_ylabel("error [m]")
        panels[1, 0].set_ylabel("coverage [%]")
        return plots.as_svg(figure, "Forecast error and coverage by time ahead")


def bin_table(arms: Mapping[str, Any], column: str, colors: Mapping[str, str]) -> str:
    """Arms and measures as rows, bins as columns; how many forecasts below each mean."""
    bins = list(dict.fromkeys(name for entry in arms.values() for name in entry[column]))
    bins.sort(key=lambda name: float(name.split("-")[0]))
    head = "".join(f'<th scope="col">{_bin_text(name)}</th>' for name in bins)
    body = [
        f'<tr><th scope="row"><span class="swatch" style="background:{colors[arm]}"></span>'
        f"{escape(arm)}, {label}</th>"
        + "".join(_cell(entry[column].get(name), measure) for name in bins)
        + "</tr>"
        for arm, entry in arms.items()
        for measure, label in MEASURES.items()
    ]
    return (
        f'<h3>{HEADINGS[column]}</h3><div class="scroll"><table><thead><tr><th scope="col">arm</th>'
        f"{head}</tr></thead><tbody>{''.join(body)}</tbody></table></div>"
    )


def _draw_band(axes: Axes, steps: Any, measure: str, factor: float, color: str) -> None:
    """A line over the time ahead with its interval as a band, where there is one."""
    seconds = [step["seconds"] for step in steps]
    axes.plot(seconds, [factor * step[measure]["mean"] for step in steps], color=color)
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
    if entry is None:
        return '<td class="missing">–</td>'
    number = entry[measure]
    factor, digits = (100.0, 0) if measure == "coverage" else (1.0, 2)
    interval = "no interval"
    if number["low"] is not None:
        interval = f"{factor * number['low']:.{digits}f} – {factor * number['high']:.{digits}f}"
    return (
        f"<td>{factor * number['mean']:.{digits}f}<small>{interval}, n {number['n']}</small></td>"
    )


def _bin_text(name: str) -> str:
    """A bin as a heading: `2–4`, `8 and more`."""
    return f"{name[:-1]} and more" if name.endswith("-") else name.replace("-", "–")
