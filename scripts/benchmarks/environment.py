"""Environment steps per second with each forecaster."""

from typing import Any, Final

import gymnasium
import numpy as np

import envs  # noqa: F401  (registers the environments)
from scripts.benchmarks.timing import seconds_per_call

FORECASTERS: Final = ("none", "constant_velocity", "iterative_attention")
ENVIRONMENTS: Final = (1, 16)
PEDESTRIANS: Final = 20


def environment(seed: int) -> dict[str, list[dict[str, Any]]]:
    """Measure the batched environment: `PEDESTRIANS` people in `circular_crossing`, random actions.

    Observations, rewards and the resets of finished episodes are part of a step.

    Returns:
        `environment`: rows with `forecaster`, `environments`, `pedestrians` and `steps_per_s`,
        summed over the environments.
    """
    return {
        "environment": [
            _measure(forecaster, environments, seed)
            for forecaster in FORECASTERS
            for environments in ENVIRONMENTS
        ]
    }


def _measure(forecaster: str, environments: int, seed: int) -> dict[str, Any]:
    vector = gymnasium.make_vec(
        "crowdnav/CrowdNav-v0",
        num_envs=environments,
        scenario="circular_crossing",
        scenario_parameters={"pedestrians": PEDESTRIANS},
        forecaster=forecaster,
    )
    vector.reset(seed=seed)
    shape = vector.action_space.shape
    assert shape is not None
    rng = np.random.default_rng(seed)

    def step() -> object:
        return vector.step(rng.uniform(-1.0, 1.0, shape).astype(np.float32))

    rate = environments / seconds_per_call(step)
    vector.close()
    return {
        "forecaster": forecaster,
        "environments": environments,
        "pedestrians": PEDESTRIANS,
        "steps_per_s": round(rate, 1),
    }
