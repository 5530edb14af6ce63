"""What a network makes use of: errors with a stream switched off, or shown wrongly.

`python tests/validation/what_is_used.py FORECASTER DATA` prints a row for each ending of
`predictor.ablation.ENDINGS`: ADE/FDE (the mean over folds where there are several) and how much the
FDE is above that of the network as it is, with a 95 % interval. That is a bootstrap over stretches
of 40 windows one after the other: windows overlap, and stretches nearly do not.
"""

import sys

import numpy as np
import torch
from numpy.typing import NDArray

from predictor.ablation import ENDINGS
from predictor.comparison import compare
from predictor.datasets import unit_of, usual_min_ped
from predictor.trajectory_errors import TrajectoryErrors

STRETCH = 40
DRAWS = 2000

Folds = dict[str, TrajectoryErrors]


def excess(plain: Folds, changed: Folds, min_ped: int) -> tuple[float, float, float]:
    """How much larger the FDE is, and the interval of that; the mean is over folds."""
    rng = np.random.default_rng(0)
    mean, drawn = 0.0, np.zeros(DRAWS)
    for fold, before in plain.items():
        counted = before.agents > min_ped
        difference = (changed[fold].errors - before.errors)[counted, -1]
        mean += float(difference.mean()) / len(plain)
        drawn += resampled(difference, before.windows[counted] // STRETCH, rng) / len(plain)
    low, high = np.quantile(drawn, (0.025, 0.975))
    return mean, float(low), float(high)


def resampled(
    values: NDArray[np.float64], groups: NDArray[np.int64], rng: np.random.Generator
) -> NDArray[np.float64]:
    """(DRAWS,) means over groups drawn with replacement."""
    _, number = np.unique(groups, return_inverse=True)
    sums, counts = np.bincount(number, weights=values), np.bincount(number)
    chosen = rng.integers(len(sums), size=(DRAWS, len(sums)))
    return np.asarray(sums[chosen].sum(axis=1) / counts[chosen].sum(axis=1))


def main(forecaster: str, data: str) -> None:
    torch.set_num_threads(1)
    specs = [forecaster + ending for ending in ("", *ENDINGS)]
    found, min_ped = compare(specs, data), usual_min_ped(data)
    unit, plain = unit_of(data), found.errors[forecaster]
    count = sum(int((fold.agents > min_ped).sum()) for fold in plain.values())
    sys.stdout.write(f"{forecaster} on {data} [{unit}], n = {count}, min_ped {min_ped}\n")
    for spec, column in found.table["columns"].items():
        row, moving = column["mean"], column["mean"]["moving"]
        mean, low, high = excess(plain, found.errors[spec], min_ped)
        sys.stdout.write(
            f"{spec:40} {row['ade']:.3f}/{row['fde']:.3f}   moving {moving['ade']:.3f}/"
            f"{moving['fde']:.3f}   FDE {mean:+.3f} [{low:+.3f}, {high:+.3f}]\n"
        )
        sys.stdout.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
