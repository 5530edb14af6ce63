"""Environment steps per second that PPO collects through the adapter to Stable-Baselines3."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv, VecMonitor

from envs.sb3 import SB3VecEnv
from scripts.benchmarks.environment import make_vector
from scripts.benchmarks.timing import seconds_in_turn

ENVIRONMENTS: Final = 64
FORECASTER: Final = "constant_velocity"
STEPS: Final = 8
"""Steps of every environment in one rollout."""


def collection(seed: int) -> dict[str, list[dict[str, Any]]]:
    """Measure rollouts of `ENVIRONMENTS` environments, one way after the other.

    * `vector`: the batched environment, random actions.
    * `adapter`: the same behind `SB3VecEnv` and `VecMonitor`.
    * `PPO`: the rollouts of PPO with Stable-Baselines3's own policy for dictionaries.
    * `PPO alone`: the same with an environment that costs nothing, always at its first observation.

    Returns:
        `collection`: rows with `way`, `forecaster`, `environments`, `steps_per_s` and `ratio`, the
        median of the rates as shares of the one of `vector`.
    """
    ways = _ways(seed)
    seconds = seconds_in_turn(list(ways.values())) / (STEPS * ENVIRONMENTS)
    return {
        "collection": [
            {
                "way": way,
                "forecaster": FORECASTER,
                "environments": ENVIRONMENTS,
                "steps_per_s": round(1.0 / float(np.median(own)), 1),
                "ratio": round(float(np.median(seconds[0] / own)), 2),
            }
            for way, own in zip(ways, seconds, strict=True)
        ]
    }


def _ways(seed: int) -> dict[str, Callable[[], object]]:
    """Each makes one rollout."""
    vector = make_vector(FORECASTER, ENVIRONMENTS)
    vector.reset(seed=seed)
    adapter, collected = _adapter(seed), _adapter(seed)
    rng = np.random.default_rng(seed)

    def roll(step: Callable[[NDArray[np.float32]], object]) -> Callable[[], object]:
        shape = (STEPS, ENVIRONMENTS, 2)
        return lambda: [step(act) for act in rng.uniform(-1.0, 1.0, shape).astype(np.float32)]

    adapter.reset()
    return {
        "vector": roll(vector.step),
        "adapter": roll(adapter.step),
        "PPO": _collector(collected, seed),
        "PPO alone": _collector(_Still(make_vector(FORECASTER, ENVIRONMENTS), seed), seed),
    }


def _adapter(seed: int) -> VecEnv:
    env = VecMonitor(SB3VecEnv(make_vector(FORECASTER, ENVIRONMENTS)))
    env.seed(seed)
    return env


def _collector(env: VecEnv, seed: int) -> Callable[[], object]:
    class Collector(PPO):
        def train(self) -> None:
            """Learns nothing."""

    model = Collector("MultiInputPolicy", env, n_steps=STEPS, seed=seed, device="cpu")
    return lambda: model.learn(STEPS * ENVIRONMENTS, reset_num_timesteps=False)


class _Still(SB3VecEnv):
    """Environments in which nothing happens."""

    def __init__(self, env: VectorEnv[Any, Any, Any], seed: int):
        super().__init__(env)
        self._first, _ = env.reset(seed=seed)

    def reset(self) -> Any:
        return self._first

    def step_wait(self) -> Any:
        nothing = np.zeros(self.num_envs)
        return self._first, nothing, nothing > 0.0, [{} for _ in range(self.num_envs)]
