"""A picture of where the network looked for one forecast."""

from io import BytesIO
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from predictor.explanation import VIEW_SIDE, Explanation
from predictor.inputs import AgentInputs

AGENT: Final = "#c2410c"
OTHERS: Final = "#1d4f91"
TRUTH: Final = "#16181d"
LINES: Final[dict[str, dict[str, Any]]] = {
    "forecast": {"color": AGENT, "linewidth": 2.6},
    "without map": {"color": "#7c3aed", "linewidth": 1.6, "linestyle": "--"},
    "without neighbors": {"color": "#0f766e", "linewidth": 1.6, "linestyle": ":"},
}
HEAT: Final = LinearSegmentedColormap.from_list(
    "heat", [(0.99, 0.75, 0.1, 0.0), (0.98, 0.55, 0.1, 0.4), (0.86, 0.1, 0.1, 0.75)]
)
"""Transparent where less was looked than at an average place."""
THICKEST: Final = 14.0
"""Width of the track of a neighbor that has all the attention [points]."""


def attention_picture(explanation: Explanation) -> bytes:
    """Draw an explanation: PNG of the surroundings with attention, and its weights as bars.

    The picture is in the agent frame: the agent looks to the right.
    """
    figure = Figure(figsize=(12.0, 6.6), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(7.6, 4.0))
    axes = figure.add_subplot(grid[:, 0])
    _draw_ground(axes, explanation)
    _draw_people(axes, explanation)
    _draw_paths(axes, explanation)
    _frame(axes)
    _draw_history_bars(figure.add_subplot(grid[0, 1]), explanation)
    _draw_neighbor_bars(figure.add_subplot(grid[1, 1]), explanation)
    file = BytesIO()
    figure.savefig(file, format="png", dpi=110, metadata={"Software": None})
    return file.getvalue()


def _draw_ground(axes: Axes, explanation: Explanation) -> None:
    """The map, lightened, and on it the patches by how much more than average they were seen."""
    if explanation.view is not None:
        axes.imshow(explanation.view, extent=_extent(VIEW_SIDE), alpha=0.55)
    ground, side = explanation.attended.ground, explanation.crop_side
    if ground is None or side is None:
        return
    relative = ground[0] * ground[0].size
    top = max(2.0, float(relative.max()))
    heat = axes.imshow(relative, extent=_extent(side), cmap=HEAT, vmin=1.0, vmax=top)
    left, right, bottom, height = _extent(side)
    axes.plot(
        [left, right, right, left, left],
        [bottom, bottom, height, height, bottom],
        color="#475569",
        linewidth=0.8,
    )
    bar = axes.figure.colorbar(heat, ax=axes, shrink=0.5, pad=0.02)
    bar.set_label("attention to a patch of the map, 1 is the average")


def _extent(side: float) -> tuple[float, float, float, float]:
    """Left, right, bottom and top [m] of a crop: the agent is at a quarter of its side."""
    return -0.25 * side, 0.75 * side, -0.5 * side, 0.5 * side


def _draw_people(axes: Axes, explanation: Explanation) -> None:
    """Neighbors as wide as the attention to them, own frames as large as that to each."""
    inputs, looked = explanation.inputs, explanation.attended
    for number, weight in enumerate(looked.neighbors[0]):
        seen = inputs.neighbors_valid[0, number]
        if seen.any():
            track = inputs.neighbors[0, number][seen]
            width = 0.8 + THICKEST * float(weight)
            axes.plot(*track.T, color=OTHERS, linewidth=width, alpha=0.75, solid_capstyle="round")
            axes.plot(*track[-1], "o", color=OTHERS, markersize=6 + 0.6 * width, alpha=0.9)
            axes.annotate(
                str(number + 1), track[-1], color="white", ha="center", va="center", fontsize=7
            )
    valid = inputs.history_valid[0]
    own = inputs.history[0][valid]
    axes.plot(*own.T, color=AGENT, linewidth=1.2)
    if looked.history is not None:
        x, y = own.T
        axes.scatter(x, y, s=20 + 500 * looked.history[0][valid], color=AGENT, alpha=0.55)
    axes.plot(0.0, 0.0, "o", color=AGENT, markersize=9, markeredgecolor="white")


def _draw_paths(axes: Axes, explanation: Explanation) -> None:
    """Forecasts, with all streams and without one, and what happened."""
    axes.plot(*_from_here(explanation.future), color=TRUTH, linewidth=1.6, label="what happened")
    for label, path in explanation.forecasts.items():
        off = np.linalg.norm(path[-1] - explanation.future[-1])
        axes.plot(*_from_here(path), label=f"{label}: off by {off:.1f} m", **LINES[label])
        axes.plot(*path[-1], "o", color=LINES[label]["color"], markersize=4)


def _from_here(path: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2, F + 1) points of a path that begins where the agent is."""
    return np.vstack([np.zeros(2), path]).T


def _frame(axes: Axes) -> None:
    left, right, bottom, top = _extent(VIEW_SIDE)
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    axes.set_xlabel("ahead of the agent [m]")
    axes.set_ylabel("to its left [m]")
    axes.legend(loc="upper right", framealpha=0.9, fontsize=9)


def _draw_history_bars(axes: Axes, explanation: Explanation) -> None:
    weights, valid = explanation.attended.history, explanation.inputs.history_valid[0]
    axes.set_title("own history", loc="left", fontsize=11)
    if weights is None:
        axes.text(0.5, 0.5, "read whole, without attention", ha="center")
        return
    frames = np.arange(1 - len(valid), 1)
    axes.bar(frames, weights[0], color=AGENT, alpha=0.8)
    axes.axhline(1.0 / valid.sum(), color=TRUTH, linewidth=0.8, linestyle="--")
    axes.set_xlabel("frame, 0 is now")
    axes.set_ylabel("share of attention")


def _draw_neighbor_bars(axes: Axes, explanation: Explanation) -> None:
    weights, inputs = explanation.attended.neighbors[0], explanation.inputs
    there = inputs.neighbors_valid[0].any(axis=1)
    axes.set_title("neighbors", loc="left", fontsize=11)
    names = _distances(inputs, there)
    axes.bar(np.arange(len(names)), weights[there], color=OTHERS, alpha=0.85)
    axes.set_xticks(np.arange(len(names)), names, fontsize=8)
    if there.any():
        axes.axhline(1.0 / there.sum(), color=TRUTH, linewidth=0.8, linestyle="--")
    axes.set_xlabel("number and distance; dashed: equal shares")
    axes.set_ylabel("share of attention")


def _distances(inputs: AgentInputs, there: NDArray[np.bool_]) -> list[str]:
    """Numbers of the neighbors that are there, each with its distance."""
    away = np.linalg.norm(inputs.neighbors[0, :, -1], axis=-1)
    return [f"{number + 1}\n{away[number]:.1f} m" for number in np.flatnonzero(there)]
