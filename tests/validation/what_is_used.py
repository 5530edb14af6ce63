"""What a network makes use of: errors with a stream switched off, or shown wrongly.

`python tests/validation/what_is_used.py FORECASTER DATA` prints a row for each ending of
`predictor.ablation.ENDINGS`: ADE/FDE (the mean over folds where there are several) and how much the
FDE is above that of the network as it is, with a 95 % interval. That is a bootstrap over stretches
of 40 windows one after the other: windows overlap, and stretches nearly do not.
"""

import sys
from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray

from crowdsim.recordings import Recording
from predictor.ablation import ENDINGS
from predictor.datasets import read_tests, usual_min_ped
from predictor.forecaster import make_forecaster
from predictor.metrics import displacement_errors
from predictor.scenes import Scene, scenes
from predictor.trajectory_errors import forecast_scenes

STRETCH = 40
DRAWS = 2000
WORLDS = 32


def windows_of(recordings: Sequence[Recording], min_ped: int) -> list[Scene]:
    """The windows that count, by the protocol of `crowdnav evaluate-predictor`."""
    every = (s for r in recordings for s in scenes(r, history_steps=8, forecast_steps=12))
    return [scene for scene in every if len(scene.agents) > min_ped]


def errors_of(spec: str, windows: Sequence[Scene]) -> NDArray[np.float64]:
    """(M, F) errors [m] of all agents of all windows."""
    forecaster = make_forecaster(spec)
    assert forecaster is not None
    return np.concatenate(
        [
            displacement_errors(path, scene.future).T
            for chunk in (windows[at : at + WORLDS] for at in range(0, len(windows), WORLDS))
            for scene, path in zip(chunk, forecast_scenes(forecaster, chunk), strict=True)
        ]
    )


def resampled(values: NDArray[np.float64], groups: NDArray[np.int64]) -> NDArray[np.float64]:
    """(DRAWS,) means over groups drawn with replacement."""
    _, number = np.unique(groups, return_inverse=True)
    sums, counts = np.bincount(number, weights=values), np.bincount(number)
    chosen = np.random.default_rng(0).integers(len(sums), size=(DRAWS, len(sums)))
    return np.asarray(sums[chosen].sum(axis=1) / counts[chosen].sum(axis=1))


def main(forecaster: str, data: str) -> None:
    torch.set_num_threads(1)
    limit = usual_min_ped(data)
    folds = [windows_of(recordings, limit) for recordings in read_tests(data).values()]
    stretches = [
        np.repeat(np.arange(len(fold)), [len(scene.agents) for scene in fold]) // STRETCH
        for fold in folds
    ]
    plain = [errors_of(forecaster, fold) for fold in folds]
    sys.stdout.write(f"{data} [m], n = {sum(map(len, plain))}, min_ped {limit}\n")
    for spec in (forecaster, *(forecaster + ending for ending in ENDINGS), "constant_velocity"):
        errors = [errors_of(spec, fold) for fold in folds]
        excess = [
            resampled(new[:, -1] - old[:, -1], stretch)
            for new, old, stretch in zip(errors, plain, stretches, strict=True)
        ]
        low, high = np.quantile(np.mean(excess, axis=0), (0.025, 0.975))
        ade, fde = (
            np.mean([of_fold[:, at].mean() for of_fold in errors]) for at in (slice(12), -1)
        )
        above = fde - np.mean([of_fold[:, -1].mean() for of_fold in plain])
        sys.stdout.write(
            f"{spec:36} {ade:.3f}/{fde:.3f}   FDE {above:+.3f} [{low:+.3f}, {high:+.3f}]\n"
        )
        sys.stdout.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
