"""`crowdnav stress`: where longer forecasts stop helping."""

from pathlib import Path
from typing import Any

from jsonargparse.typing import NonNegativeInt, PositiveInt

from scripts.options import Names, PositiveNumber, Seeds
from scripts.output import require_file, require_folder, write_json


def stress(
    horizons: list[PositiveNumber] | None = None,
    forecasters: Names = Names("constant_velocity,iterative_attention"),
    policy: str = "mppi@9.6",
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
    """Vary how far ahead forecasts reach, with everything else fixed and on common seeds.

    Writes the curves as `stress.json`, `stress.md`, `stress.svg` and `stress.png`, and one row per
    episode as `episodes.parquet`. The planner without forecasts always runs along.

    Args:
        horizons: Horizons [s], whole multiples of 0.4 s, such as [0.4,4.8]; 0.4 to 9.6 s if not
            given.
        forecasters: As `crowdnav evaluate` takes them, without `none`.
        policy: `mppi@SECONDS`, which plans that far ahead whatever the horizon of the forecasts,
            `mppi` (4.8 s), `straight`, or a folder written by `crowdnav train-policy`.
        scenario: Name of the scenario.
        scenario_parameters: Its keywords, such as {"pedestrians": 40}.
        seeds: Number of episodes of each forecaster at each horizon, or their seeds.
        environment: Keywords of the environment for all, such as {"robot": "holonomic"}.
        workers: Processes, one thread each; no result depends on their number.
        resume: Go on where an interrupted run with the same options stopped.
        out: Folder of the results.
        json: File for a copy of `stress.json`.
        seed: Added to every episode's seed.
    """
    require_folder(out)
    require_file(json)
    from envs.comparison import ScenarioChoice
    from envs.stress import HORIZONS, StressConfig, stress_table, write_stress
    from envs.stress import stress as run
    from scripts.interruption import kept_tasks
    from scripts.progress import episodes_bar

    config = StressConfig(
        forecasters=forecasters,
        horizons=HORIZONS if horizons is None else tuple(horizons),
        policy=policy,
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
    write_json(json, found.table)
    print(stress_table(found.table))
    print(f"Curves in {out / 'stress.svg'}, this table in {out / 'stress.md'}")
