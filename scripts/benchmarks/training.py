"""Training windows per second."""

import statistics
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from crowdsim.recordings import Picture, Recording
from predictor.config import Variant, named_configuration
from predictor.model import IterativeAttention
from predictor.train import fit
from predictor.windows import Windows, extract_windows

VARIANTS: Final[tuple[Variant, ...]] = ("none", "patch")
BATCH: Final = 256
BATCHES: Final = 8
PEOPLE: Final = 32
REPEATS: Final = 3
SIDE: Final = 30.0
"""Side of the square in which people walk [m]."""


def training(seed: int) -> dict[str, list[dict[str, Any]]]:
    """Measure epochs of the paper's training at batch `BATCH`: crops, forward, backward, update.

    The share of one validation batch and of writing the checkpoints is part of it.

    Returns:
        `training`: rows with `variant`, `batch` and `windows_per_s`, the median of `REPEATS`
        epochs.
    """
    return {"training": [_measure(variant, seed) for variant in VARIANTS]}


def _measure(variant: Variant, seed: int) -> dict[str, Any]:
    model, paper = named_configuration("paper", variant=variant, seed=seed, epochs=1)
    options = replace(paper, batch_size=BATCH)
    rng = np.random.default_rng(seed)
    windows = extract_windows([walkers(BATCHES * BATCH // PEOPLE, rng)], model)
    validation = extract_windows([walkers(BATCH // PEOPLE, rng)], model)

    def epoch(data: Windows) -> float:
        with tempfile.TemporaryDirectory() as folder:
            network = IterativeAttention(model)
            keywords: dict[str, Any] = {"out": Path(folder), "about": {}, "progress": False}
            return fit(network, data, validation, options, **keywords).windows_per_s

    epoch(validation)  # not counted: what happens only once
    rate = statistics.median(epoch(windows) for _ in range(REPEATS))
    return {"variant": variant, "batch": BATCH, "windows_per_s": round(rate, 1)}


def walkers(windows: int, rng: np.random.Generator) -> Recording:
    """`PEOPLE` who walk straight on for so many 8 + 12 windows, on a noisy picture."""
    steps = windows + 19
    velocity = rng.normal(0.0, 1.0, (PEOPLE, 2))
    start = rng.uniform(0.0, SIDE, (PEOPLE, 2))
    time = 0.4 * np.arange(steps)[:, None, None]
    pixels = round(10.0 * SIDE)
    return Recording(
        name="walkers",
        positions=start + velocity * time,
        valid=np.ones((steps, PEOPLE), dtype=np.bool_),
        ids=np.arange(PEOPLE),
        frames=np.arange(steps),
        picture=Picture(
            rng.integers(0, 256, (pixels, pixels, 3), dtype=np.uint8),
            np.array([[10.0, 0.0, 0.0], [0.0, -10.0, pixels], [0.0, 0.0, 1.0]]),
        ),
    )
