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

from envs.evaluation.statistics import Interval, mean_interval, paired_difference

METRICS = (
    "success",
    "collision_pedestrian",
    "collision_wall",
    "timeout",
    "time_to_goal_penalized",
    "intrusion_ratio@4.8",
)
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


def entry(arms: dict[Key, np.ndarray], key: Key) -> dict[str, Any]:
    """One metric of one arm: per training seed, over all, and against other arms."""
    scenario, policy, forecaster = key
    against = {
        "against_none": (scenario, policy, "none"),
        "against_constant_velocity": (scenario, policy, "constant_velocity"),
        "against_mppi": (scenario, "mppi", forecaster),
    }
    found = {
        "by_training_seed": [round(float(one), 4) for one in arms[key].mean(axis=1)],
        "mean": as_json(mean_interval(per_episode(arms[key]), np.random.default_rng(0))),
    }
    for name, other in against.items():
        if other != key and other in arms:
            change = paired_difference(
                per_episode(arms[key]), per_episode(arms[other]), np.random.default_rng(0)
            )
            found[name] = as_json(change)
    return found


def per_episode(seeds: np.ndarray) -> np.ndarray:
    """Means over training seeds (episodes,); yes or no stays that where there is one alone."""
    mean = seeds.mean(axis=0)
    return mean > 0.5 if len(seeds) == 1 and set(mean) <= {0.0, 1.0} else mean


def as_json(interval: Interval) -> dict[str, float | int]:
    """The interval, rounded."""
    return {name: round(value, 4) for name, value in vars(interval).items()}


def line(key: Key, metrics: dict[str, Any]) -> str:
    """A row of the table."""
    seeds = " / ".join(f"{one:.2f}" for one in metrics["success"]["by_training_seed"])
    cells = [*key, seeds]
    for metric in ("success", "collision_pedestrian", "time_to_goal_penalized"):
        cells.append(interval_text(metrics[metric]["mean"]))
    change = metrics["success"].get("against_none")
    cells.append("" if change is None else interval_text(change, sign="+"))
    return "| " + " | ".join(cells) + " |"


def interval_text(interval: dict[str, float], sign: str = "") -> str:
    """Mean and interval, as the tables of the documentation write them."""
    mean, low, high = (f"{interval[name]:{sign}.2f}" for name in ("mean", "low", "high"))
    return f"{mean} [{low}, {high}]"


def main(out: Path, *episodes: Path) -> None:
    """Print the table and write all of it, of one or several files of episodes."""
    rows = [row for path in episodes for row in pq.read_table(path).to_pylist()]
    arms = {metric: values(rows, metric) for metric in METRICS}
    found: dict[str, Any] = {}
    for key in sorted(arms["success"]):
        metrics = {metric: entry(arms[metric], key) for metric in METRICS}
        found["/".join(key)] = metrics
        sys.stdout.write(line(key, metrics) + "\n")
    out.write_text(json.dumps(found, indent=1, allow_nan=False) + "\n")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
