"""What changes with one setting, everything else the same: means, and changes paired by episode."""

from collections.abc import Mapping, Sequence
from typing import Any

from envs.evaluation.comparison import Arm
from envs.evaluation.episode_rows import Row
from envs.evaluation.metric_table import HEADLINE
from envs.evaluation.metrics import Value
from envs.evaluation.summary import differences, means

Lines = dict[str, dict[Any, list[Row]]]
"""Episodes by line and value."""


def setting_curves(rows: Sequence[Row], seed: int = 0) -> dict[str, dict[str, Any]]:
    """Curves over every setting that has several values.

    Args:
        rows: One per episode.
        seed: Seeds the bootstrap of every interval anew.

    Returns:
        `{setting: {line: curve}}`, see `curve`, over all scenarios together. A line over `horizon`
        is a policy with a forecaster, its first point at 0 the policy without forecasts, and
        changes are to the point before; a line over another setting is an arm, and changes are to
        the first value.
    """
    lines: dict[str, Lines] = {"horizon": _by_horizon(rows)}
    lines |= {setting: _by_value(rows, setting) for setting in ("robot_visible", "model")}
    return {
        setting: {
            line: curve(points, seed=seed, stepwise=setting == "horizon")
            for line, points in found.items()
            if len(points) > 1 and _paired(points, setting)
        }
        for setting, found in lines.items()
    }


def curve(
    points: Mapping[Any, Sequence[Row]], *, seed: int, stepwise: bool = False
) -> list[dict[str, Any]]:
    """Means at every value of a setting, and what each value changes.

    Args:
        points: Episodes by value; those of all values start alike, in the same order.
        seed: Seeds the bootstrap of every interval anew.
        stepwise: Whether changes are to the value before, else to the first.

    Returns:
        Per value `{"value", "n", "metrics": {metric: {"mean", …}}, "change": {metric: {"mean", …,
        "verdict"}}}` for the `HEADLINE` metrics; the first changes nothing and has `{}`.
    """
    values = list(points)
    entries = []
    for index, value in enumerate(values):
        entry = {
            "value": value,
            "n": len(points[value]),
            "metrics": means(points[value], HEADLINE, seed),
            "change": {},
        }
        if index > 0:
            other = points[values[index - 1 if stepwise else 0]]
            entry["change"] = differences(points[value], other, HEADLINE, seed)
        entries.append(entry)
    return entries


def _by_value(rows: Sequence[Row], setting: str) -> Lines:
    """Episodes by arm and value, each list in the order in which they are paired."""
    found: Lines = {}
    for row in rows:
        found.setdefault(str(row["arm"]), {}).setdefault(row[setting], []).append(row)
    return {
        arm: {value: _ordered(own, setting) for value, own in points.items()}
        for arm, points in found.items()
    }


def _by_horizon(rows: Sequence[Row]) -> Lines:
    """Episodes by policy with forecaster, and by horizon from short to long."""
    blind: dict[Value, list[Row]] = {}
    found: dict[tuple[Value, Value], dict[float, list[Row]]] = {}
    for row in rows:
        if row["forecaster"] == "none":
            blind.setdefault(row["policy"], []).append(row)
        else:
            points = found.setdefault((row["policy"], row["forecaster"]), {})
            points.setdefault(float(str(row["horizon"])), []).append(row)
    return {
        Arm(policy=str(policy), forecaster=str(forecaster)).name: {
            horizon: _ordered(own, "horizon")
            for horizon, own in [(0.0, blind.get(policy, [])), *sorted(points.items())]
            if own
        }
        for (policy, forecaster), points in found.items()
        if len(points) > 1
    }


def _ordered(rows: Sequence[Row], setting: str) -> list[Row]:
    """Episodes in the order of what they have in common with those at other values."""
    return sorted(rows, key=lambda row: _common(row, setting))


def _common(row: Row, setting: str) -> tuple[str, ...]:
    """What an episode has in common with those at other values of a setting."""
    keys = [key for key in ("place", "model", "robot_visible", "seed") if key != setting]
    return tuple(str(row[key]) for key in keys)


def _paired(points: Mapping[Any, Sequence[Row]], setting: str) -> bool:
    """Whether the same episodes were run at every value."""
    return len({tuple(_common(row, setting) for row in rows) for rows in points.values()}) == 1
