"""Does a better forecast drive better? Rank correlation of forecast error and navigation.

Over the forecasters that one policy was shown in one scenario, best of all `oracle_noisy` at
several doses: whether the one that errs more also makes the robot fail more.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from envs.evaluation.episode_rows import Row
from envs.evaluation.metrics import Value
from envs.evaluation.statistics import Interval

Floats = NDArray[np.float64]

ERROR = "forecast_fde"
LEAST_FORECASTERS = 3
"""With fewer a rank correlation says nothing."""


def rank_correlation(
    rows: Sequence[Row],
    outcome: str,
    rng: np.random.Generator,
    *,
    confidence: float = 0.95,
    resamples: int = 2000,
) -> Interval:
    """Spearman's rho of the mean closed-loop FDE and a mean outcome over forecasters.

    One rho per policy, scenario and horizon with at least `LEAST_FORECASTERS` forecasters, averaged
    over those; the interval is a percentile bootstrap that resamples seeds, the same for all arms.

    Args:
        rows: One per episode.
        outcome: Name of a metric.
        rng: Draws the resamples.
        confidence: Coverage aimed at.
        resamples: Number of resamples.

    Returns:
        The correlation; `n` is the number of policies times scenarios times horizons. NaN where
        there is none.
    """
    tables = [
        (_by_seed(group, ERROR), _by_seed(group, outcome)) for group in _groups(rows).values()
    ]
    if not tables:
        return Interval(mean=np.nan, low=np.nan, high=np.nan, n=0)
    mean = _mean_rho(tables, [np.arange(errors.shape[1]) for errors, _ in tables])
    draws = []
    for _ in range(resamples):
        chosen = [np.array(rng.choice(errors.shape[1], errors.shape[1])) for errors, _ in tables]
        draws.append(_mean_rho(tables, chosen))
    known = np.array(draws)[np.isfinite(draws)]
    if not (np.isfinite(mean) and len(known)):
        return Interval(mean=np.nan, low=np.nan, high=np.nan, n=len(tables))
    low, high = np.quantile(known, (0.5 - confidence / 2, 0.5 + confidence / 2))
    return Interval(mean=mean, low=float(low), high=float(high), n=len(tables))


def _groups(rows: Sequence[Row]) -> Mapping[tuple[Value, ...], dict[str, list[Row]]]:
    """Rows by scenario, policy and horizon, and by arm, where enough forecasters were compared."""
    groups: dict[tuple[Value, ...], dict[str, list[Row]]] = {}
    for row in rows:
        if row["forecaster"] != "none":
            key = (row["scenario"], row["policy"], row["horizon"])
            group = groups.setdefault(key, {})
            group.setdefault(str(row["arm"]), []).append(row)
    return {key: arms for key, arms in groups.items() if len(arms) >= LEAST_FORECASTERS}


def _by_seed(arms: Mapping[str, Sequence[Row]], key: str) -> Floats:
    """(A, S) a metric of every arm and seed."""
    ordered = [sorted(rows, key=lambda row: str(row["seed"])) for rows in arms.values()]
    return np.array([[row[key] for row in rows] for rows in ordered], dtype=np.float64)


def _mean_rho(
    tables: Sequence[tuple[Floats, Floats]], chosen: Sequence[NDArray[np.int64]]
) -> float:
    """Mean rho of the tables for chosen seeds; NaN where no table has one."""
    found = []
    for (errors, outcomes), seeds in zip(tables, chosen, strict=True):
        error, outcome = _means(errors[:, seeds]), _means(outcomes[:, seeds])
        if np.isfinite(error).all() and np.ptp(error) > 0 and np.ptp(outcome) > 0:
            ranks = rankdata(error), rankdata(outcome)
            found.append(np.corrcoef(*ranks)[0, 1])
    return float(np.mean(found)) if found else np.nan


def _means(values: Floats) -> Floats:
    """(A,) mean over the seeds where it is known; NaN for an arm that has none."""
    known = np.isfinite(values)
    count = known.sum(axis=1)
    total = np.where(known, values, 0.0).sum(axis=1)
    mean: Floats = np.divide(total, count, out=np.full(len(values), np.nan), where=count > 0)
    return mean
