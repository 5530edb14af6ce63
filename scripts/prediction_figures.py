"""The pictures that `crowdnav evaluate-predictor` writes."""

import re
from pathlib import Path
from typing import Final

from predictor.comparison import BASELINE, Comparison

SCENES: Final = 6
"""Of a picture of scenes."""


def write_figures(folder: Path, found: Comparison) -> list[Path]:
    """Write the error plots, and forecasts over the ground for each column.

    Args:
        folder: Where to.
        found: Of `predictor.comparison.compare`.

    Returns:
        What was written.
    """
    from crowdsim.recordings.store import write_atomic
    from predictor.error_plots import error_by_step, final_errors

    folder.mkdir(parents=True, exist_ok=True)
    pictures = {
        "error_by_step": error_by_step(found.table),
        "final_errors": final_errors(found.errors),
        **_scenes(found),
    }
    paths = {folder / f"{name}.png": picture for name, picture in pictures.items()}
    for path, picture in paths.items():
        write_atomic(path, picture)
    return list(paths)


def _scenes(found: Comparison) -> dict[str, bytes]:
    """Forecasts of each column but constant velocity, in scenes of all folds; some have none."""
    from predictor.scene_picture import liveliest, scene_picture

    pictures, each = {}, -(-SCENES // len(found.tests))
    for name, forecasters in found.forecasters.items():
        drawn = [
            scene
            for fold, recordings in found.tests.items()
            if name != BASELINE
            for scene in liveliest(forecasters[fold], recordings, each)
        ]
        if drawn:
            pictures[f"scenes-{_file_name(name)}"] = scene_picture(name, drawn[:SCENES])
    return pictures


def _file_name(column: str) -> str:
    return re.sub(r"\W+", "-", column).strip("-")
