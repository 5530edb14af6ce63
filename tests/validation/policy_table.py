"""The bundled policies beside a planner, from an evaluation's rows: a table and its JSON.

Three policies, from three training seeds, count as one: each metric is their mean in an episode,
and the interval is over the episodes, which all arms share.

python tests/validation/policy_table.py docs/results/policies.json runs/policies/episodes.parquet
"""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq

from envs.statistics import Interval, mean_interval, paired_difference

METRICS = (
    "success",
    "collision_pedestrian",
    "collision_wall",
    "timeout",
    "time_to_goal_penalized",
    "intrusion_ratio@4.8",
)
RESAMPLES = 2000
REFERENCE = "none"

Key = tuple[str, str, str]
"""Scenario, policy (of any training seed), forecaster."""


def values(rows: list[dict[str, Any]], metric: str) -> dict[Key, np.ndarray]:
    """By arm the metric (training seeds, episodes), both in ascending order."""
    found: dict[Key, dict[str, dict[int, float]]] = {}
    for row in rows:
        policy, _, seed = row["policy"].partition("@")
        arm = found.setdefault((row["scenario"], policy, row["forecaster"]), {})
        arm.setdefault(seed, {})[row["seed"]] = float(row[metric])
    return {
        key: np.array([[at[seed] for seed in sorted(at)] for _, at in sorted(arm.items())])
        for key, arm in found.items()
    }


def entry(rows: list[dict[str, Any]], metric: str, key: Key) -> dict[str, Any]:
    """One metric of one arm: per training seed, over all, and against the arm without forecasts."""
    arms = values(rows, metric)
    scenario, policy, forecaster = key
    mean, reference = arms[key].mean(axis=0), arms[scenario, policy, REFERENCE].mean(axis=0)
    rng = np.random.default_rng(0)
    if len(arms[key]) == 1 and set(mean) <= {0.0, 1.0}:
        mean, reference = mean > 0.5, reference > 0.5
    found = {
        "by_training_seed": [round(float(one), 4) for one in arms[key].mean(axis=1)],
        "mean": as_json(mean_interval(mean, rng, resamples=RESAMPLES)),
    }
    if forecaster != REFERENCE:
        change = paired_difference(mean, reference, rng, resamples=RESAMPLES)
        found["change_by_forecast"] = as_json(change)
    return found


def as_json(interval: Interval) -> dict[str, float | int]:
    """The interval, rounded."""
    return {name: round(value, 4) for name, value in vars(interval).items()}


def line(key: Key, metrics: dict[str, Any]) -> str:
    """A row of the table."""
    seeds = " / ".join(f"{one:.2f}" for one in metrics["success"]["by_training_seed"])
    cells = [*key, seeds]
    for metric in ("success", "collision_pedestrian", "time_to_goal_penalized"):
        cells.append(interval_text(metrics[metric]["mean"]))
    change = metrics["success"].get("change_by_forecast")
    cells.append("" if change is None else interval_text(change, sign="+"))
    return "| " + " | ".join(cells) + " |"


def interval_text(interval: dict[str, float], sign: str = "") -> str:
    """Mean and interval, as the tables of the documentation write them."""
    mean, low, high = (f"{interval[name]:{sign}.2f}" for name in ("mean", "low", "high"))
    return f"{mean} [{low}, {high}]"


def main(out: Path, *episodes: Path) -> None:
    """Print the table and write all of it, of one or several files of episodes."""
    rows = [row for path in episodes for row in pq.read_table(path).to_pylist()]
    found: dict[str, Any] = {}
    for key in values(rows, METRICS[0]):
        metrics = {metric: entry(rows, metric, key) for metric in METRICS}
        found["/".join(key)] = metrics
        sys.stdout.write(line(key, metrics) + "\n")
    out.write_text(json.dumps(found, indent=1, allow_nan=False) + "\n")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
