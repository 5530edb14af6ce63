"""Fit the social force to recorded crowds: `python tests/validation/fit.py`, some minutes.

A random search, first all over `RANGES`, then ever nearer around the best, for the least loss of
`resimulation.compare` on the fitted scenes; all candidates get the same random numbers. It prints
each improvement; `crowdsim.forces.ETH_UCY` holds the last one, rounded.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

import numpy as np
import resimulation
from tqdm import tqdm

from crowdsim.forces import SocialForce

RANGES = {
    "repulsion": (0.1, 5.0),
    "repulsion_range": (0.1, 1.0),
    "anisotropy": (0.0, 1.0),
    "anticipation": (0.0, 4.0),
    "whim": (0.0, 0.3),
    "hold_back": (0.0, 3.0),
}
TRIALS = 120
SPREAD_OUT = 40
"""Trials all over the ranges, before the search narrows."""
EVERY = 50
"""Rows of 0.4 s from one start to the next."""


def draw(rng, best, width):
    """Parameters within `width` times the ranges around the best ones, or anywhere if it is 1."""
    low, high = np.array(list(RANGES.values())).T
    if width < 1:
        middle = np.array([best[name] for name in RANGES])
        reach = width * (high - low)
        low, high = np.maximum(low, middle - reach), np.minimum(high, middle + reach)
    return dict(zip(RANGES, rng.uniform(low, high).tolist(), strict=True))


def loss(model):
    return resimulation.compare(resimulation.FITTED, model, every=EVERY).loss()


def main():
    rng = np.random.default_rng(0)
    best = {name: getattr(SocialForce(), name) for name in RANGES}
    least = loss(SocialForce())
    tqdm.write(f"defaults {least:.4f}")
    for trial in tqdm(range(TRIALS)):
        width = 1.0 if trial < SPREAD_OUT else 0.3 * (1 - trial / TRIALS)
        drawn = draw(rng, best, width)
        found = loss(SocialForce(**drawn))
        if found < least:
            least, best = found, drawn
            shown = ", ".join(f"{name}={value:.3f}" for name, value in best.items())
            tqdm.write(f"{trial} {least:.4f} {shown}")


if __name__ == "__main__":
    main()
