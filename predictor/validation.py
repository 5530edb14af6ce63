"""Errors of a network in training on the windows kept for validation."""

import math
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from predictor.calibration import calibration, temperatures
from predictor.distributed import ALONE, Processes
from predictor.inputs import last_step
from predictor.metrics import ade, displacement_errors, fde
from predictor.modal_forecast import ModalForecast, standing
from predictor.modal_metrics import nll
from predictor.model import IterativeAttention
from predictor.modes import ordered
from predictor.networks import Network, has_modes
from predictor.tensors import tensors
from predictor.windows import Windows

ROWS = 256
"""Windows in one pass."""


def validated(
    network: Network,
    windows: Windows,
    device: torch.device | str = "cpu",
    processes: Processes = ALONE,
) -> tuple[dict[str, float], dict[str, Any]]:
    """How good a network is on windows, and what a checkpoint keeps to calibrate its forecasts.

    Returns:
        `ade` and `fde` [m], and of a network with modes `nll` [nat] before it is calibrated; and
        the calibration, JSON-able.
    """
    if not has_modes(network):
        errors = window_errors(network, windows, device, processes)
        return scores(errors), calibration(errors)
    forecast, future = window_modes(network, windows, device, processes)
    errors = displacement_errors(forecast.path, future).T
    found = {**scores(errors), "nll": float(nll(forecast, future).mean())}
    temperature = temperatures(forecast, future)
    return found, {**calibration(errors), "temperature": temperature.tolist()}


def window_modes(
    network: IterativeAttention,
    windows: Windows,
    device: torch.device | str = "cpu",
    processes: Processes = ALONE,
) -> tuple[ModalForecast, NDArray[np.float64]]:
    """Modes of a network on M windows in the agent frames, and their (F, M, 2) true paths [m].

    The windows are the people of a single world, without W axis. Several processes share the work;
    each is given all modes.
    """
    network.eval()
    steps = windows.config.forecast_steps
    nobody = np.zeros((1, len(windows), 2))
    found = standing(nobody, network.config.modes, steps).of_world(0)
    found.probability[:] = 0.0
    future = np.zeros_like(found.path)
    with torch.inference_mode():
        for rows in _passes(windows, processes):
            inputs, true_path = windows.batch(rows)
            _, path, modes = network.forward_modes(**tensors(inputs, device))
            position, probability, covariance = ordered(modes)
            found.path[:, rows] = path.cpu().numpy().swapaxes(0, 1)
            found.position[:, :, rows] = np.moveaxis(position, 0, 2)
            found.probability[:, rows] = probability.T
            found.covariance[:, :, rows] = np.moveaxis(covariance, 0, 2)
            future[:, rows] = true_path.swapaxes(0, 1)
    parts = (found.path, found.position, found.probability, found.covariance, future)
    processes.add_up([torch.from_numpy(part) for part in parts])
    return found, future


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
    with torch.inference_mode():
        for rows in _passes(windows, processes):
            inputs, future = windows.batch(rows)
            _, path = network(**tensors(inputs, device))
            errors[rows] = displacement_errors(path.cpu().numpy(), future)
    processes.add_up([torch.from_numpy(errors)])
    return errors


def _passes(windows: Windows, processes: Processes) -> list[NDArray[np.int64]]:
    """Rows of each pass that falls to this process."""
    passes = np.array_split(np.arange(len(windows)), math.ceil(len(windows) / ROWS))
    return passes[processes.rank :: processes.count]


def constant_velocity_errors(windows: Windows) -> NDArray[np.float64]:
    """(M, F) errors [m] of constant velocity on the same windows."""
    tracks = windows.tracks
    step, _ = last_step(tracks.own[:, :, None], tracks.own_valid[:, :, None])  # (M, 1, 2)
    ahead = np.arange(1, windows.config.forecast_steps + 1)[:, None]
    return displacement_errors(step * ahead, tracks.future)


def scores(errors: NDArray[np.float64]) -> dict[str, float]:
    """`ade` and `fde` [m]."""
    return {"ade": ade(errors), "fde": fde(errors)}
