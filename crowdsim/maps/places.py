"""Varied places by kind and number, so that a network cannot learn one map by heart."""

import zlib
from collections.abc import Callable
from functools import lru_cache
from typing import Final

import numpy as np

from crowdsim.maps.mall import mall
from crowdsim.maps.plan import Place
from crowdsim.maps.square import square
from crowdsim.maps.station import station
from crowdsim.maps.street import street

PLACES: Final[dict[str, Callable[[np.random.Generator], Place]]] = {
    "square": square,
    "street": street,
    "station": station,
    "mall": mall,
}
LAYOUTS: Final = 100_000
"""Number of different places of a kind."""


@lru_cache(maxsize=256)
def make_place(kind: str, layout: int) -> Place:
    """Give place number `layout` of a kind.

    The same number gives the same object, so that what physics derives from its map is cached too.

    Args:
        kind: One of `PLACES`.
        layout: 0 to 99,999.

    Raises:
        ValueError: Unknown kind, or a number out of range.
    """
    if kind not in PLACES:
        raise ValueError(f"kind must be one of {', '.join(PLACES)}, got {kind!r}")
    if not 0 <= layout < LAYOUTS:
        raise ValueError(f"layout must be in 0..{LAYOUTS - 1}, got {layout}")
    seed = np.random.SeedSequence(layout, spawn_key=(zlib.crc32(kind.encode()),))
    return PLACES[kind](np.random.default_rng(seed))
