"""The mixture of scenarios that training sets are drawn from."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from crowdsim.scenarios.urban import LAYOUTS, STREETS

MIXED: Final = "mixed"
"""Name for a draw among `MIXTURE`."""

Parameters = dict[str, Any]


def _urban(rng: np.random.Generator) -> Parameters:
    # The first streets are those that environments draw: a predictor is not trained on them.
    return {
        "pedestrians": int(rng.integers(12, 41)),
        "layout": int(rng.integers(STREETS, LAYOUTS)),
    }


def _circle(rng: np.random.Generator) -> Parameters:
    return {"pedestrians": int(rng.integers(6, 25)), "radius": round(rng.uniform(5.0, 10.0), 1)}


def _corridor(rng: np.random.Generator) -> Parameters:
    width = round(rng.uniform(3.0, 8.0), 1)
    return {
        "width": width,
        "pedestrians": int(rng.integers(8, round(5.0 * width))),
        "oncoming": rng.uniform(0.0, 1.0),
    }


def _doorway(rng: np.random.Generator) -> Parameters:
    return {
        "pedestrians": int(rng.integers(4, 13)),
        "door_width": round(rng.uniform(1.2, 2.4), 1),
        "room_length": round(rng.uniform(5.0, 9.0), 1),
        "room_width": round(rng.uniform(5.0, 9.0), 1),
        "crossing": rng.uniform(0.2, 0.7),
    }


MIXTURE: Final[dict[str, tuple[float, Callable[[np.random.Generator], Parameters]]]] = {
    "urban_crossing": (0.4, _urban),
    "circular_crossing": (0.2, _circle),
    "parallel_traffic": (0.3, _corridor),
    "narrow_doorway": (0.1, _doorway),
}
"""Share of the recordings, and the distribution of the parameters, of each scenario in `mixed`."""


def draw_mixed(rng: np.random.Generator) -> tuple[str, Parameters]:
    """Draw the name and the parameters of one scenario."""
    shares = [share for share, _ in MIXTURE.values()]
    name = str(rng.choice(list(MIXTURE), p=shares))
    return name, MIXTURE[name][1](rng)
