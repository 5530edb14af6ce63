"""`crowdnav generate`: simulate crowds and store them as a data set."""

from pathlib import Path

from jsonargparse.typing import NonNegativeInt, PositiveInt

from scripts.options import Names, PositiveNumber
from scripts.output import require_folder


def generate(
    scenario: Names = Names("mixed"),
    hours: PositiveNumber = 1.0,
    seconds: PositiveNumber = 60.0,
    out: Path = Path("runs/dataset"),
    workers: PositiveInt = 1,
    seed: NonNegativeInt = 0,
) -> None:
    """Simulate crowds without a robot and store them as a data set.

    Every recording is drawn from the seed and its own number, so that the files are the same
    bytes for any number of workers. `train-predictor --data` takes the folder.

    Args:
        scenario: Names of scenarios separated by commas, taken in turn; `mixed` draws scenario and
            parameters anew for every recording.
        hours: Simulated time of all recordings together [h], rounded up to whole recordings.
        seconds: Simulated time of one recording [s].
        out: Folder of the data set; it must not hold one already.
        workers: Processes, one thread each.
        seed: Seed of everything that is drawn.
    """
    require_folder(out)
    from crowdsim.generate import generate_dataset

    found = generate_dataset(
        out, scenarios=scenario, hours=hours, seconds=seconds, seed=seed, workers=workers
    )
    print(
        f"{found['recordings']} recordings with {found['tracks']} tracks and {found['rows']} "
        f"positions, mean speed {found['mean_speed']:.2f} m/s"
    )
    print(f"Data set in {out}; next: crowdnav train-predictor --data {out}")
