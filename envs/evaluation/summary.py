"""From one row per episode to means, intervals and paired differences per scenario and arm."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envs.evaluation.metric_table import HEADLINE, METRICS, aggregate_name
from envs.evaluation.metrics import Value
from envs.evaluation.statistics import Interval, mean_interval, paired_difference

Row = Mapping[str, Value]
ALL_SCENARIOS = "all"
"""Name under which the episodes of all scenarios are pooled."""


def summarize(rows: Sequence[Row], *, reference: str, seed: int = 0) -> dict[str, Any]:
    """Aggregates episodes per scenario and arm, and compares every arm with the reference.

    Args:
        rows: One per episode, with `scenario`, `arm`, `policy`, `forecaster`, `horizon`, `seed` and
            the columns of `METRICS`. Every arm has the same seeds in a scenario.
        reference: Arm that the paired differences are taken against.
        seed: Seeds the bootstrap of every interval anew, so that none depends on what else is
            measured.

    Returns:
        `{"reference": …, "arms": {arm: {"policy", "forecaster", "horizon"}}, "scenarios":
        {scenario: {"arms": {arm: {"n": …, "metrics": {metric: {"mean", "low", "high", "n"}}}},
        "differences": {arm: {metric: {…, "verdict"}}}, "without_forecasts": likewise, "between":
        {arm: {earlier arm: {metric: …}}}}}}`. `differences` are to the reference. The others are of
        `HEADLINE` metrics: `without_forecasts` to the same policy without forecasts, `between`
        to other forecasters of the same policy and horizon. The scenario `all` pools the others.
        Unknown numbers are None.

    Raises:
        ValueError: Where the reference is not among the arms, or the arms' seeds differ.
    """
    arms = _unique(row["arm"] for row in rows)
    if reference not in arms:
        raise ValueError(f"reference: expected one of {', '.join(arms)}, found {reference!r}")
    scenarios = _unique(row["scenario"] for row in rows)
    groups = {name: [row for row in rows if row["scenario"] == name] for name in scenarios}
    if len(scenarios) > 1:
        groups[ALL_SCENARIOS] = list(rows)
    of_arm = {str(row["arm"]): {key: row[key] for key in _ARM} for row in rows}
    return {
        "reference": reference,
        "arms": {arm: of_arm[arm] for arm in arms},
        "scenarios": {
            name: _summarize_group(group, of_arm, reference, seed) for name, group in groups.items()
        },
    }


def verdict(difference: Interval, better: str) -> str:
    """`better`, `worse` or, where no direction is good, `different`; else `inconclusive`.

    Args:
        difference: Paired difference to the reference.
        better: The metric's better direction.
    """
    if not difference.excludes_zero:
        return "inconclusive"
    if better == "neither":
        return "different"
    return "better" if (difference.mean > 0) == (better == "higher") else "worse"


_ARM = ("policy", "forecaster", "horizon")
"""Columns that describe an arm."""


def _summarize_group(
    rows: Sequence[Row], arms: Mapping[str, Row], reference: str, seed: int
) -> dict[str, Any]:
    """One scenario's entry of the summary."""
    of_arm = {arm: _ordered(rows, arm) for arm in arms}
    for arm in arms:
        _check_paired(arm, of_arm[arm], reference, of_arm[reference])
    headline = {
        arm: {
            other: differences(of_arm[arm], of_arm[other], HEADLINE, seed)
            for other in _comparable(arm, arms)
        }
        for arm in arms
        if arms[arm]["forecaster"] != "none"
    }
    blind = {arm: name for arm in headline for name in headline[arm] if _is_blind(arms[name])}
    return {
        "arms": {
            arm: {"n": len(own), "metrics": means(own, METRICS, seed)}
            for arm, own in of_arm.items()
        },
        "differences": {
            arm: differences(own, of_arm[reference], METRICS, seed)
            for arm, own in of_arm.items()
            if arm != reference
        },
        "without_forecasts": {arm: headline[arm][name] for arm, name in blind.items()},
        "between": {
            arm: {name: entry for name, entry in others.items() if not _is_blind(arms[name])}
            for arm, others in headline.items()
        },
    }


def _is_blind(arm: Row) -> bool:
    """Whether it is shown no forecasts."""
    return arm["forecaster"] == "none"


def _comparable(arm: str, arms: Mapping[str, Row]) -> list[str]:
    """The arm's policy without forecasts, and with earlier forecasters of the same horizon."""
    names = [name for name in arms if arms[name]["policy"] == arms[arm]["policy"]]
    earlier = names[: names.index(arm)]
    return [name for name in names if _is_blind(arms[name])] + [
        name
        for name in earlier
        if not _is_blind(arms[name]) and arms[name]["horizon"] == arms[arm]["horizon"]
    ]


def means(rows: Sequence[Row], keys: Iterable[str], seed: int) -> dict[str, Any]:
    """Means of some metrics with their intervals, by the names of the aggregates."""
    return {
        aggregate_name(key): as_json(mean_interval(column(rows, key), np.random.default_rng(seed)))
        for key in keys
    }


def differences(
    rows: Sequence[Row], others: Sequence[Row], keys: Iterable[str], seed: int
) -> dict[str, Any]:
    """Paired differences of some metrics, with verdicts, between rows in the same order."""
    entries = {}
    for key in keys:
        rng = np.random.default_rng(seed)
        difference = paired_difference(column(rows, key), column(others, key), rng)
        entries[aggregate_name(key)] = {
            **as_json(difference),
            "verdict": verdict(difference, METRICS[key].better),
        }
    return entries


def column(rows: Sequence[Row], key: str) -> NDArray[Any]:
    """One metric of many episodes: bool for shares, else float with NaN for missing."""
    dtype = bool if METRICS[key].kind == "share" else np.float64
    return np.array([row[key] for row in rows], dtype=dtype)


def as_json(interval: Interval) -> dict[str, Any]:
    """The interval as plain numbers, unknown ones as None."""
    return {
        "mean": _known(interval.mean),
        "low": _known(interval.low),
        "high": _known(interval.high),
        "n": interval.n,
    }


def _known(value: float) -> float | None:
    """The value as a Python float, None for NaN."""
    return float(value) if math.isfinite(value) else None


def _ordered(rows: Sequence[Row], arm: str) -> list[Row]:
    """An arm's episodes, in the order in which arms are paired."""
    return sorted(
        (row for row in rows if row["arm"] == arm), key=lambda row: (row["scenario"], row["seed"])
    )


def _check_paired(arm: str, rows: Sequence[Row], reference: str, others: Sequence[Row]) -> None:
    """Refuses to compare arms that did not meet the same episodes."""
    ours = [(row["scenario"], row["seed"]) for row in rows]
    theirs = [(row["scenario"], row["seed"]) for row in others]
    if ours != theirs:
        raise ValueError(
            f"arms {arm} and {reference}: expected the same seeds per scenario, found "
            f"{sorted(set(ours) ^ set(theirs), key=str)[:4]} in only one of them"
        )


def _unique(values: Iterable[Value]) -> list[str]:
    """Distinct values in order of first appearance."""
    return list(dict.fromkeys(str(value) for value in values))
