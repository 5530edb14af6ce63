"""Where longer forecasts stop helping: one planner, one scenario, horizons by forecasters.

Everything but the forecaster and how far it looks is fixed, and every arm runs the same seeds.
"""

import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from crowdsim.recordings.store import write_atomic
from envs.comparison import Arm, EvaluationConfig, ScenarioChoice
from envs.episode_rows import Row, rows_as_parquet
from envs.evaluation import Progress, evaluate
from envs.findings import number, share
from envs.finished_tasks import FinishedTasks
from envs.metric_table import METRICS, aggregate_name

HORIZONS = (0.4, 1.2, 2.4, 4.8, 7.2, 9.6)
SHOWN = ("success", "collision_pedestrian", "time_to_goal_penalized", "forecast_fde")
COLORS = ("#2f6fb3", "#8e44ad", "#e08a1e", "#1a9850", "#c2476b")
WITHOUT = "without forecasts"


@dataclass(frozen=True, kw_only=True)
class StressConfig:
    """What is varied and what is kept.

    Attributes:
        forecasters: What `CrowdNavConfig.forecaster` takes, except `none`, which always runs too.
        horizons: How far forecasts reach [s].
        policy: The planner; it should plan as far ahead as the longest horizon.
        scenario: Where.
        seeds: One episode per seed, forecaster and horizon.
        environment: Keywords of `CrowdNavConfig` for all.
        workers: Processes.
        width: Episodes side by side in a process.

    Raises:
        ValueError: No forecaster or no horizon, or one twice.
    """

    forecasters: tuple[str, ...]
    scenario: ScenarioChoice
    seeds: tuple[int, ...]
    horizons: tuple[float, ...] = HORIZONS
    policy: str = "mppi@9.6"
    environment: Mapping[str, Any] = field(default_factory=dict)
    workers: int = 1
    width: int = 8

    def __post_init__(self) -> None:
        for name, values in (("forecasters", self.forecasters), ("horizons", self.horizons)):
            if not values or len(set(values)) < len(values):
                raise ValueError(f"{name}: expected at least one and each once, found {values}")
        if "none" in self.forecasters:
            raise ValueError("forecasters: expected names besides none, which always runs too")

    @property
    def arms(self) -> dict[str, tuple[str, float]]:
        """Forecaster and horizon of each arm with forecasts, by its name."""
        return {
            f"{Path(forecaster).name}@{horizon:g}s": (forecaster, horizon)
            for forecaster in self.forecasters
            for horizon in self.horizons
        }


@dataclass(frozen=True, kw_only=True)
class Stress:
    """What came out.

    Attributes:
        config: What was asked.
        rows: One per episode, as in `envs.evaluation.Evaluation`.
        table: `run`, `scenario`, `without` (metrics without forecasts) and `curves`:
            {forecaster: [{horizon, n, metrics, differences}]}; fits into JSON.
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
    """Runs every forecaster at every horizon, and the planner without forecasts.

    Args:
        config: What is varied.
        progress: Called with the number of finished episodes and of all.
        command: How this was called, for the record.
        finished: As `envs.evaluation.evaluate` takes it.

    Raises:
        ValueError: A bad name or value, before any episode is run.
    """
    arms = [Arm(policy=config.policy, title=WITHOUT)]
    arms += [
        Arm(policy=config.policy, forecaster=forecaster, settings={"horizon": horizon}, title=name)
        for name, (forecaster, horizon) in config.arms.items()
    ]
    evaluation = evaluate(
        EvaluationConfig(
            arms=tuple(arms),
            scenarios=(config.scenario,),
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
    group = evaluation.summary["scenarios"][config.scenario.name]
    curves: dict[str, list[dict[str, Any]]] = {}
    for name, (forecaster, horizon) in config.arms.items():
        point = {
            "horizon": horizon,
            **group["arms"][name],
            "differences": group["differences"][name],
        }
        curves.setdefault(Path(forecaster).name, []).append(point)
    table = {
        "run": evaluation.summary["run"],
        "policy": config.policy,
        "scenario": config.scenario.name,
        "without": group["arms"][WITHOUT],
        "curves": curves,
    }
    return Stress(config=config, rows=evaluation.rows, table=table)


def write_stress(result: Stress, folder: Path) -> None:
    """Writes `stress.json`, `stress.md`, `stress.svg`, `stress.png` and `episodes.parquet`."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(result.table, indent=2, allow_nan=False) + "\n"
    write_atomic(folder / "stress.json", text.encode())
    write_atomic(folder / "stress.md", (stress_table(result.table) + "\n").encode())
    write_atomic(folder / "episodes.parquet", rows_as_parquet(result.rows))
    figure = stress_figure(result.table)
    for suffix in ("svg", "png"):
        sink = io.BytesIO()
        figure.savefig(sink, format=suffix, dpi=160)
        write_atomic(folder / f"stress.{suffix}", sink.getvalue())


def stress_table(table: Mapping[str, Any]) -> str:
    """The curves as a Markdown table; brackets hold 95 % intervals."""
    head = ["forecaster", "horizon [s]", "n", *(METRICS[key].label for key in SHOWN)]
    lines = [head, ["---"] * len(head), ["none", "–", *_cells(table["without"])]]
    for forecaster, points in table["curves"].items():
        lines += [[forecaster, f"{point['horizon']:g}", *_cells(point)] for point in points]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def stress_figure(table: Mapping[str, Any]) -> Figure:
    """One panel per metric: a line with its interval per forecaster over the horizon."""
    figure = Figure(figsize=(10.5, 6.2), layout="constrained")
    panels = figure.subplots(2, 2).ravel()
    for axes, key in zip(panels, SHOWN, strict=True):
        factor, unit = (100.0, "%") if METRICS[key].kind == "share" else (1.0, METRICS[key].unit)
        base = table["without"]["metrics"][aggregate_name(key)]
        if base["mean"] is not None:
            axes.axhline(factor * base["mean"], color="#7f8a99", linestyle="--", label=WITHOUT)
        for (name, points), color in zip(table["curves"].items(), COLORS * 9, strict=False):
            horizons, means, low, high = _curve(points, aggregate_name(key), factor)
            axes.plot(horizons, means, "o-", color=color, label=name)
            axes.fill_between(horizons, low, high, color=color, alpha=0.15, linewidth=0)
        axes.set_title(f"{METRICS[key].label} [{unit}]", loc="left", fontsize=10.5)
        axes.set_xlabel("forecast horizon [s]")
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(alpha=0.2)
    panels[0].legend(frameon=False)
    figure.suptitle(
        f"{table['policy']} in {table['scenario']}, n = {table['without']['n']} per point, "
        "bands are 95 % intervals",
        fontsize=11,
    )
    return figure


def _curve(
    points: Sequence[Mapping[str, Any]], name: str, factor: float
) -> tuple[list[float], list[float], list[float], list[float]]:
    """Horizons, means and interval ends of the points where the metric is known."""
    known = [point for point in points if point["metrics"][name]["low"] is not None]
    entries = [point["metrics"][name] for point in known]
    horizons = [float(point["horizon"]) for point in known]
    means, low, high = (
        [factor * entry[end] for entry in entries] for end in ("mean", "low", "high")
    )
    return horizons, means, low, high


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
