"""`crowdnav evaluate`: policies and forecasters compared in scenarios, on common seeds."""

from pathlib import Path
from typing import Any

from jsonargparse.typing import NonNegativeInt, PositiveInt

from scripts.options import Names, Seeds
from scripts.output import require_file, require_folder, write_json


def evaluate(
    policies: Names = Names("straight,mppi"),
    forecasters: Names = Names("none,constant_velocity,fast"),
    scenarios: Names = Names("circular_crossing,narrow_doorway,urban_crossing"),
    horizons: list[float] | None = None,
    models: Names | None = None,
    robot_visible: list[bool] | None = None,
    seeds: Seeds = Seeds(20),
    environment: dict[str, Any] | None = None,
    reference: str = "",
    twins: bool = False,
    workers: PositiveInt = 1,
    resume: bool = False,
    out: Path = Path("runs/evaluate"),
    json: Path | None = None,
    seed: NonNegativeInt = 0,
) -> None:
    """Run every policy with every forecaster in every scenario and compare them on common seeds.

    Writes `report.html` (open it in a browser, no network needed), `episodes.parquet` with one row
    per episode, `forecast_errors.parquet` with forecast errors by distance, history and step, and
    `summary.json` with means, intervals and paired differences.

    Args:
        policies: `straight`, `social_force`, `orca`, `dwa`, `mppi`, `ppo`, or folders written by
            `crowdnav train-policy`; `orca:none` goes with that forecaster only.
        forecasters: `none`, `constant_velocity`, `constant_velocity_map`, `social_force`,
            `fast`, `iterative_attention`, checkpoints, `oracle`, or
            `oracle_noisy@sigma=METRES+delay=SECONDS+drop=SHARE`.
        scenarios: Names of scenarios.
        horizons: How far forecasts reach, such as [0,0.4,4.8], compared side by side [s]; 0 are
            none. A planner should plan as far in all: `mppi@9.6`.
        models: Motion models of the people, compared side by side: `social_force,orca`.
        robot_visible: [true,false] compares a robot that people see with one that they do not.
        seeds: Number of episodes of each arm in each scenario, or their seeds: `20` or `3,5,8`.
        environment: Keywords of the environment for all arms, such as {"robot": "holonomic"}.
        reference: Arm that differences are taken against, such as `mppi/none`; the first one if
            empty.
        twins: Split forecast errors into the model's own and what the robot caused, by rolling the
            crowd on, every 4.8 s, without the robot and with one that stands.
        workers: Processes, one thread each; no result depends on their number.
        resume: Go on where an interrupted run with the same options stopped.
        out: Folder of the results.
        json: File for a copy of the summary.
        seed: Added to every episode's seed; also seeds the bootstrap.
    """
    require_folder(out)
    require_file(json)
    from envs.evaluation.comparison import EvaluationConfig, ScenarioChoice, cross, variants
    from envs.evaluation.evaluate import evaluate as run
    from envs.evaluation.evaluate import write_evaluation
    from envs.report import build_report
    from scripts.interruption import kept_tasks
    from scripts.progress import episodes_bar
    from scripts.tables import print_summary

    config = EvaluationConfig(
        arms=cross(policies, forecasters, horizons),
        scenarios=tuple(
            choice
            for name in scenarios
            for choice in variants(ScenarioChoice(scenario=name), models, robot_visible)
        ),
        seeds=tuple(seed + each for each in seeds),
        reference=reference,
        environment={} if environment is None else environment,
        twins=twins,
        workers=workers,
        statistics_seed=seed,
    )
    command = f"crowdnav evaluate --config {out}/config.yaml"
    with kept_tasks(out, resume) as finished, episodes_bar() as progress:
        found = run(config, progress=progress, command=command, finished=finished)
        write_evaluation(found, out)
    build_report(found, out / "report.html")
    write_json(json, found.summary)
    print_summary(found.summary)
    print(f"Report in {out / 'report.html'}, one row per episode in {out / 'episodes.parquet'}")
