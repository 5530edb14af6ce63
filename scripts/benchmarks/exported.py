"""Time of one forecast by ONNX Runtime, beside torch."""

import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np

from predictor.export import export_network
from predictor.model import IterativeAttention
from predictor.network_forecaster import NetworkForecaster
from predictor.networks import name_of
from scripts.benchmarks.forecast import NETWORKS, one_forecast, untrained
from scripts.benchmarks.timing import seconds_in_turn

AGENTS: Final = (8, 50, 200)


def exported(seed: int) -> dict[str, list[dict[str, Any]]]:
    """Measure one call of the forecaster for all people of one world, inputs included.

    Returns:
        `exported`: rows with `configuration`, `variant`, `agents`, the medians `torch_ms` and
        `onnx_ms`, and `ratio`, the median of how many times as long torch took.
    """
    rows = []
    for name, variant in NETWORKS:
        network = untrained(name, variant, seed)
        ours, theirs = NetworkForecaster(network), _by_onnx_runtime(network)
        for agents in AGENTS:
            calls = [one_forecast(forecaster, agents, seed) for forecaster in (ours, theirs)]
            seconds = seconds_in_turn(calls)
            torch_ms, onnx_ms = 1e3 * np.median(seconds, axis=1)
            row: dict[str, Any] = {"configuration": name, "variant": variant, "agents": agents}
            row |= {"torch_ms": round(float(torch_ms), 3), "onnx_ms": round(float(onnx_ms), 3)}
            rows.append(row | {"ratio": round(float(np.median(seconds[0] / seconds[1])), 2)})
    return {"exported": rows}


def _by_onnx_runtime(network: IterativeAttention) -> NetworkForecaster:
    """A forecaster with the network exported and read again."""
    about = {"model": name_of(network.config), "config": asdict(network.config)}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "network.onnx"
        export_network(network.eval(), about, file)
        return NetworkForecaster.from_checkpoint(file)
