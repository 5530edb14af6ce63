"""`crowdnav stress`: where policies and forecasts break."""

from pathlib import Path
from typing import Any

from jsonargparse.typing import NonNegativeInt, PositiveInt

from scripts.options import Names, Seeds
from scripts.output import require_file, require_folder, write_json


def stress(
    knob: Names = Names("horizon"),
    values: list[bool | int | float | str] | None = None,
    policies: Names = Names("mppi@9.6"),
    forecasters: Names = Names("none,constant_velocity,fast"),
    scenario: str = "circular_crossing",
    scenario_parameters: dict[str, Any] | None = None,
    seeds: Seeds = Seeds(20),
    environment: dict[str, Any] | None = None,
    workers: PositiveInt = 1,
    resume: bool = False,
    out: Path = Path("runs/stress"),
    json: Path | None = None,
    seed: NonNegativeInt = 0,
) -> None:
    """Turn one knob from usual to hard, with everything else fixed and on common seeds.

    Writes `report.html` (curves, tables, and failures to replay; opens offline), `stress.json`,
    `stress.md`, each knob's curves as `.svg` and `.png`, the success over several knobs as
    `overview`, `episodes.parquet` with one row per episode and `forecast_errors.parquet`. The
    first policy with the first forecaster is the reference that the differences in `stress.json`
    are taken against.

    Args:
        knob: What to turn, each by itself: horizon, density, crowd_speed, awareness, goal_changes,
            sudden_stops, motion_model, missed_detections, position_noise, track_losses, occlusion,
            field_of_view, history, frame_jitter, mission or map.
        values: Where to turn a single knob to, such as [0.4,4.8]; the usual values if not given.
        policies: As `crowdnav evaluate` takes them; `mppi@SECONDS` plans that far ahead whatever
            the horizon of the forecasts, and looks at none of what they say beyond.
        forecasters: As `crowdnav evaluate` takes them.
        scenario: Name of the scenario.
        scenario_parameters: Its keywords, such as {"pedestrians": 40}.
        seeds: Number of episodes of each arm at each value, or their seeds.
        environment: Keywords of the environment for all, such as {"robot": "holonomic"}.
        workers: Processes, one thread each; no result depends on their number.
        resume: Go on where an interrupted run with the same options stopped.
        out: Folder of the results.
        json: File for a copy of `stress.json`.
        seed: Added to every episode's seed.
    """
    require_folder(out)
    require_file(json)
    from envs.evaluation.comparison import ScenarioChoice
    from envs.evaluation.stress import StressConfig
    from envs.evaluation.stress import stress as run
    from envs.report import build_stress_report, write_stress
    from envs.report.stress_files import stress_table
    from scripts.interruption import kept_tasks
    from scripts.progress import episodes_bar

    config = StressConfig(
        knobs=knob,
        values=() if values is None else tuple(values),
        policies=policies,
        forecasters=forecasters,
        scenario=ScenarioChoice(
            scenario=scenario,
            parameters={} if scenario_parameters is None else scenario_parameters,
        ),
        seeds=tuple(seed + each for each in seeds),
        environment={} if environment is None else environment,
        workers=workers,
    )
    command = f"crowdnav stress --config {out}/config.yaml"
    with kept_tasks(out, resume) as finished, episodes_bar() as progress:
        found = run(config, progress=progress, command=command, finished=finished)
        write_stress(found, out)
    build_stress_report(found, out / "report.html")
    write_json(json, found.table)
    print(stress_table(found.table))
    print(f"Report in {out / 'report.html'}, this table in {out / 'stress.md'}")
