"""Closed-loop forecast errors by step, distance and history: means with intervals.

A mean is over all forecasts of an arm in a scenario, so that an episode with many counts for more
than one with few. Its interval resamples whole episodes, since forecasts of one are alike.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envs.evaluation.forecast_cells import DISTANCES, FRAMES_SEEN
from envs.evaluation.metrics import Value
from envs.evaluation.statistics import Interval
from envs.evaluation.summary import ALL_SCENARIOS, as_json

Cell = Mapping[str, Value]
Floats = NDArray[np.float64]

PARTS = {
    "error": "twin_error_sum",
    "model_error": "model_error_sum",
    "caused": "caused_sum",
    "displacement": "displacement_sum",
    "standing_displacement": "standing_displacement_sum",
}
"""What forecast errors are split into, and the sums of each."""


def forecast_breakdown(cells: Sequence[Cell], seed: int = 0) -> dict[str, Any]:
    """Means per scenario and arm, those without forecasts left out.

    Args:
        cells: Rows of `envs.evaluation.forecast_cells.forecast_cells`, of all episodes.
        seed: Seeds the bootstrap of every interval anew.

    Returns:
        `{scenario: {arm: {"episodes", "by_step": [{"seconds", "error", "coverage", "nll"}],
        "by_distance": {bin: {"ade", "fde", "coverage", "nll"}}, "by_frames_seen": likewise}}}`,
        each number as `{"mean", "low", "high", "n"}` with `n` forecasts; a bin that holds none is
        left out, and a mean of none (`nll` of who states no radius) is None. The scenario `all`
        pools the others. With twins each arm also has `robot_part`, per step the `error` of the
        forecasts that were split, their `model_error`, `displacement` and `standing_displacement`,
        and `caused`, the error less the model's; without, it is empty.
    """
    groups: dict[str, dict[str, list[Cell]]] = {}
    for cell in cells:
        groups.setdefault(str(cell["scenario"]), {}).setdefault(str(cell["arm"]), []).append(cell)
    if len(groups) > 1:
        pooled = groups.setdefault(ALL_SCENARIOS, {})
        for cell in cells:
            pooled.setdefault(str(cell["arm"]), []).append(cell)
    return {
        scenario: {arm: _of_arm(own, seed) for arm, own in arms.items()}
        for scenario, arms in groups.items()
    }


def mean_of_sums(
    sums: Floats, counts: Floats, rng: np.random.Generator, *, resamples: int = 1000
) -> Interval:
    """Mean over all, from the sums of every episode, with a 95 % percentile bootstrap interval.

    Args:
        sums: (E,) per episode.
        counts: (E,) how many values each sums up.
        rng: Draws the episodes.
        resamples: How often.

    Returns:
        The mean; `n` counts values. No interval from a single episode.
    """
    total = counts.sum()
    if total == 0:
        return Interval(mean=np.nan, low=np.nan, high=np.nan, n=0)
    mean, low, high = float(sums.sum() / total), np.nan, np.nan
    if len(sums) > 1:
        drawn = rng.integers(len(sums), size=(resamples, len(sums)))
        drawn_sums, drawn_counts = sums[drawn].sum(axis=1), counts[drawn].sum(axis=1)
        known = drawn_counts > 0
        low, high = np.quantile(drawn_sums[known] / drawn_counts[known], (0.025, 0.975))
    return Interval(mean=mean, low=float(low), high=float(high), n=int(total))


def _of_arm(cells: Sequence[Cell], seed: int) -> dict[str, Any]:
    """One arm's entry in one scenario."""
    episodes = list(dict.fromkeys((cell["scenario"], cell["seed"]) for cell in cells))
    table = _Table(cells, episodes, seed)
    steps = sorted({float(str(cell["seconds"])) for cell in cells})
    return {
        "episodes": len(episodes),
        "by_step": [
            {
                "seconds": seconds,
                "error": table.mean("error_sum", {"seconds": seconds}),
                "coverage": table.mean("within_radius", {"seconds": seconds}),
                "nll": table.mean("nll_sum", {"seconds": seconds}, "nll_n"),
            }
            for seconds in steps
        ],
        "robot_part": table.robot_part(steps),
        "by_distance": table.by("distance", DISTANCES, steps[-1]),
        "by_frames_seen": table.by("frames_seen", FRAMES_SEEN, steps[-1]),
    }


class _Table:
    """The cells of one arm, to be added up by episode."""

    def __init__(self, cells: Sequence[Cell], episodes: Sequence[tuple[Value, Value]], seed: int):
        place = {episode: index for index, episode in enumerate(episodes)}
        self._episode = np.array([place[cell["scenario"], cell["seed"]] for cell in cells])
        self._columns = {key: np.array([cell[key] for cell in cells]) for key in cells[0]}
        columns = self._columns
        columns["caused_sum"] = columns["twin_error_sum"] - columns["model_error_sum"]
        self._episodes, self._seed = len(episodes), seed

    def mean(self, sums: str, where: Mapping[str, Value], count: str = "n") -> dict[str, Any]:
        """Mean over the cells that have those values, of what the column `count` counts."""
        chosen = np.ones(len(self._episode), dtype=np.bool_)
        for key, value in where.items():
            chosen &= self._columns[key] == value
        totals, counts = self._per_episode(sums, chosen), self._per_episode(count, chosen)
        return as_json(mean_of_sums(totals, counts, np.random.default_rng(self._seed)))

    def robot_part(self, steps: Sequence[float]) -> list[dict[str, Any]]:
        """Means of the error's parts per step; nothing where there were no twins."""
        if not self._columns["twin_n"].any():
            return []
        return [
            {
                "seconds": seconds,
                **{
                    name: self.mean(sums, {"seconds": seconds}, "twin_n")
                    for name, sums in PARTS.items()
                },
            }
            for seconds in steps
        ]

    def by(self, column: str, bins: Sequence[str], last: float) -> dict[str, Any]:
        """Means per bin of a column; `last` are the seconds of the last step."""
        return {
            name: {
                "ade": self.mean("error_sum", {column: name}),
                "fde": self.mean("error_sum", {column: name, "seconds": last}),
                "coverage": self.mean("within_radius", {column: name}),
                "nll": self.mean("nll_sum", {column: name}, "nll_n"),
            }
            for name in bins
            if (self._columns[column] == name).any()
        }

    def _per_episode(self, key: str, chosen: NDArray[np.bool_]) -> Floats:
        """(E,) sum of a column over the chosen cells of each episode."""
        values = self._columns[key][chosen].astype(np.float64)
        sums = np.zeros(self._episodes)
        np.add.at(sums, self._episode[chosen], values)
        return sums
