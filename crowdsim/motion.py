"""By which model each pedestrian moves; one crowd may mix them."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int64]

ModelChoice = str | Mapping[str, float]
"""The name of one model for all, or each model's share of the crowd."""


class MotionModel(IntEnum):
    """Models of motion; each one's name in lower case is what scenarios call it.

    Attributes:
        SOCIAL_FORCE: people repel each other, looking ahead (`crowdsim.forces`).
        HEADED_SOCIAL_FORCE: the same, by people who walk where they face (`crowdsim.headed`).
        ORCA: the velocity nearest to the wanted one that hits nobody (`crowdsim.orca`).
        CONSTANT_VELOCITY: on towards the waypoint whoever and whatever is in the way.
    """

    SOCIAL_FORCE = 0
    HEADED_SOCIAL_FORCE = 1
    ORCA = 2
    CONSTANT_VELOCITY = 3


MODEL_NAMES: tuple[str, ...] = tuple(model.name.lower() for model in MotionModel)


def draw_models(rng: np.random.Generator, count: int, model: ModelChoice) -> IntArray:
    """Decide who moves by which model.

    Args:
        rng: source of the draws; one name for all draws nothing.
        count: number of pedestrians N.
        model: a name of `MODEL_NAMES`, or the share of each name, together 1; everybody is drawn
            alone, so that the shares hold on average.

    Returns:
        `(N,)` codes of `MotionModel`.

    Raises:
        ValueError: if a name is unknown, or the shares are negative or do not add up to 1.
    """
    shares = {model: 1.0} if isinstance(model, str) else dict(model)
    unknown = [name for name in shares if name not in MODEL_NAMES]
    if unknown:
        raise ValueError(f"model: expected one of {', '.join(MODEL_NAMES)}, found {unknown[0]!r}")
    parts = np.array(list(shares.values()), dtype=np.float64)
    if not ((parts >= 0).all() and np.isclose(parts.sum(), 1.0)):
        raise ValueError(f"model: expected shares >= 0 that add up to 1, found {shares}")
    codes = np.array([MODEL_NAMES.index(name) for name in shares], dtype=np.int64)
    if isinstance(model, str):
        return np.full(count, codes[0])
    return rng.choice(codes, size=count, p=parts / parts.sum())
