"""Policies and forecasters compared in scenarios, every arm on the same seeds.

One row per episode is the primary result; means, intervals and differences derive from the rows.
"""

import dataclasses
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

from crowdsim.recordings.store import write_atomic
from crowdsim.scenarios import make_scenario
from envs.config import CrowdNavConfig
from envs.evaluation.comparison import Arm, EvaluationConfig, ScenarioChoice
from envs.evaluation.curves import setting_curves
from envs.evaluation.dose_response import rank_correlation
from envs.evaluation.episode_rows import Measured, Row, rows_as_parquet
from envs.evaluation.findings import findings
from envs.evaluation.finished_tasks import FinishedTasks
from envs.evaluation.forecast_breakdown import forecast_breakdown
from envs.evaluation.forecast_cells import CELL_COLUMNS, forecast_cells
from envs.evaluation.metrics import DELAY_AHEAD, navigation_metrics
from envs.evaluation.replays import RecordedEpisode, instructive_seeds
from envs.evaluation.runs import run_episodes
from envs.evaluation.summary import as_json, summarize
from envs.evaluation.twin import run_twin
from envs.evaluation.workers import run_tasks
from envs.forecasters import make_world_forecaster
from envs.policies import make_policy
from predictor.checkpoint import source_revision

Progress = Callable[[int, int], None]


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """What came out.

    Attributes:
        config: What was asked.
        rows: One per episode: scenario, arm, policy, forecaster, seed and all metrics; ordered by
            scenario, arm and seed.
        cells: Forecast errors of every episode by bin and step, as `forecast_cells` gives them,
            ordered likewise.
        summary: `run` (command, machine, …), `config`, `findings`, `dose_response` (rank
            correlation of forecast error and outcomes), `forecast_errors` (by step, distance and
            history), `settings` (curves over what was varied, `setting_curves`), and what
            `summarize` gives; fits into JSON.
        recorded: A few instructive episodes, of every arm from the same seed.
    """

    config: EvaluationConfig
    rows: list[Row]
    cells: list[Row]
    summary: dict[str, Any]
    recorded: list[RecordedEpisode]


@dataclass(frozen=True, kw_only=True)
class Task:
    """What one worker does at a time: some episodes of one arm in one scenario."""

    environment: CrowdNavConfig
    scenario: str
    place: str
    arm: str
    policy: str
    seeds: tuple[int, ...]
    width: int
    twins: bool = False


def evaluate(
    config: EvaluationConfig,
    *,
    progress: Progress | None = None,
    command: str = "",
    finished: FinishedTasks | None = None,
) -> Evaluation:
    """Runs all episodes, measures them and compares the arms.

    Args:
        config: What is compared.
        progress: Called with the number of finished episodes and of all.
        command: How this was called, for the record.
        finished: What an interrupted evaluation has left, and where this one keeps its own; None
            keeps nothing.

    Raises:
        ValueError: A bad name or value anywhere in `config`, before any episode is run.
    """
    started = time.perf_counter()
    _check_names(config)
    measured, order = _run(config, progress, finished), _ordering(config)
    rows = sorted((row for part in measured for row in part.rows), key=order)
    cells = sorted((cell for part in measured for cell in part.cells), key=order)
    summary: dict[str, Any] = {
        "run": _run_facts(config, command, time.perf_counter() - started),
        "config": dataclasses.asdict(config),
        **summarize(rows, reference=config.reference_arm, seed=config.statistics_seed),
        "dose_response": _dose_response(rows, config.statistics_seed),
        "forecast_errors": forecast_breakdown(cells, config.statistics_seed),
        "settings": setting_curves(rows, config.statistics_seed),
    }
    summary["findings"] = findings(summary)
    return Evaluation(
        config=config,
        rows=rows,
        cells=cells,
        summary=summary,
        recorded=_replays(config, rows),
    )


def measure_episodes(
    job: tuple[Task, FinishedTasks | None], finished_one: Callable[[], None]
) -> Measured:
    """Runs and measures the episodes of one task; calls `finished_one` after each."""
    task, finished = job
    kept = None if finished is None else finished.measured(task)
    if kept is not None:
        for _ in kept.rows:
            finished_one()
        return kept
    measured = Measured(rows=[], cells=[])
    for seed, trace in run_episodes(
        task.environment, task.policy, task.seeds, task.width, branched=task.twins
    ):
        has_twin = trace.scenario.replay is None and not trace.mission
        twin = run_twin(trace, longer=DELAY_AHEAD) if has_twin else None
        about = _about(task, seed)
        measured.rows.append({**about, **navigation_metrics(trace, twin)})
        measured.cells.extend(forecast_cells(trace, about))
        finished_one()
    if finished is not None:
        finished.keep(task, measured)
    return measured


def _about(task: Task, seed: int) -> Row:
    """The columns that tell an episode from all others."""
    environment = task.environment
    return {
        "scenario": task.scenario,
        "place": task.place,
        "model": str(environment.scenario_parameters.get("model", "")),
        "robot_visible": environment.robot_visible,
        "arm": task.arm,
        "policy": task.policy,
        "forecaster": str(environment.forecaster),
        "horizon": environment.horizon,
        "seed": seed,
    }


def record_episodes(task: Task, finished_one: Callable[[], None]) -> list[RecordedEpisode]:
    """Runs the episodes of one task once more, and keeps them whole."""
    recorded = [
        RecordedEpisode(scenario=task.scenario, arm=task.arm, seed=seed, trace=trace)
        for seed, trace in run_episodes(task.environment, task.policy, task.seeds, task.width)
    ]
    return sorted(recorded, key=lambda episode: episode.seed)


def _run(
    config: EvaluationConfig, progress: Progress | None, finished: FinishedTasks | None
) -> list[Measured]:
    """What the tasks measured, in the order in which they were given out."""
    tasks = _tasks(config)
    total = sum(len(task.seeds) for task in tasks)
    return run_tasks(
        measure_episodes,
        [(task, finished) for task in tasks],
        workers=config.workers,
        progress=None if progress is None else lambda done: progress(done, total),
    )


def _replays(config: EvaluationConfig, rows: Sequence[Row]) -> list[RecordedEpisode]:
    """A few instructive episodes of every scenario, all arms from the same seeds, in order."""
    wanted = []
    for choice in config.scenarios:
        own = [row for row in rows if row["scenario"] == choice.name]
        seeds = instructive_seeds(own, config.seeds[: config.replay_candidates], config.replays)
        wanted += [(choice, arm, seed) for seed in seeds for arm in config.arms]
    return record(config, wanted)


def record(
    config: EvaluationConfig, wanted: Sequence[tuple[ScenarioChoice, Arm, int]]
) -> list[RecordedEpisode]:
    """Runs some episodes once more, each of a scenario, arm and seed, and keeps them whole."""
    tasks = [_task(config, arm, choice, (seed,)) for choice, arm, seed in wanted]
    recorded = run_tasks(record_episodes, tasks, workers=config.workers) if tasks else []
    return [episode for episodes in recorded for episode in episodes]


def write_evaluation(evaluation: Evaluation, folder: Path) -> None:
    """Writes `episodes.parquet`, `forecast_errors.parquet` and `summary.json`, each whole."""
    folder.mkdir(parents=True, exist_ok=True)
    rows, cells = evaluation.rows, evaluation.cells
    write_atomic(folder / "episodes.parquet", rows_as_parquet(rows, list(rows[0])))
    write_atomic(folder / "forecast_errors.parquet", rows_as_parquet(cells, CELL_COLUMNS))
    text = json.dumps(evaluation.summary, indent=2, allow_nan=False) + "\n"
    write_atomic(folder / "summary.json", text.encode())


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
        _task(config, arm, choice, config.seeds[first : first + size])
        for choice in config.scenarios
        for arm in config.arms
        for first in range(0, len(config.seeds), size)
    ]
    # The dearest go first, so that no worker starts one when the others are done.
    return sorted(tasks, key=lambda task: _CHEAPNESS.get(str(task.environment.forecaster), 0))


def _task(
    config: EvaluationConfig, arm: Arm, choice: ScenarioChoice, seeds: tuple[int, ...]
) -> Task:
    return Task(
        environment=config.environment_of(arm, choice),
        scenario=choice.name,
        place=choice.place,
        arm=arm.name,
        policy=arm.policy,
        seeds=seeds,
        width=config.width,
        twins=config.twins,
    )


def _dose_response(rows: Sequence[Row], seed: int) -> dict[str, dict[str, Any]]:
    """Rank correlation of the forecasts' error with each of the outcomes that matter most."""
    return {
        outcome: as_json(rank_correlation(rows, outcome, np.random.default_rng(seed)))
        for outcome in ("success", "collision_pedestrian", "time_to_goal_penalized")
    }


_STATED_PACKAGES = ("torch", "numpy", "pymunk", "gymnasium")
_CHEAPNESS = {"constant_velocity": 1, "none": 2}


def _ordering(config: EvaluationConfig) -> Callable[[Row], tuple[int, int, Any]]:
    """Order of rows: scenarios and arms as configured, then seeds."""
    scenarios = {choice.name: index for index, choice in enumerate(config.scenarios)}
    arms = {arm.name: index for index, arm in enumerate(config.arms)}
    return lambda row: (scenarios[str(row["scenario"])], arms[str(row["arm"])], row["seed"])


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
