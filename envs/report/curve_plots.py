"""Curves over what was varied, and forecast error against how the robot drove."""

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from envs.evaluation.knobs import is_number, value_text
from envs.evaluation.metric_table import METRICS, aggregate_name
from envs.report import plots

SHOWN: Final = ("success", "collision_pedestrian", "time_to_goal_penalized", "forecast_fde")
"""Metrics that a curve is drawn of."""

MARKERS: Final = "osD^vPX*"
"""Of policies, where several stand in a plot."""

KNOBS_IN_A_ROW: Final = 4
"""More knobs than these go below one another."""

Lines = Mapping[str, Sequence[Mapping[str, Any]]]


def curve_plot(lines: Lines, label: str, shown: Sequence[str] = SHOWN) -> str:
    """The curves as an `<svg>` element."""
    with plots.styled():
        return plots.as_svg(curve_figure(lines, label, shown), f"Outcomes over the {label}")


def curve_figure(lines: Lines, label: str, shown: Sequence[str] = SHOWN) -> Figure:
    """One panel per metric: a line with its interval over the values of a setting or knob.

    Args:
        lines: Points by line, as `envs.evaluation.curves.curve` gives them; all at the same values,
            or at numbers.
        label: What the axis says.
        shown: Four metrics that the points have.
    """
    figure = Figure(figsize=(10.5, 6.2))
    panels = figure.subplots(2, 2).ravel()
    for axes, key in zip(panels, shown, strict=True):
        _draw_panel(axes, lines, key)
        axes.set_title(_with_unit(key))
        axes.set_xlabel(label)
    panels[0].legend(frameon=False, fontsize=8.5, labelcolor=plots.INK)
    return figure


def overview_plot(knobs: Mapping[str, Mapping[str, Any]]) -> str:
    """Success over every knob of a stress test as an `<svg>` element."""
    with plots.styled():
        return plots.as_svg(overview_figure(knobs), "Success over every knob")


def overview_figure(knobs: Mapping[str, Mapping[str, Any]]) -> Figure:
    """Success over every knob of a stress test, a panel each.

    Args:
        knobs: Label and curves by name, as in `stress.json`; the same lines for all.
    """
    columns = min(len(knobs), KNOBS_IN_A_ROW)
    rows = -(-len(knobs) // columns)
    figure = Figure(figsize=(10.5, 0.4 + 2.3 * rows), layout="constrained")
    grid = figure.subplots(rows, columns, sharey=True, squeeze=False)
    panels = plots.used_panels(grid, len(knobs))
    for axes, entry in zip(panels, knobs.values(), strict=True):
        _draw_panel(axes, entry["curves"], "success")
        axes.set_title(textwrap.fill(entry["label"], 26), fontsize=9)
        axes.tick_params(labelsize=8)
    for axes in grid[:, 0]:
        axes.set_ylabel(_with_unit("success"))
    figure.legend(
        *panels[0].get_legend_handles_labels(),
        loc="outside upper left",
        ncols=4,
        frameon=False,
        fontsize=8.5,
        labelcolor=plots.INK,
    )
    return figure


def line_colors(lines: Lines) -> dict[str, str]:
    """One color per line."""
    return dict(zip(lines, plots.ARM_COLORS * len(lines), strict=False))


def dose_plot(summary: Mapping[str, Any]) -> str:
    """Success over the forecasts' error: a panel per scenario, a dot per arm."""
    scenarios = plots.real_scenarios(summary)
    columns = min(len(scenarios), plots.PANELS_IN_A_ROW)
    rows = -(-len(scenarios) // columns)
    with plots.styled():
        figure = Figure(figsize=(10.5, 0.5 + 2.6 * rows))
        grid = figure.subplots(rows, columns, sharey=True, squeeze=False)
        panels = plots.used_panels(grid, len(scenarios))
        for axes, (scenario, group) in zip(panels, scenarios.items(), strict=True):
            _draw_dose(axes, summary, group)
            axes.set_title(plots.wrapped_name(scenario, 20))
            axes.set_xlabel("forecast FDE [m]")
        for axes in grid[:, 0]:
            axes.set_ylabel("success [%]")
        if len(_markers(_shown_arms(summary))) > 1:
            grid[0, 0].legend(frameon=False, fontsize=8.5, labelcolor=plots.INK)
        return plots.as_svg(figure, "Success over forecast error, per scenario")


def _draw_dose(axes: Axes, summary: Mapping[str, Any], group: Mapping[str, Any]) -> None:
    """One scenario's dots with their intervals, and a line for each policy without forecasts."""
    colors, shown = plots.arm_colors(summary), _shown_arms(summary)
    markers, named = _markers(shown), set[str]()
    for arm, about in summary["arms"].items():
        metrics = group["arms"][arm]["metrics"]
        success, error = metrics["success"], metrics["forecast_fde"]
        if about["forecaster"] == "none":
            axes.axhline(100 * success["mean"], color=colors[arm], linewidth=1, linestyle=":")
        if arm not in shown or error["mean"] is None:
            continue
        low, high = (100 * abs(success[end] - success["mean"]) for end in ("low", "high"))
        label = "" if about["policy"] in named else about["policy"]
        named.add(about["policy"])
        axes.errorbar(
            error["mean"],
            100 * success["mean"],
            yerr=[[low], [high]],
            fmt=markers[about["policy"]],
            color=colors[arm],
            elinewidth=1,
            label=label,
        )
    axes.set_ylim(-3, 103)
    axes.set_xlim(left=min(0.0, axes.get_xlim()[0]))


def _shown_arms(summary: Mapping[str, Any]) -> dict[str, Any]:
    """The arms with forecasts that reach farthest: errors of other horizons say something else."""
    arms = {arm: about for arm, about in summary["arms"].items() if about["forecaster"] != "none"}
    farthest = max(about["horizon"] for about in arms.values())
    return {arm: about for arm, about in arms.items() if about["horizon"] == farthest}


def _markers(arms: Mapping[str, Any]) -> dict[str, str]:
    """Markers by policy."""
    policies = dict.fromkeys(about["policy"] for about in arms.values())
    return dict(zip(policies, MARKERS * len(policies), strict=False))


def _place(value: Any, values: Sequence[Any]) -> float:
    return float(value) if is_number(value) else float(values.index(value))


def _draw_panel(axes: Axes, lines: Lines, key: str) -> None:
    """One metric over the values: numbers at their places, what is no number one by one."""
    values = [point["value"] for point in max(lines.values(), key=len)]
    colors = line_colors(lines)
    for line, points in lines.items():
        places = [_place(point["value"], values) for point in points]
        _draw_line(axes, points, places, key, color=colors[line], label=line)
    if not is_number(values[0]):
        names = [textwrap.fill(value_text(value).replace("_", " "), 10) for value in values]
        axes.set_xticks(range(len(values)), names)
    elif values[0] > values[-1]:
        axes.invert_xaxis()


def _with_unit(key: str) -> str:
    """What an axis says of a metric."""
    unit = "%" if METRICS[key].kind == "share" else METRICS[key].unit
    return f"{METRICS[key].label} [{unit}]" if unit else METRICS[key].label


def _draw_line(
    axes: Axes,
    points: Sequence[Mapping[str, Any]],
    places: Sequence[float],
    key: str,
    *,
    color: str,
    label: str,
) -> None:
    """Means with their intervals as a band, where the metric is known."""
    factor = 100.0 if METRICS[key].kind == "share" else 1.0
    entries = [
        (place, point["metrics"][aggregate_name(key)])
        for place, point in zip(places, points, strict=True)
    ]
    known = [(place, entry) for place, entry in entries if entry["low"] is not None]
    at = [place for place, _ in known]
    mean, low, high = (
        [factor * entry[end] for _, entry in known] for end in ("mean", "low", "high")
    )
    axes.plot(at, mean, "o-", color=color, label=label)
    axes.fill_between(at, low, high, color=color, alpha=0.12, linewidth=0)
