"""Zero-shot errors on ETH/UCY with the ground drawn as the simulator draws it.

The bundled weights saw drawn maps only. Here the walkable mask of each scene is drawn in the same
palette and takes the place of the photograph: `python tests/validation/drawn_maps.py`.
"""

import dataclasses
import sys

import torch

from crowdsim.maps import eth_ucy_map
from crowdsim.recordings import Picture, Recording, find_data
from crowdsim.render import render_map
from predictor.datasets import read_tests
from predictor.evaluate import evaluate_folds
from predictor.forecaster import make_forecaster


def drawn(recording: Recording) -> Recording:
    """The same people on a drawn map of the same place."""
    photographed = eth_ucy_map(find_data(None), recording.name)
    ground = dataclasses.replace(photographed, picture=None)
    return dataclasses.replace(recording, picture=Picture(*render_map(ground)))


def main() -> None:
    torch.set_num_threads(1)
    tests = {
        fold: [drawn(recording) for recording in recordings]
        for fold, recordings in read_tests("eth_ucy").items()
    }
    forecasters = dict.fromkeys(tests, make_forecaster("iterative_attention"))
    found = evaluate_folds(forecasters, tests, data="eth_ucy", min_ped=1)
    for fold, row in {**found["folds"], "mean": found["mean"]}.items():
        moving = row["moving"]
        sys.stdout.write(
            f"{fold:6} {row['ade']:.3f}/{row['fde']:.3f}"
            f"   moving {moving['ade']:.3f}/{moving['fde']:.3f}\n"
        )


if __name__ == "__main__":
    main()
