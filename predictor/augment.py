"""What a batch of training windows is put through, so that nothing accidental is learned."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from predictor.config import TrainConfig
from predictor.inputs import AgentInputs
from predictor.windows import Windows


def augmented_batch(
    windows: Windows, rows: NDArray[np.int64], training: TrainConfig, rng: np.random.Generator
) -> tuple[AgentInputs, NDArray[np.float32]]:
    """Inputs with crops, and futures, of some windows: altered at random.

    They are mirrored, scaled, recolored, without map, or without their first frames. Who stands is
    seen along a random direction: world +x must not mean anything.

    Args:
        windows: All training windows.
        rows: (B,) which of them.
        training: How much of what.
        rng: Source of the draws.
    """
    count = len(rows)
    stretch = _stretch(count, training, rng)
    hidden = _hidden(count, windows.config.history_steps, training, rng)
    angle = rng.uniform(-np.pi, np.pi, count)
    undirected = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    inputs, future = windows.batch(rows, stretch, hidden, undirected)
    if inputs.crop is None:
        return inputs, future
    recolored = rng.random(count) < training.recolor
    inputs.crop[recolored] = recolor(inputs.crop[recolored], rng)
    shown = rng.random(count) >= training.hide_map
    return replace(inputs, crop_valid=inputs.crop_valid & shown), future


def _stretch(count: int, training: TrainConfig, rng: np.random.Generator) -> NDArray[np.float64]:
    """(B, 2) factors on x and y of the agent frame."""
    scale = rng.uniform(1.0 - training.scale, 1.0 + training.scale, count)
    mirrored = training.mirror & (rng.random(count) < 0.5)
    return np.stack([scale, np.where(mirrored, -scale, scale)], axis=1)


def _hidden(
    count: int, history_steps: int, training: TrainConfig, rng: np.random.Generator
) -> NDArray[np.int64]:
    """(B,) number of first frames that are hidden: mostly 0, at most all but the last one."""
    frames = rng.integers(1, max(2, history_steps), count)
    truncated = (rng.random(count) < training.truncate) & (history_steps > 1)
    return np.where(truncated, frames, 0)


def recolor(crop: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """Exchange, bleach, stretch or invert the colours of (B, S, S, 3) pictures.

    The palette of drawn maps is not that of photographs; shapes are what both share. Black, which
    stands for the world beyond the picture, stays.
    """
    count = len(crop)
    exchanged = np.eye(3)[rng.permuted(np.tile(np.arange(3), (count, 1)), axis=1)]  # (B, 3, 3)
    bleached = rng.uniform(0.0, 1.0, (count, 1, 1))
    contrast = rng.uniform(0.4, 1.4, (count, 1, 1)) * rng.choice([-1.0, 1.0], (count, 1, 1))
    mixed = contrast * ((1.0 - bleached) * exchanged + bleached / 3.0)
    brightness = (127.5 + rng.uniform(-40.0, 40.0, (count, 1, 3))).astype(np.float32)
    pixels = crop.reshape(count, crop.shape[1] * crop.shape[2], 3).astype(np.float32)
    changed = np.clip((pixels - 127.5) @ mixed.astype(np.float32) + brightness, 1.0, 255.0)
    there = crop.any(axis=-1, keepdims=True)
    return np.where(there, changed.reshape(crop.shape), 0.0).astype(np.uint8)
