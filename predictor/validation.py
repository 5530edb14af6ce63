"""Errors of a network in training on the windows kept for validation."""

import math

import numpy as np
import torch
from numpy.typing import NDArray

from predictor.distributed import ALONE, Processes
from predictor.inputs import last_step
from predictor.metrics import ade, displacement_errors, fde
from predictor.networks import Network
from predictor.tensors import tensors
from predictor.windows import Windows

ROWS = 256
"""Windows in one pass."""


def window_errors(
    network: Network,
    windows: Windows,
    device: torch.device | str = "cpu",
    processes: Processes = ALONE,
) -> NDArray[np.float64]:
    """(M, F) errors [m] of a network on windows, with the goals that it predicts.

    Several processes share the work; each is given all errors.
    """
    network.eval()
    errors = np.zeros((len(windows), windows.config.forecast_steps))
    passes = np.array_split(np.arange(len(windows)), math.ceil(len(windows) / ROWS))
    with torch.inference_mode():
        for rows in passes[processes.rank :: processes.count]:
            inputs, future = windows.batch(rows)
            _, path = network(**tensors(inputs, device))
            errors[rows] = displacement_errors(path.cpu().numpy(), future)
    processes.add_up([torch.from_numpy(errors)])
    return errors


def constant_velocity_errors(windows: Windows) -> NDArray[np.float64]:
    """(M, F) errors [m] of constant velocity on the same windows."""
    tracks = windows.tracks
    step, _ = last_step(tracks.own[:, :, None], tracks.own_valid[:, :, None])  # (M, 1, 2)
    ahead = np.arange(1, windows.config.forecast_steps + 1)[:, None]
    return displacement_errors(step * ahead, tracks.future)


def scores(errors: NDArray[np.float64]) -> dict[str, float]:
    """`ade` and `fde` [m]."""
    return {"ade": ade(errors), "fde": fde(errors)}
