"""Plots of how far forecasters are off: over the horizon, and in which direction at its end."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from predictor.trajectory_errors import TrajectoryErrors

COLORS: Final = (
    "#7f8a99",
    "#2f6fb3",
    "#e08a1e",
    "#1a9850",
    "#8e44ad",
    "#c2476b",
    "#3aa6a6",
    "#8c6d46",
)
"""Of the columns in their order; the first is constant velocity's."""

INK: Final = "#16181d"
"""Of what is no column's."""

REGIONS: Final = (0.5, 0.9)
"""Shares of the trajectories that end within the contours."""

SHOWN: Final = 0.985
"""Share of the trajectories of the worst column that the plots must reach."""

CELL: Final = 0.05
"""Of the histograms [m]."""
BLUR: Final = 0.2
"""Standard deviation of what the histograms are smoothed with [m]."""

STYLE: Final[dict[Any, Any]] = {
    "font.family": "sans-serif",
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10,
    "axes.grid": True,
    "grid.alpha": 0.2,
    "legend.frameon": False,
    "legend.fontsize": 9,
}


def error_by_step(table: Mapping[str, Any]) -> bytes:
    """Plot the mean error at each step, and as a share of constant velocity's.

    Args:
        table: As `predictor.comparison.Comparison.table`.

    Returns:
        PNG. Bands are the standard deviation over seeds.
    """
    columns, protocol = table["columns"], table["protocol"]
    baseline = np.array(next(iter(columns.values()))["mean"]["error_per_step"])
    seconds = protocol["frame_dt"] * np.arange(1, len(baseline) + 1)
    with styled():
        figure = Figure(figsize=(9.0, 3.6), layout="constrained")
        left, right = figure.subplots(1, 2)
        for color, (name, column) in zip(_colors(columns), columns.items(), strict=True):
            curves = _of_seeds(column)
            _draw_curve(left, seconds, curves, color, name)
            _draw_curve(right, seconds, 100.0 * curves / baseline, color, name)
        left.set(xlabel="time ahead [s]", ylabel=f"mean error [{protocol['unit']}]", ylim=(0, None))
        right.set(xlabel="time ahead [s]", ylabel="share of constant velocity's [%]")
        left.set_title(f"{protocol['data']}, mean of folds", loc="left")
        left.legend(loc="upper left")
        return png(figure)


def final_errors(columns: Mapping[str, Mapping[str, TrajectoryErrors]]) -> bytes:
    """Plot where moving agents are forecast to be at the last step, seen from where they are.

    After the paper's figures: a density over the agent frame for each forecaster, with contours
    that hold a share of the trajectories, and the density along each of its axes.

    Args:
        columns: As `predictor.comparison.Comparison.errors`.

    Returns:
        PNG. The trajectories of all folds count alike.
    """
    offsets = {name: _final_offsets(folds.values()) for name, folds in columns.items()}
    reach = max(np.quantile(np.abs(offset).max(axis=1), SHOWN) for offset in offsets.values())
    edges = np.arange(-np.ceil(reach / CELL), np.ceil(reach / CELL) + 1) * CELL
    colors = dict(zip(offsets, _colors(offsets), strict=True))
    with styled():
        figure = Figure(figsize=(3.1 * max(len(offsets), 2), 6.3), layout="constrained")
        grid = figure.add_gridspec(2, 2 * len(offsets), height_ratios=(1.35, 1.0))
        for index, (name, offset) in enumerate(offsets.items()):
            axes = figure.add_subplot(grid[0, 2 * index : 2 * index + 2])
            _draw_density(axes, offset, edges, colors[name])
            axes.set_title(f"{name}\nn = {len(offset)} moving", loc="left")
        for axis, direction in enumerate(("ahead", "to the left")):
            half = slice(axis * len(offsets), (axis + 1) * len(offsets))
            axes = figure.add_subplot(grid[1, half])
            axes.set(xlabel=f"error {direction} [m]", ylabel="density [1/m]")
            for name, offset in offsets.items():
                _draw_marginal(axes, offset[:, axis], edges, colors[name], name)
        return png(figure)


def contour_level(density: NDArray[np.float64], share: float, count: int) -> float:
    """The density above which a share of `count` trajectories lies.

    Args:
        density: Trajectories in each cell; some may lie off the grid.
        share: Of all trajectories.
        count: All trajectories.
    """
    highest = np.sort(density, axis=None)[::-1]
    inside = int(np.searchsorted(np.cumsum(highest), share * count))
    return float(highest[min(inside, len(highest) - 1)])


@contextmanager
def styled() -> Iterator[None]:
    """Plots inside this block look alike; nothing global changes."""
    with mpl.rc_context(STYLE):
        yield


def png(figure: Figure) -> bytes:
    """The figure as a PNG that is the same for the same figure."""
    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=120, metadata={"Software": None})
    return buffer.getvalue()


def _colors(columns: Mapping[str, Any]) -> list[str]:
    return [COLORS[index % len(COLORS)] for index in range(len(columns))]


def _of_seeds(column: Mapping[str, Any]) -> NDArray[np.float64]:
    """(S, F) mean error at each step of each seed."""
    of_seeds = column["by_seed"].values() if "by_seed" in column else [column]
    return np.array([one["mean"]["error_per_step"] for one in of_seeds])


def _draw_curve(
    axes: Axes, seconds: NDArray[np.float64], curves: NDArray[np.float64], color: str, name: str
) -> None:
    mean = curves.mean(axis=0)
    axes.plot(seconds, mean, color=color, linewidth=2.0, label=name)
    if len(curves) > 1:
        spread = curves.std(axis=0, ddof=1)
        axes.fill_between(
            seconds, mean - spread, mean + spread, color=color, alpha=0.2, linewidth=0
        )


def _final_offsets(folds: Iterable[TrajectoryErrors]) -> NDArray[np.float64]:
    """(M, 2) of the moving agents of all folds; who stands looks nowhere."""
    return np.concatenate([errors.final_offset[errors.moving] for errors in folds])


def _draw_density(
    axes: Axes, offset: NDArray[np.float64], edges: NDArray[np.float64], color: str
) -> None:
    counts, _, _ = np.histogram2d(offset[:, 0], offset[:, 1], bins=(edges, edges))
    density = gaussian_filter(counts, BLUR / CELL)
    middles = 0.5 * (edges[1:] + edges[:-1])
    shades = LinearSegmentedColormap.from_list("shades", ["#ffffff", color])
    span = (edges[0], edges[-1], edges[0], edges[-1])
    # the root keeps the thin outer parts visible
    axes.imshow(np.sqrt(density.T), origin="lower", extent=span, cmap=shades)
    levels = [contour_level(density, share, len(offset)) for share in sorted(REGIONS, reverse=True)]
    drawn = axes.contour(middles, middles, density.T, levels=levels, colors=INK, linewidths=1.0)
    shares = [f"{share:.0%}" for share in sorted(REGIONS, reverse=True)]
    axes.clabel(drawn, fmt=dict(zip(levels, shares, strict=True)), fontsize=8)
    axes.plot(0.0, 0.0, "+", color=INK, markersize=9)
    axes.set(xlabel="error ahead [m]", ylabel="error to the left [m]")


def _draw_marginal(
    axes: Axes, error: NDArray[np.float64], edges: NDArray[np.float64], color: str, name: str
) -> None:
    counts, _ = np.histogram(error, bins=edges)
    density = gaussian_filter1d(counts / (len(error) * CELL), BLUR / CELL)
    low, high = np.quantile(error, [0.05, 0.95])
    label = f"{name}: 90 % in [{low:.2f}, {high:.2f}] m"
    axes.plot(0.5 * (edges[1:] + edges[:-1]), density, color=color, linewidth=1.8, label=label)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22))
