"""Time of one forecast, its inputs included."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import torch

from predictor.config import Variant, named_configuration
from predictor.model import IterativeAttention
from predictor.network_forecaster import NetworkForecaster
from scripts.benchmarks.timing import seconds_in_turn

NETWORKS: Final[tuple[tuple[str, Variant], ...]] = (
    ("paper", "none"),
    ("paper", "patch"),
    ("fast", "patch"),
)
"""Configurations and variants."""
AGENTS: Final = (1, 10, 50, 200)
SIDE: Final = 30.0
"""Side of the square in which people stand [m]."""
PIXELS_PER_METRE: Final = 10.0


def forecast(seed: int) -> dict[str, list[dict[str, Any]]]:
    """Measure one call of the forecaster for all people of one world.

    The networks are untrained: their time does not depend on their weights. They take turns, so
    that their ratios hold on a noisy machine too.

    Returns:
        `forecast`: rows with `configuration`, `variant`, `agents`, `neighbors` (K) and `ms`, the
        median of one call.
    """
    forecasters = [NetworkForecaster(untrained(name, variant, seed)) for name, variant in NETWORKS]
    rows = []
    for agents in AGENTS:
        calls = [one_forecast(forecaster, agents, seed) for forecaster in forecasters]
        seconds = np.median(seconds_in_turn(calls), axis=1)
        rows += [
            {
                "configuration": name,
                "variant": variant,
                "agents": agents,
                "neighbors": forecaster.network.config.neighbors,
                "ms": round(1e3 * float(second), 3),
            }
            for (name, variant), forecaster, second in zip(
                NETWORKS, forecasters, seconds, strict=True
            )
        ]
    return {"forecast": sorted(rows, key=lambda row: (row["configuration"], row["variant"]))}


def untrained(name: str, variant: Variant, seed: int) -> IterativeAttention:
    """The network of a configuration, its weights drawn."""
    torch.manual_seed(seed)
    model, _ = named_configuration(name, variant=variant)
    return IterativeAttention(model)


def one_forecast(forecaster: NetworkForecaster, agents: int, seed: int) -> Callable[[], object]:
    """One forecast of people who walk on straight, on a noisy picture."""
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
    return lambda: forecaster.forecast(history, valid, image, pixel_from_world)
