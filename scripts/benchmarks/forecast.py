"""Time of one forecast, its inputs included."""

from typing import Any, Final

import numpy as np
import torch

from predictor.config import VARIANTS, ModelConfig, Variant
from predictor.model import IterativeAttention
from predictor.network_forecaster import NetworkForecaster
from scripts.benchmarks.timing import seconds_per_call

AGENTS: Final = (1, 10, 50, 200)
NEIGHBORS: Final = 8
SIDE: Final = 30.0
"""Side of the square in which people stand [m]."""
PIXELS_PER_METRE: Final = 10.0


def forecast(seed: int) -> dict[str, list[dict[str, Any]]]:
    """Measure one call of the forecaster for all people of one world.

    The network is the paper's, untrained: its time does not depend on its weights.

    Returns:
        `forecast`: rows with `variant`, `agents`, `neighbors` and `ms`, the median of one call.
    """
    rows = [_measure(variant, agents, seed) for variant in VARIANTS for agents in AGENTS]
    return {"forecast": rows}


def _measure(variant: Variant, agents: int, seed: int) -> dict[str, Any]:
    torch.manual_seed(seed)
    forecaster = NetworkForecaster(
        IterativeAttention(ModelConfig(variant=variant, neighbors=NEIGHBORS))
    )
    rng = np.random.default_rng(seed)
    velocity = rng.normal(0.0, 1.0, (agents, 2))
    time = forecaster.frame_dt * np.arange(forecaster.history_steps)[:, None, None]
    history = rng.uniform(0.0, SIDE, (agents, 2)) + velocity * time  # (T, N, 2)
    valid = np.ones(history.shape[:2], dtype=np.bool_)
    pixels = round(SIDE * PIXELS_PER_METRE)
    image = rng.integers(0, 256, (pixels, pixels, 3), dtype=np.uint8)
    pixel_from_world = np.array(
        [[PIXELS_PER_METRE, 0.0, 0.0], [0.0, -PIXELS_PER_METRE, pixels], [0.0, 0.0, 1.0]]
    )
    seconds = seconds_per_call(lambda: forecaster.forecast(history, valid, image, pixel_from_world))
    return {
        "variant": variant,
        "agents": agents,
        "neighbors": NEIGHBORS,
        "ms": round(1e3 * seconds, 3),
    }
