"""Where policies and forecasts break: one knob turned at a time, everything else fixed.

Every point of every curve runs the same seeds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from envs.evaluation.comparison import EvaluationConfig, ScenarioChoice, cross
from envs.evaluation.curves import curve
from envs.evaluation.episode_rows import Row
from envs.evaluation.evaluate import Evaluation, Progress, evaluate, record
from envs.evaluation.finished_tasks import FinishedTasks
from envs.evaluation.knobs import KNOBS, Setting, turned, value_text
from envs.evaluation.metric_table import METRICS
from envs.evaluation.replays import RecordedEpisode, instructive_failure
from envs.evaluation.wording import difference_text, share

Points = Mapping[Setting, ScenarioChoice]


@dataclass(frozen=True, kw_only=True)
class StressConfig:
    """What is turned and what is kept.

    Attributes:
        knobs: Names in `envs.evaluation.knobs.KNOBS`, each turned by itself.
        policies: As `envs.evaluation.comparison.cross` takes them; for the knob `horizon` a planner
            should plan as far ahead as the longest one.
        forecasters: What `CrowdNavConfig.forecaster` takes.
        scenario: Where.
        seeds: One episode per seed, policy, forecaster and value.
        values: Where the only knob is turned to; those of each knob if empty.
        environment: Keywords of `CrowdNavConfig` for all.
        workers: Processes.
        width: Episodes side by side in a process.

    Raises:
        ValueError: An unknown knob, none, one twice, values for several, or a value twice.
    """

    knobs: tuple[str, ...]
    policies: tuple[str, ...]
    forecasters: tuple[str, ...]
    scenario: ScenarioChoice
    seeds: tuple[int, ...]
    values: tuple[Setting, ...] = ()
    environment: Mapping[str, Any] = field(default_factory=dict)
    workers: int = 1
    width: int = 8

    def __post_init__(self) -> None:
        for knob in self.knobs:
            if knob not in KNOBS:
                raise ValueError(f"knob must be one of {', '.join(KNOBS)}, got {knob!r}")
        for name, given in (("knobs", self.knobs), ("values", self.values)):
            if len(set(given)) < len(given):
                raise ValueError(f"{name}: expected each once, found {given}")
        if not self.knobs or (self.values and len(self.knobs) > 1):
            raise ValueError(f"values: expected with a single knob, found knobs {self.knobs}")

    def points(self, knob: str) -> dict[Setting, ScenarioChoice]:
        """The scenario at every value of a knob."""
        values = self.values if self.values else KNOBS[knob].values
        return {value: turned(self.scenario, knob, value) for value in values}


@dataclass(frozen=True, kw_only=True)
class Stress:
    """What came out.

    Attributes:
        config: What was asked.
        rows: One per episode, as in `Evaluation`; the scenario is `knob=value`.
        cells: Forecast errors of every episode, likewise.
        table: `run`, `scenario`, `reference` and `knobs`: {knob: {label, findings, curves: {arm:
            [{value, n, metrics, differences, change}]}}}; fits into JSON. `differences` are to the
            reference, the first arm, at the same value, `change` to the first value.
        recorded: Of every arm and knob one failure where it breaks, and beside it another arm that
            mastered the same, if there is one.
    """

    config: StressConfig
    rows: list[Row]
    cells: list[Row]
    table: dict[str, Any]
    recorded: list[RecordedEpisode]


def stress(
    config: StressConfig,
    *,
    progress: Progress | None = None,
    command: str = "",
    finished: FinishedTasks | None = None,
) -> Stress:
    """Runs every policy with every forecaster at every value of every knob.

    Args:
        config: What is turned.
        progress: Called with the number of finished episodes and of all.
        command: How this was called, for the record.
        finished: As `envs.evaluation.evaluate.evaluate` takes it.

    Raises:
        ValueError: A bad name or value, before any episode is run.
    """
    knobs = {knob: config.points(knob) for knob in config.knobs}
    evaluation = evaluate(
        EvaluationConfig(
            arms=cross(config.policies, config.forecasters),
            scenarios=tuple(point for points in knobs.values() for point in points.values()),
            seeds=config.seeds,
            environment=config.environment,
            workers=config.workers,
            width=config.width,
            replays=0,
            replay_candidates=0,
        ),
        progress=progress,
        command=command,
        finished=finished,
    )
    table = {
        "run": evaluation.summary["run"],
        "scenario": config.scenario.name,
        "reference": evaluation.config.reference_arm,
        "knobs": {knob: _knob_entry(evaluation, knob, points) for knob, points in knobs.items()},
    }
    return Stress(
        config=config,
        rows=evaluation.rows,
        cells=evaluation.cells,
        table=table,
        recorded=_failures(evaluation, list(knobs.values())),
    )


def _knob_entry(evaluation: Evaluation, knob: str, points: Points) -> dict[str, Any]:
    """One knob's part of the table."""
    scenarios = evaluation.summary["scenarios"]
    curves = {}
    for arm in evaluation.config.arms:
        changes = curve(_episodes(evaluation, arm.name, points), seed=0)
        curves[arm.name] = [
            {
                **entry,
                "metrics": scenarios[point.name]["arms"][arm.name]["metrics"],
                "differences": scenarios[point.name]["differences"].get(arm.name, {}),
            }
            for entry, point in zip(changes, points.values(), strict=True)
        ]
    found = [_sentence(arm, own) for arm, own in curves.items()]
    return {"label": KNOBS[knob].label, "findings": found, "curves": curves}


def _episodes(evaluation: Evaluation, arm: str, points: Points) -> dict[Setting, list[Row]]:
    """An arm's episodes at every value, by seed."""
    own: dict[str, list[Row]] = {point.name: [] for point in points.values()}
    for row in evaluation.rows:
        if row["arm"] == arm and row["scenario"] in own:
            own[str(row["scenario"])].append(row)
    return {value: own[point.name] for value, point in points.items()}


def _sentence(arm: str, points: Sequence[Mapping[str, Any]]) -> str:
    """Where an arm's success is surely another than at the first value."""
    first, last = points[0], points[-1]
    text = (
        f"{arm}: success {share(first['metrics']['success'])} at {value_text(first['value'])}, "
        f"{share(last['metrics']['success'])} at {value_text(last['value'])}"
    )
    changed = [
        f"{value_text(point['value'])} ({point['change']['success']['verdict']}, "
        f"{difference_text(point['change']['success'], METRICS['success'])})"
        for point in points[1:]
        if point["change"]["success"]["verdict"] != "inconclusive"
    ]
    told = "no value differs conclusively from the first"
    if changed:
        told = f"conclusively different from the first value at {', '.join(changed)}"
    return f"{text}; {told} (n = {first['n']} per value)."


def _failures(evaluation: Evaluation, knobs: Sequence[Points]) -> list[RecordedEpisode]:
    """Instructive failures of every arm, each beside an arm that mastered the same episode."""
    config = evaluation.config
    wanted: set[tuple[str, int, str]] = set()
    for points in knobs:
        for arm in config.arms:
            failed = instructive_failure(list(_episodes(evaluation, arm.name, points).values()))
            if failed is not None:
                episode = str(failed["scenario"]), int(str(failed["seed"]))
                beside = _masters(evaluation.rows, failed)[:1]
                wanted |= {(*episode, name) for name in (arm.name, *beside)}
    return record(
        config,
        [
            (choice, arm, seed)
            for choice in config.scenarios
            for seed in config.seeds
            for arm in config.arms
            if (choice.name, seed, arm.name) in wanted
        ],
    )


def _masters(rows: Sequence[Row], failed: Row) -> list[str]:
    """Arms that reached the goal where another failed."""
    return [
        str(row["arm"])
        for row in rows
        if row["success"] and all(row[key] == failed[key] for key in ("scenario", "seed"))
    ]
