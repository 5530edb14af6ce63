"""Seeded scenario generators by name; each documents its parameters."""

import inspect
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from crowdsim.scenario import Scenario
from crowdsim.scenarios.circular import circular_crossing
from crowdsim.scenarios.corridor import parallel_traffic
from crowdsim.scenarios.doorway import narrow_doorway
from crowdsim.scenarios.replay import replay
from crowdsim.scenarios.urban import urban_crossing

SCENARIOS: Final[dict[str, Callable[..., Scenario]]] = {
    "circular_crossing": circular_crossing,
    "parallel_traffic": parallel_traffic,
    "narrow_doorway": narrow_doorway,
    "urban_crossing": urban_crossing,
    "replay": replay,
}


def make_scenario(name: str, rng: np.random.Generator, **parameters: Any) -> Scenario:
    """Draw the initial conditions of one world.

    Args:
        name: One of `SCENARIOS`.
        rng: Source of all draws.
        **parameters: Parameters of that scenario's function.

    Raises:
        ValueError: Unknown name or parameter (the message lists the known ones), or a parameter
            out of range.
        FileNotFoundError: A replay whose data is not there.
    """
    if name not in SCENARIOS:
        raise ValueError(f"scenario must be one of {', '.join(SCENARIOS)}, got {name!r}")
    known = [key for key in inspect.signature(SCENARIOS[name]).parameters if key != "rng"]
    unknown = sorted(set(parameters) - set(known))
    if unknown:
        raise ValueError(f"{name} takes {', '.join(known)}; got {', '.join(unknown)}")
    return SCENARIOS[name](rng, **parameters)
