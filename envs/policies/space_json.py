"""Boxes as JSON, and back with checks: the spaces that a stored policy was trained for."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

LARGEST_KEY: Final = 1_000_000
"""Values that one observation key may hold: a damaged description must not fill the memory."""


def box_to_json(box: spaces.Box) -> dict[str, Any]:
    """Returns shape, dtype and bounds; a bound that is the same everywhere becomes one number."""

    def bound(values: NDArray[Any]) -> Any:
        return values.flat[0].item() if (values == values.flat[0]).all() else values.tolist()

    return {
        "shape": list(box.shape),
        "dtype": str(box.dtype),
        "low": bound(box.low),
        "high": bound(box.high),
    }


def box_from_json(name: str, description: Mapping[str, Any]) -> spaces.Box:
    """Returns the Box that `box_to_json` described.

    Raises:
        ValueError: It is malformed or implausibly large.
    """
    try:
        shape = tuple(int(length) for length in description["shape"])
        if not 0 < math.prod(shape) <= LARGEST_KEY:
            raise ValueError(f"shape {shape} is empty or larger than {LARGEST_KEY} values")
        dtype = np.dtype(description["dtype"]).type
        low, high = (np.broadcast_to(description[key], shape) for key in ("low", "high"))
        return spaces.Box(low.astype(dtype), high.astype(dtype), dtype=dtype)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"the space {name!r} of the policy is malformed: {error}") from error
