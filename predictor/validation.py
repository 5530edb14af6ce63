"""Errors of a network in training on the windows kept for validation."""

import math

import numpy as np
import torch

from predictor.inputs import last_step
from predictor.metrics import ade, displacement_errors, fde
from predictor.networks import Network
from predictor.tensors import tensors
from predictor.windows import Windows

ROWS = 256
"""Windows in one pass."""


def evaluate_windows(
    network: Network, windows: Windows, device: torch.device | str = "cpu"
) -> dict[str, float]:
    """`ade` and `fde` [m] of a network on windows, with the goals that it predicts."""
    network.eval()
    errors = []
    with torch.inference_mode():
        for rows in np.array_split(np.arange(len(windows)), math.ceil(len(windows) / ROWS)):
            inputs, future = windows.batch(rows)
            _, path = network(**tensors(inputs, device))
            errors.append(displacement_errors(path.cpu().numpy(), future))
    joined = np.concatenate(errors)
    return {"ade": ade(joined), "fde": fde(joined)}


def evaluate_constant_velocity(windows: Windows) -> dict[str, float]:
    """`ade` and `fde` [m] of constant velocity on the same windows."""
    tracks = windows.tracks
    step, _ = last_step(tracks.own[:, :, None], tracks.own_valid[:, :, None])  # (M, 1, 2)
    ahead = np.arange(1, windows.config.forecast_steps + 1)[:, None]
    errors = displacement_errors(step * ahead, tracks.future)
    return {"ade": ade(errors), "fde": fde(errors)}
