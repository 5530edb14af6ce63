"""`crowdnav evaluate-predictor`: displacement errors of forecasters on recorded crowds."""

from functools import partial
from pathlib import Path
from typing import Literal

from jsonargparse.typing import NonNegativeInt

from scripts.options import Names, PositiveNumber, Seeds
from scripts.output import require_file, require_folder, write_json


def evaluate_predictor(
    forecaster: Names = Names("iterative_attention"),
    data: str = "eth_ucy",
    horizon: PositiveNumber = 4.8,
    min_ped: Literal[0, 1] | None = None,
    published: bool = False,
    figures: Path | None = None,
    json: Path | None = None,
    seeds: Seeds = Seeds("1"),
    seed: NonNegativeInt = 0,
) -> None:
    """Measure forecasters on recorded crowds, by the protocol of the literature.

    Windows of 8 + 12 (or another horizon) consecutive listed frames, stride 1, one forecast for
    each agent; the mean is over folds. Constant velocity stands beside every forecaster, and rows
    of agents that move below those of all; a second table counts misses, collisions, and steps off
    the ground that one can walk on.

    Args:
        forecaster: The columns of the table, separated by commas: `constant_velocity`,
            `social_force`, `iterative_attention` or `fast` (the bundled weights), or the folder of
            a checkpoint, where `{fold}` and `{seed}` stand for each fold and each seed; `@no_map`,
            `@blank_map`, `@rotated_map`, `@wrong_map`, `@no_neighbors` or `@no_history` behind it
            say what a network is not shown, or shown wrongly.
        data: `eth_ucy` or a folder with that data (its five folds), `FOLDER:FOLD` (one of them),
            `sdd` or a folder with that data (in pixels), or one written by `crowdnav generate`.
        horizon: How far to forecast [s]; a multiple of 0.4. Beyond what a network was trained for
            it is rolled on its own forecasts.
        min_ped: Only windows with more agents than this count in the printed table; the JSON file
            has both. 1 if not given, 0 for SDD: what the literature does.
        published: Print below what papers report on the same data, and how it differs.
        figures: Folder for pictures: the error at each step, where final errors lie in the agent
            frame, and some scenes of each column over their ground.
        json: File for the table.
        seeds: What `{seed}` stands for, counted from `seed`: a count, or numbers separated by
            commas.
        seed: Added to each of `seeds`.
    """
    require_file(json)
    if figures is not None:
        require_folder(figures)
    from envs.forecasters.choice import make_track_forecaster
    from predictor.comparison import compare
    from predictor.published import read_published
    from scripts.prediction_figures import write_figures
    from scripts.prediction_table import print_errors, print_published

    found = compare(
        forecaster,
        data,
        seeds=[seed + s for s in seeds],
        min_ped=min_ped,
        make=partial(make_track_forecaster, horizon=horizon),
        progress=True,
    )
    print_errors(found.table)
    of_papers = read_published(data) if published else None
    if of_papers is not None:
        print_published(of_papers)
    write_json(json, found.table)
    if figures is not None:
        for path in write_figures(figures, found):
            print(path)
