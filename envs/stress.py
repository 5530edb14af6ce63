"""Where policies and forecasts break: one knob turned at a time, everything else fixed.

Every point of every curve runs the same seeds.
"""

import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from crowdsim.recordings.store import write_atomic
from envs.comparison import EvaluationConfig, ScenarioChoice, cross
from envs.episode_rows import Row, rows_as_parquet
from envs.evaluation import Progress, evaluate
from envs.findings import number, share
from envs.finished_tasks import FinishedTasks
from envs.knobs import KNOBS, Setting, is_number, turned
from envs.metric_table import METRICS, aggregate_name
from envs.report.plots import ARM_COLORS

SHOWN = ("success", "collision_pedestrian", "time_to_goal_penalized", "forecast_fde")


@dataclass(frozen=True, kw_only=True)
class StressConfig:
    """What is turned and what is kept.

    Attributes:
        knob: Name in `envs.knobs.KNOBS`.
        policies: What `envs.policies.make_policy` takes; for the knob `horizon` a planner should
            plan as far ahead as the longest one.
        forecasters: What `CrowdNavConfig.forecaster` takes.
        scenario: Where.
        seeds: One episode per seed, policy, forecaster and value.
        values: Where the knob is turned to; those of the knob if empty.
        environment: Keywords of `CrowdNavConfig` for all.
        workers: Processes.
        width: Episodes side by side in a process.

    Raises:
        ValueError: An unknown knob, or a value twice.
    """

    knob: str
    policies: tuple[str, ...]
    forecasters: tuple[str, ...]
    scenario: ScenarioChoice
    seeds: tuple[int, ...]
    values: tuple[Setting, ...] = ()
    environment: Mapping[str, Any] = field(default_factory=dict)
    workers: int = 1
    width: int = 8

    def __post_init__(self) -> None:
        if self.knob not in KNOBS:
            raise ValueError(f"knob must be one of {', '.join(KNOBS)}, got {self.knob!r}")
        if len(set(self.values)) < len(self.values):
            raise ValueError(f"values: expected each once, found {self.values}")

    @property
    def settings(self) -> tuple[Setting, ...]:
        """Where the knob is turned to."""
        return self.values if self.values else KNOBS[self.knob].values


@dataclass(frozen=True, kw_only=True)
class Stress:
    """What came out.

    Attributes:
        config: What was asked.
        rows: One per episode, as in `envs.evaluation.Evaluation`; the scenario is `knob=value`.
        table: `run`, `scenario`, `knob`, `label`, `reference` and `curves`:
            {arm: [{value, n, metrics, differences}]}; fits into JSON. Differences are to the
            reference, the first arm, at the same value.
    """

    config: StressConfig
    rows: list[Row]
    table: dict[str, Any]


def stress(
    config: StressConfig,
    *,
    progress: Progress | None = None,
    command: str = "",
    finished: FinishedTasks | None = None,
) -> Stress:
    """Runs every policy with every forecaster at every value of the knob.

    Args:
        config: What is turned.
        progress: Called with the number of finished episodes and of all.
        command: How this was called, for the record.
        finished: As `envs.evaluation.evaluate` takes it.

    Raises:
        ValueError: A bad name or value, before any episode is run.
    """
    points = {value: turned(config.scenario, config.knob, value) for value in config.settings}
    evaluation = evaluate(
        EvaluationConfig(
            arms=cross(config.policies, config.forecasters),
            scenarios=tuple(points.values()),
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
    scenarios = evaluation.summary["scenarios"]
    curves: dict[str, list[dict[str, Any]]] = {}
    for arm in evaluation.config.arms:
        for value, point in points.items():
            found = scenarios[point.name]
            differences = found["differences"].get(arm.name, {})
            entry = {"value": value, **found["arms"][arm.name], "differences": differences}
            curves.setdefault(arm.name, []).append(entry)
    table = {
        "run": evaluation.summary["run"],
        "scenario": config.scenario.name,
        "knob": config.knob,
        "label": KNOBS[config.knob].label,
        "reference": evaluation.config.reference_arm,
        "curves": curves,
    }
    return Stress(config=config, rows=evaluation.rows, table=table)


def write_stress(result: Stress, folder: Path) -> None:
    """Writes `stress.json`, `stress.md`, `stress.svg`, `stress.png` and `episodes.parquet`."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(result.table, indent=2, allow_nan=False) + "\n"
    write_atomic(folder / "stress.json", text.encode())
    write_atomic(folder / "stress.md", (stress_table(result.table) + "\n").encode())
    write_atomic(folder / "episodes.parquet", rows_as_parquet(result.rows, list(result.rows[0])))
    figure = stress_figure(result.table)
    for suffix in ("svg", "png"):
        sink = io.BytesIO()
        figure.savefig(sink, format=suffix, dpi=160)
        write_atomic(folder / f"stress.{suffix}", sink.getvalue())


def stress_table(table: Mapping[str, Any]) -> str:
    """The curves as a Markdown table; brackets hold 95 % intervals."""
    head = ["arm", table["label"], "n", *(METRICS[key].label for key in SHOWN)]
    lines = [head, ["---"] * len(head)]
    for arm, points in table["curves"].items():
        lines += [[arm, _text(point["value"]), *_cells(point)] for point in points]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def stress_figure(table: Mapping[str, Any]) -> Figure:
    """One panel per metric: a line with its interval for each arm over the knob's values."""
    figure = Figure(figsize=(10.5, 6.2), layout="constrained")
    panels = figure.subplots(2, 2).ravel()
    values = [point["value"] for point in next(iter(table["curves"].values()))]
    numeric = all(is_number(each) for each in values)
    places = values if numeric else list(range(len(values)))
    for axes, key in zip(panels, SHOWN, strict=True):
        factor, unit = (100.0, "%") if METRICS[key].kind == "share" else (1.0, METRICS[key].unit)
        for (arm, points), color in zip(table["curves"].items(), ARM_COLORS * 9, strict=False):
            known, means, low, high = _curve(points, places, aggregate_name(key), factor)
            axes.plot(known, means, "o-", color=color, label=arm)
            axes.fill_between(known, low, high, color=color, alpha=0.12, linewidth=0)
        axes.set_title(f"{METRICS[key].label} [{unit}]", loc="left", fontsize=10.5)
        axes.set_xlabel(table["label"])
        if not numeric:
            axes.set_xticks(places, [_text(value) for value in values])
        if numeric and values[0] > values[-1]:
            axes.invert_xaxis()
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(alpha=0.2)
    panels[0].legend(frameon=False, fontsize=8.5)
    count = next(iter(table["curves"].values()))[0]["n"]
    figure.suptitle(
        f"{table['scenario']}, n = {count} per point, bands are 95 % intervals", fontsize=11
    )
    return figure


def _curve(
    points: Sequence[Mapping[str, Any]], places: Sequence[float], name: str, factor: float
) -> tuple[list[float], list[float], list[float], list[float]]:
    """Places, means and interval ends of the points where the metric is known."""
    entries = [(place, point["metrics"][name]) for place, point in zip(places, points, strict=True)]
    known = [(place, entry) for place, entry in entries if entry["low"] is not None]
    means, low, high = (
        [factor * entry[end] for _, entry in known] for end in ("mean", "low", "high")
    )
    return [place for place, _ in known], means, low, high


def _text(value: Setting) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return value if isinstance(value, str) else f"{value:.4g}"


def _cells(arm: Mapping[str, Any]) -> list[str]:
    """Count and shown metrics of one line of the table."""
    cells = [str(arm["n"])]
    for key in SHOWN:
        entry = arm["metrics"][aggregate_name(key)]
        if entry["mean"] is None:
            cells.append("–")
        else:
            cells.append(
                share(entry) if METRICS[key].kind == "share" else number(entry, METRICS[key])
            )
    return cells
