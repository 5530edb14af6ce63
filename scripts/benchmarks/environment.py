"""Environment steps per second with each forecaster."""

import tempfile
from pathlib import Path
from typing import Any, Final

import gymnasium
import numpy as np
import torch
from gymnasium.vector import VectorEnv

import envs  # noqa: F401  (registers the environments)
from predictor.checkpoint import save_checkpoint
from predictor.config import named_configuration
from predictor.networks import build_network
from scripts.benchmarks.timing import seconds_per_call

ENVIRONMENTS: Final = (1, 16, 64)
PEDESTRIANS: Final = 20


def environment(seed: int) -> dict[str, list[dict[str, Any]]]:
    """Measure the batched environment: `PEDESTRIANS` people in `circular_crossing`, random actions.

    Observations, rewards and the resets of finished episodes are part of a step. Eight people are
    forecast. `iterative_attention, none` is the paper's network without a map, untrained: its time
    does not depend on its weights.

    Returns:
        `environment`: rows with `forecaster`, `environments`, `pedestrians` and `steps_per_s`,
        summed over the environments.
    """
    with tempfile.TemporaryDirectory() as folder:
        names = forecasters(Path(folder), seed)
        rows = [
            _measure(label, name, environments, seed)
            for label, name in names.items()
            for environments in ENVIRONMENTS
        ]
    return {"environment": rows}


def forecasters(folder: Path, seed: int) -> dict[str, str]:
    """What is measured, by its name in the table; `folder` is for the checkpoint of one of them."""
    mapless = folder / "none.safetensors"
    torch.manual_seed(seed)
    model, _ = named_configuration("paper", variant="none", seed=seed)
    save_checkpoint(mapless, build_network(model), {})
    return {
        "none": "none",
        "constant_velocity": "constant_velocity",
        "iterative_attention, none": str(mapless),
        "iterative_attention, patch": "iterative_attention",
        "fast": "fast",
    }


def make_vector(forecaster: str, environments: int) -> VectorEnv[Any, Any, Any]:
    """The batched environment that is measured."""
    return gymnasium.make_vec(
        "crowdnav/CrowdNav-v0",
        num_envs=environments,
        scenario="circular_crossing",
        scenario_parameters={"pedestrians": PEDESTRIANS},
        forecaster=forecaster,
    )


def _measure(label: str, forecaster: str, environments: int, seed: int) -> dict[str, Any]:
    vector = make_vector(forecaster, environments)
    vector.reset(seed=seed)
    shape = vector.action_space.shape
    assert shape is not None
    rng = np.random.default_rng(seed)

    def step() -> object:
        return vector.step(rng.uniform(-1.0, 1.0, shape).astype(np.float32))

    rate = environments / seconds_per_call(step)
    vector.close()
    return {
        "forecaster": label,
        "environments": environments,
        "pedestrians": PEDESTRIANS,
        "steps_per_s": round(rate, 1),
    }
