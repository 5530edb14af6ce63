"""`crowdnav demo`: the main job with the bundled predictor, no argument needed."""

import os
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Final

from jsonargparse.typing import NonNegativeInt, PositiveInt

from scripts.options import Seeds
from scripts.output import require_file, require_folder, write_json

if TYPE_CHECKING:
    from envs.evaluation.comparison import Arm, ScenarioChoice
    from envs.evaluation.evaluate import Evaluation

SYNTHETIC: Final = ("circular_crossing", "parallel_traffic", "urban_crossing")
REAL_SCENE: Final = "crowds_zara01"
REFERENCE: Final = "mppi/none"
FORECASTING: Final = "mppi/fast"


def demo(
    data: Path | None = None,
    seeds: Seeds = Seeds(12),
    workers: PositiveInt | None = None,
    out: Path = Path("runs/demo"),
    json: Path | None = None,
    seed: NonNegativeInt = 0,
) -> None:
    """Evaluate robot policies with and without forecasts, in simulated crowds and a real one.

    Straight to the goal, ORCA, and a sampling planner that is shown no forecasts, constant
    velocity, the bundled predictor's, or what is going to happen (the oracle). Writes
    `report.html`, `episodes.parquet`, `summary.json`, `episode.webm` and `episode.png`.

    Args:
        data: Folder with the ETH/UCY data; else $CROWDNAV_DATA and ../shared/data are tried, and
            the real crowd is left out where there is none.
        seeds: Number of episodes of each arm in each scenario, or their seeds.
        workers: Processes, one thread each; as many as there are cores if not given.
        out: Folder of the results.
        json: File for a copy of the summary.
        seed: Added to every episode's seed; also seeds the bootstrap.
    """
    require_folder(out)
    require_file(json)
    from envs.evaluation.comparison import EvaluationConfig
    from envs.evaluation.evaluate import evaluate, write_evaluation
    from envs.report import build_report
    from scripts.progress import episodes_bar

    config = EvaluationConfig(
        arms=arms(),
        scenarios=scenarios(data),
        seeds=tuple(seed + each for each in seeds),
        reference=REFERENCE,
        workers=cores() if workers is None else workers,
        statistics_seed=seed,
    )
    print("The first run begins by compiling the simulator and the planner, half a minute or so.")
    with episodes_bar() as progress:
        found = evaluate(config, progress=progress, command="crowdnav demo")
    write_evaluation(found, out)
    build_report(found, out / "report.html")
    write_json(json, found.summary)
    draw_episode(found, out)
    print_findings(found, out)


def cores() -> int:
    """Number of processors, 1 where the system does not tell."""
    found = os.cpu_count()
    return 1 if found is None else found


def arms() -> tuple["Arm", ...]:
    """What is compared."""
    from envs.evaluation.comparison import Arm

    forecasters = ("none", "constant_velocity", "fast", "oracle")
    planned = (Arm(policy="mppi", forecaster=forecaster) for forecaster in forecasters)
    return Arm(policy="straight"), Arm(policy="orca"), *planned


def scenarios(data: Path | None) -> tuple["ScenarioChoice", ...]:
    """Where it is compared: synthetic crowds and, if its data is there, a real one.

    Raises:
        FileNotFoundError: `data` is given, and no ETH/UCY data is there.
    """
    from crowdsim.recordings import find_data
    from envs.evaluation.comparison import ScenarioChoice

    synthetic = tuple(ScenarioChoice(scenario=name) for name in SYNTHETIC)
    try:
        folder = find_data(data)
    except FileNotFoundError as missing:
        if data is not None:
            raise
        print(f"Without a real crowd: {missing}")
        return synthetic
    parameters = {"scene": REAL_SCENE, "data": str(folder)}
    return *synthetic, ScenarioChoice(
        scenario="replay", parameters=parameters, title=f"replay of {REAL_SCENE}"
    )


def draw_episode(found: "Evaluation", out: Path) -> None:
    """Write a video and a picture of the last recorded episode with the predictor's forecasts."""
    from envs.report import write_picture, write_video

    shown = [episode for episode in found.recorded if episode.arm == FORECASTING][-1]
    write_video(shown.trace, out / "episode.webm")
    write_picture(shown.trace, out / "episode.png")


def print_findings(found: "Evaluation", out: Path) -> None:
    """Print the table, what was found about the predictor's forecasts, and where to look."""
    from scripts.tables import print_summary

    print_summary(found.summary)
    for sentence in chain(*found.summary["findings"].values()):
        if sentence.startswith(f"{FORECASTING} "):
            print(f"* {sentence}")
    print(f"Report, opens offline: {out / 'report.html'}")
    print(f"One row per episode: {out / 'episodes.parquet'}; video: {out / 'episode.webm'}")
