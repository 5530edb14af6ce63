"""Policies and forecasters compared in scenarios, every arm on the same seeds.

One row per episode is the primary result; means, intervals and differences derive from the rows.
"""

import dataclasses
import io
import json
import os
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from crowdsim.recordings.store import write_atomic
from crowdsim.scenarios import make_scenario
from envs.comparison import EvaluationConfig
from envs.config import CrowdNavConfig
from envs.findings import findings
from envs.forecasters import make_world_forecaster
from envs.metric_table import METRICS
from envs.metrics import DELAY_AHEAD, Value, navigation_metrics
from envs.policies import make_policy
from envs.runs import run_episodes
from envs.summary import summarize
from envs.trace import Trace
from envs.twin import run_twin
from envs.workers import run_tasks
from predictor.checkpoint import source_revision

Row = dict[str, Value]
Progress = Callable[[int, int], None]


@dataclass(frozen=True, kw_only=True)
class RecordedEpisode:
    """An episode kept whole.

    Attributes:
        scenario: Name of the scenario.
        arm: Name of the arm.
        seed: Seed of the episode.
        trace: What happened.
    """

    scenario: str
    arm: str
    seed: int
    trace: Trace


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """What came out.

    Attributes:
        config: What was asked.
        rows: One per episode: scenario, arm, policy, forecaster, seed and all metrics; ordered by
            scenario, arm and seed.
        summary: `run` (command, machine, …), `config`, `findings`, and what
            `envs.summary.summarize` gives; fits into JSON.
        recorded: A few instructive episodes, of every arm from the same seed.
    """

    config: EvaluationConfig
    rows: list[Row]
    summary: dict[str, Any]
    recorded: list[RecordedEpisode]


@dataclass(frozen=True, kw_only=True)
class Task:
    """What one worker does at a time: some episodes of one arm in one scenario."""

    environment: CrowdNavConfig
    scenario: str
    arm: str
    policy: str
    seeds: tuple[int, ...]
    recorded_seeds: tuple[int, ...]
    width: int


def evaluate(
    config: EvaluationConfig, *, progress: Progress | None = None, command: str = ""
) -> Evaluation:
    """Runs all episodes, measures them and compares the arms.

    Args:
        config: What is compared.
        progress: Called with the number of finished episodes and of all.
        command: How this was called, for the record.

    Raises:
        ValueError: A bad name or value anywhere in `config`, before any episode is run.
    """
    started = time.perf_counter()
    _check_names(config)
    tasks = _tasks(config)
    total = sum(len(task.seeds) for task in tasks)
    outcomes = run_tasks(
        measure_episodes,
        tasks,
        workers=config.workers,
        progress=None if progress is None else lambda done: progress(done, total),
    )
    rows = sorted((row for rows, _ in outcomes for row in rows), key=_ordering(config))
    candidates = [episode for _, episodes in outcomes for episode in episodes]
    summary: dict[str, Any] = {
        "run": _run_facts(config, command, time.perf_counter() - started),
        "config": dataclasses.asdict(config),
        **summarize(rows, reference=config.reference_arm, seed=config.statistics_seed),
    }
    summary["findings"] = findings(summary)
    return Evaluation(
        config=config,
        rows=rows,
        summary=summary,
        recorded=choose_replays(candidates, rows, config),
    )


def measure_episodes(
    task: Task, finished: Callable[[], None]
) -> tuple[list[Row], list[RecordedEpisode]]:
    """Runs and measures the episodes of one task; calls `finished` after each."""
    rows, recorded = [], []
    for seed, trace in run_episodes(task.environment, task.policy, task.seeds, task.width):
        reacts = trace.scenario.replay is None
        twin = run_twin(trace, longer=DELAY_AHEAD) if reacts else None
        rows.append(
            {
                "scenario": task.scenario,
                "arm": task.arm,
                "policy": task.policy,
                "forecaster": task.environment.forecaster,
                "horizon": task.environment.horizon,
                "seed": seed,
                **navigation_metrics(trace, twin),
            }
        )
        if seed in task.recorded_seeds:
            recorded.append(
                RecordedEpisode(scenario=task.scenario, arm=task.arm, seed=seed, trace=trace)
            )
        finished()
    return rows, recorded


def choose_replays(
    candidates: Sequence[RecordedEpisode], rows: Sequence[Row], config: EvaluationConfig
) -> list[RecordedEpisode]:
    """Keeps, per scenario, the seeds whose arms ended most differently, for all arms.

    A seed that one arm fails and another masters says more than one that all master.
    """
    names = [choice.name for choice in config.scenarios]
    arms = [arm.name for arm in config.arms]
    chosen: set[tuple[str, int]] = set()
    for scenario in names:
        seeds = sorted({episode.seed for episode in candidates if episode.scenario == scenario})
        outcomes = {
            seed: {
                _outcome(row) for row in rows if (row["scenario"], row["seed"]) == (scenario, seed)
            }
            for seed in seeds
        }
        by_variety = sorted(seeds, key=lambda seed: -len(outcomes[seed]))
        chosen |= {(scenario, seed) for seed in by_variety[: config.replays]}
    kept = [episode for episode in candidates if (episode.scenario, episode.seed) in chosen]
    return sorted(
        kept, key=lambda item: (names.index(item.scenario), item.seed, arms.index(item.arm))
    )


def write_evaluation(evaluation: Evaluation, folder: Path) -> None:
    """Writes `episodes.parquet` and `summary.json`, each whole or not at all."""
    folder.mkdir(parents=True, exist_ok=True)
    write_atomic(folder / "episodes.parquet", rows_as_parquet(evaluation.rows))
    text = json.dumps(evaluation.summary, indent=2, allow_nan=False) + "\n"
    write_atomic(folder / "summary.json", text.encode())


def rows_as_parquet(rows: Sequence[Row]) -> bytes:
    """The rows as the content of a Parquet file, one column per key; missing numbers are null."""
    columns = {
        key: pa.array([row[key] for row in rows], type=_column_type(key), from_pandas=True)
        for key in rows[0]
    }
    sink = io.BytesIO()
    pq.write_table(pa.table(columns), sink, compression="zstd")
    return sink.getvalue()


def _column_type(key: str) -> pa.DataType:
    """Type of a column; the same whatever its rows hold."""
    if key in ("scenario", "arm", "policy", "forecaster", "collision_role"):
        return pa.string()
    if key in ("seed", "forecast_count"):
        return pa.int64()
    is_share = key in METRICS and METRICS[key].kind == "share"
    return pa.bool_() if is_share else pa.float64()


def _check_names(config: EvaluationConfig) -> None:
    """Makes every scenario, policy and forecaster once, so that a bad name fails at once."""
    for choice in config.scenarios:
        make_scenario(choice.scenario, np.random.default_rng(0), **choice.parameters)
    for arm in config.arms:
        environment = config.environment_of(arm, config.scenarios[0])
        make_policy(arm.policy, environment)
        make_world_forecaster(environment)


def _tasks(config: EvaluationConfig) -> list[Task]:
    """All episodes, in pieces that keep every worker busy to the end."""
    episodes = len(config.scenarios) * len(config.arms) * len(config.seeds)
    size = max(config.width, min(len(config.seeds), episodes // (8 * config.workers)))
    tasks = [
        Task(
            environment=config.environment_of(arm, choice),
            scenario=choice.name,
            arm=arm.name,
            policy=arm.policy,
            seeds=config.seeds[first : first + size],
            recorded_seeds=config.seeds[: config.replay_candidates],
            width=config.width,
        )
        for choice in config.scenarios
        for arm in config.arms
        for first in range(0, len(config.seeds), size)
    ]
    # The dearest go first, so that no worker starts one when the others are done.
    return sorted(tasks, key=lambda task: _CHEAPNESS.get(task.environment.forecaster, 0))


_STATED_PACKAGES = ("torch", "numpy", "pymunk", "gymnasium")
_CHEAPNESS = {"constant_velocity": 1, "none": 2}


def _ordering(config: EvaluationConfig) -> Callable[[Row], tuple[int, int, Any]]:
    """Order of rows: scenarios and arms as configured, then seeds."""
    scenarios = {choice.name: index for index, choice in enumerate(config.scenarios)}
    arms = {arm.name: index for index, arm in enumerate(config.arms)}
    return lambda row: (scenarios[str(row["scenario"])], arms[str(row["arm"])], row["seed"])


def _outcome(row: Row) -> str:
    """How an episode ended, as one word."""
    outcomes = ("success", "collision_pedestrian", "collision_wall", "timeout")
    return next(name for name in outcomes if row[name])


def _run_facts(config: EvaluationConfig, command: str, seconds: float) -> dict[str, Any]:
    """Where, when and how this was run, under the terms that the report prints."""
    episodes = len(config.scenarios) * len(config.arms) * len(config.seeds)
    facts = {
        "episodes": episodes,
        "seeds per scenario": f"{len(config.seeds)} ({min(config.seeds)} to {max(config.seeds)})",
        "date": time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime()),
        "wall time": f"{seconds:.0f} s with {config.workers} worker(s)",
        "revision": source_revision()[:12],
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, {platform.system()}",
        "versions": ", ".join(f"{name} {version(name)}" for name in _STATED_PACKAGES),
    }
    return {"command": command, **facts} if command else facts
