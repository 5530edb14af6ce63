"""Plots of an evaluation as inline SVG that follows the page's colors in light and dark."""

import io
import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from envs.evaluation.metric_table import HEADLINE, METRICS, aggregate_name
from envs.evaluation.summary import ALL_SCENARIOS

ARM_COLORS = (
    "#7f8a99",
    "#2f6fb3",
    "#e08a1e",
    "#8e44ad",
    "#1a9850",
    "#c2476b",
    "#3aa6a6",
    "#8c6d46",
)
OUTCOME_COLORS = {
    "success": "#1a9850",
    "collision_pedestrian": "#d6453d",
    "collision_wall": "#e08a1e",
    "timeout": "#9aa3af",
}
INK = "#010203"
"""Stands for the page's text color, which replaces it in the SVG."""

SHOWN = tuple(key for key in HEADLINE if key != "collision_pedestrian")
"""Columns with a panel of their own; collisions are in the plot of outcomes."""

REM_PER_INCH = (3.8, 7.2)
"""Least and greatest scale of a plot; a page too narrow for the least scrolls it."""

PANELS_IN_A_ROW = 5
"""More scenarios than these go below one another."""

STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.grid": True,
    "grid.alpha": 0.16,
    "grid.color": INK,
    **dict.fromkeys(
        ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color"), INK
    ),
}


def outcome_plot(summary: Mapping[str, Any]) -> str:
    """Stacked bars: how the episodes of each arm ended, one panel per scenario."""
    scenarios = real_scenarios(summary)
    arms = arms_of(summary)
    with styled():
        columns = min(len(scenarios), PANELS_IN_A_ROW)
        rows = -(-len(scenarios) // columns)
        figure = Figure(figsize=(10.5, rows * (0.75 + 0.3 * len(arms))))
        grid = figure.subplots(rows, columns, sharey=True, squeeze=False)
        panels = used_panels(grid, len(scenarios))
        for axes, (scenario, group) in zip(panels, scenarios.items(), strict=True):
            _draw_outcomes(axes, arms, group)
            axes.set_title(wrapped_name(scenario, 20))
        grid[0, 0].invert_yaxis()
        return as_svg(figure, "How the episodes ended, per scenario and arm")


def metric_plot(summary: Mapping[str, Any]) -> str:
    """Means with 95 % intervals, one panel per metric of `SHOWN`.

    Few arms stand side by side in each scenario; many get a line each, over all scenarios.
    """
    scenarios = real_scenarios(summary)
    arms = arms_of(summary)
    if len(arms) > len(ARM_COLORS):
        entries = {arm: pooled(summary)["arms"][arm]["metrics"] for arm in arms}
        title = "Means with 95 % intervals, over all scenarios"
        return _arm_plot(summary, entries, title, zero=False)
    known = [key for key in SHOWN if _is_known(scenarios, key)]
    rows = -(-len(known) // 3)
    with styled():
        figure = Figure(figsize=(10.5, 2.7 * rows))
        panels = used_panels(figure.subplots(rows, 3, squeeze=False), len(known))
        for axes, key in zip(panels, known, strict=True):
            _draw_metric(axes, scenarios, arms, key)
        return as_svg(figure, "Means with 95 % intervals, per metric, scenario and arm")


def difference_plot(summary: Mapping[str, Any]) -> str:
    """Paired differences to the reference with intervals, pooled over scenarios."""
    title = f"Paired differences to {summary['reference']}"
    return _arm_plot(summary, pooled(summary)["differences"], title, zero=True)


def pooled(summary: Mapping[str, Any]) -> Mapping[str, Any]:
    """The entry of all scenarios together, or of the only one."""
    scenarios = summary["scenarios"]
    name = ALL_SCENARIOS if ALL_SCENARIOS in scenarios else next(iter(scenarios))
    group: Mapping[str, Any] = scenarios[name]
    return group


def used_panels(grid: NDArray[Any], count: int) -> list[Axes]:
    """The first `count` panels of a grid, row by row; the others are hidden."""
    panels = list(grid.ravel())
    for axes in panels[count:]:
        axes.set_axis_off()
    return panels[:count]


def arms_of(summary: Mapping[str, Any]) -> list[str]:
    """Arms in the order of evaluation."""
    return list(next(iter(summary["scenarios"].values()))["arms"])


def arm_colors(summary: Mapping[str, Any]) -> dict[str, str]:
    """One color per arm, the same in every plot and table; many arms share their forecaster's."""
    arms = summary["arms"]
    names = [color_name(summary, arm) for arm in arms]
    places = {name: index for index, name in enumerate(dict.fromkeys(names))}
    return {
        arm: ARM_COLORS[places[name] % len(ARM_COLORS)]
        for arm, name in zip(arms, names, strict=True)
    }


def color_key(summary: Mapping[str, Any]) -> dict[str, str]:
    """Colors by what they stand for: arms, or forecasters where there are many arms."""
    return {color_name(summary, arm): color for arm, color in arm_colors(summary).items()}


def color_name(summary: Mapping[str, Any], arm: str) -> str:
    """What an arm's color stands for."""
    if len(summary["arms"]) <= len(ARM_COLORS):
        return arm
    return Path(str(summary["arms"][arm]["forecaster"])).name


def real_scenarios(summary: Mapping[str, Any]) -> dict[str, Any]:
    """The scenarios without the pooled one."""
    return {name: group for name, group in summary["scenarios"].items() if name != ALL_SCENARIOS}


@contextmanager
def styled() -> Iterator[None]:
    """Plots inside this block look like the page; nothing global changes."""
    with mpl.rc_context(STYLE):
        yield


def as_svg(figure: Figure, title: str) -> str:
    """The figure as an `<svg>` element in the page's text color, with a title for readers."""
    if figure.get_layout_engine() is None:
        figure.tight_layout(pad=0.6, w_pad=1.2, h_pad=1.2)
    buffer = io.StringIO()
    figure.savefig(
        buffer, format="svg", transparent=True, bbox_inches="tight", metadata={"Date": None}
    )
    svg = buffer.getvalue()
    svg = svg[svg.index("<svg") :].replace(INK, "currentColor")
    # Matplotlib numbers its ids from hashes that differ between runs unless salted; the page has
    # several figures, so each keeps its ids apart by its title.
    salt = re.sub(r"\W+", "-", title.lower())
    svg = re.sub(r'(id="|url\(#|href="#)', rf"\g<1>{salt}-", svg)
    svg = re.sub(
        r'<svg [^>]*?viewBox="([^"]*)"[^>]*>', r'<svg role="img" viewBox="\1">', svg, count=1
    )
    width = float(svg.split('viewBox="', 1)[1].split()[2]) / 72.0
    least, most = (scale * width for scale in REM_PER_INCH)
    sizes = f"min-width:{least:.0f}rem;max-width:{most:.0f}rem"
    svg = svg.replace("<svg ", f'<svg style="{sizes}" ', 1)
    return svg.replace(">", f"><title>{title}</title>", 1)


def _arm_plot(
    summary: Mapping[str, Any], entries: Mapping[str, Mapping[str, Any]], title: str, *, zero: bool
) -> str:
    """Arms as lines, metrics as panels; nothing where no metric has an interval."""
    known = [
        key
        for key in SHOWN
        if any(entry[aggregate_name(key)]["low"] is not None for entry in entries.values())
    ]
    if not known:
        return ""
    colors = arm_colors(summary)
    with styled():
        figure = Figure(figsize=(10.5, 0.9 + 0.3 * len(entries)))
        panels = figure.subplots(1, len(known), sharey=True, squeeze=False)[0]
        for axes, key in zip(panels, known, strict=True):
            factor = 100.0 if METRICS[key].kind == "share" else 1.0
            for row, (arm, entry) in enumerate(entries.items()):
                place = entry[aggregate_name(key)]
                _draw_interval(axes, place, row, colors[arm], factor, horizontal=True)
            if zero:
                axes.axvline(0, color=INK, linewidth=0.8, alpha=0.6)
            share = "points" if zero else "%"
            unit = share if METRICS[key].kind == "share" else METRICS[key].unit
            axes.set_title(_wrapped_label(key), fontsize=9.5)
            axes.set_xlabel(unit if unit else "difference" if zero else "")
            axes.set_yticks(range(len(entries)), list(entries))
            axes.margins(y=0.25 if len(entries) < PANELS_IN_A_ROW else 0.05)
        panels[0].invert_yaxis()
        return as_svg(figure, title)


def _draw_outcomes(axes: Axes, arms: Sequence[str], group: Mapping[str, Any]) -> None:
    """One panel of stacked bars."""
    left = np.zeros(len(arms))
    for outcome, color in OUTCOME_COLORS.items():
        shares = np.array([group["arms"][arm]["metrics"][outcome]["mean"] for arm in arms])
        axes.barh(arms, 100 * shares, left=left, color=color, height=0.68)
        left += 100 * shares
    axes.set_xlim(0, 100)
    axes.set_xticks([0, 50, 100], ["0", "50", "100 %"])
    axes.grid(axis="y", visible=False)


def _draw_metric(axes: Axes, scenarios: Mapping[str, Any], arms: Sequence[str], key: str) -> None:
    """One panel: a group of dots with intervals per scenario."""
    metric = METRICS[key]
    factor = 100.0 if metric.kind == "share" else 1.0
    offsets = np.linspace(-0.28, 0.28, len(arms)) if len(arms) > 1 else np.zeros(1)
    for column, group in enumerate(scenarios.values()):
        for arm, offset, color in zip(arms, offsets, ARM_COLORS * len(arms), strict=False):
            entry = group["arms"][arm]["metrics"][aggregate_name(key)]
            _draw_interval(axes, entry, column + offset, color, factor, horizontal=False)
    unit = "%" if metric.kind == "share" else metric.unit
    axes.set_title(f"{metric.label} [{unit}]" if unit else metric.label)
    axes.set_xticks(range(len(scenarios)), [wrapped_name(name, 10) for name in scenarios])
    axes.set_xlim(-0.5, len(scenarios) - 0.5)
    axes.grid(axis="x", visible=False)
    if metric.kind == "share":
        axes.set_ylim(-3, 103)


def _draw_interval(
    axes: Axes,
    entry: Mapping[str, Any],
    place: float,
    color: str,
    factor: float,
    *,
    horizontal: bool,
) -> None:
    """A dot with its interval, along x or y; nothing where the mean is unknown."""
    if entry["mean"] is None:
        return
    mean = factor * entry["mean"]
    low, high = (
        (mean, mean) if entry["low"] is None else (factor * entry["low"], factor * entry["high"])
    )
    span = ([low, high], [place, place]) if horizontal else ([place, place], [low, high])
    dot = (mean, place) if horizontal else (place, mean)
    axes.plot(*span, color=color, linewidth=2.2, solid_capstyle="round", alpha=0.75)
    axes.plot(*dot, "o", color=color, markersize=5.5)


def _is_known(scenarios: Mapping[str, Any], key: str) -> bool:
    """Whether any arm has the metric in any scenario."""
    return any(
        arm["metrics"][aggregate_name(key)]["mean"] is not None
        for group in scenarios.values()
        for arm in group["arms"].values()
    )


def wrapped_name(name: str, width: int) -> str:
    """A scenario's name in lines of at most about `width` letters, broken at its words."""
    return textwrap.fill(name.replace("_", " "), width, break_long_words=False)


def _wrapped_label(key: str) -> str:
    """A label in two lines."""
    return METRICS[key].label.replace(", ", ",\n").replace(" (", "\n(")
