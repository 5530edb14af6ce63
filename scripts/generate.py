"""`crowdnav generate`: simulate crowds and store them as a data set."""

from pathlib import Path

from jsonargparse.typing import NonNegativeInt, PositiveInt

from scripts.interruption import resumable
from scripts.options import Names, PositiveNumber
from scripts.output import require_folder


def generate(
    scenario: Names = Names("mixed"),
    hours: PositiveNumber = 1.0,
    seconds: PositiveNumber = 60.0,
    out: Path = Path("runs/dataset"),
    workers: PositiveInt = 1,
    resume: bool = False,
    model: dict[str, float] | str | None = None,
    seed: NonNegativeInt = 0,
) -> None:
    """Simulate crowds without a robot and store them as a data set.

    Every recording is drawn from the seed and its own number, so that the files are the same
    bytes for any number of workers, and however often the command was killed and resumed.
    `train-predictor --data` takes the folder.

    Args:
        scenario: Names of scenarios or scenario files (.yaml) separated by commas, taken in turn;
            `mixed` draws scenario and parameters anew for every recording.
        hours: Simulated time of all recordings together [h], rounded up to whole recordings.
        seconds: Simulated time of one recording [s].
        out: Folder of the data set; it must not hold one already, unless it is resumed.
        workers: Processes, one thread each.
        resume: Go on with what stands in `out`, if anything does: what is whole is kept.
        model: Motion model of all people, such as orca, or the share of each, such as
            {"social_force": 0.7, "orca": 0.3}; the scenarios decide if it is not given.
        seed: Seed of everything that is drawn.
    """
    require_folder(out)
    from crowdsim.generate import generate_dataset

    hint = f"what stands in {out} is kept; resume with the same options and --resume"
    with resumable(hint):
        found = generate_dataset(
            out,
            scenarios=scenario,
            hours=hours,
            seconds=seconds,
            seed=seed,
            model=model,
            workers=workers,
            resume=resume,
        )
    print(
        f"{found['recordings']} recordings with {found['tracks']} tracks and {found['rows']} "
        f"positions, mean speed {found['mean_speed']:.2f} m/s"
    )
    print(f"Data set in {out}; next: crowdnav train-predictor --data {out}")
