"""`crowdnav render`: picture or video of one episode."""

from pathlib import Path
from typing import Any, Final

from jsonargparse.typing import NonNegativeInt

from scripts.output import require_file

SUFFIXES: Final = (".png", ".webm")


def render(
    scenario: str = "urban_crossing",
    scenario_parameters: dict[str, Any] | None = None,
    policy: str = "mppi",
    forecaster: str = "fast",
    environment: dict[str, Any] | None = None,
    out: Path = Path("runs/render/episode.webm"),
    seed: NonNegativeInt = 0,
) -> None:
    """Run one episode and draw it: people, their histories and forecasts, the robot and its goal.

    Args:
        scenario: Name of the scenario.
        scenario_parameters: Its keywords, such as {"pedestrians": 40}.
        policy: `straight`, `mppi`, or a folder written by `crowdnav train-policy`.
        forecaster: `none`, `constant_velocity`, `fast`, `iterative_attention`, or a checkpoint.
        environment: Further keywords of the environment, such as {"robot": "holonomic"}.
        out: File to write: `.webm` is a video of the episode, `.png` a picture of one moment.
        seed: Seed of the episode.
    """
    if out.suffix not in SUFFIXES:
        raise ValueError(f"expected a file named {' or '.join(SUFFIXES)}, found {out.name!r}")
    require_file(out)
    from envs.config import make_config
    from envs.evaluation.runs import run_episode
    from envs.report import write_picture, write_video

    config = make_config(
        **{} if environment is None else environment,
        scenario=scenario,
        scenario_parameters={} if scenario_parameters is None else scenario_parameters,
        forecaster=forecaster,
    )
    trace = run_episode(config, policy, seed)
    draw = write_video if out.suffix == ".webm" else write_picture
    draw(trace, out)
    print(f"{trace.termination_reason} after {trace.duration:.1f} s; drawn in {out}")
