"""`crowdnav train-policy`: train a robot policy by reinforcement learning."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from jsonargparse.typing import NonNegativeInt, PositiveInt

from scripts.output import require_folder, write_json

if TYPE_CHECKING:
    from collections.abc import Callable

    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.vec_env import VecEnv

    from envs.config import CrowdNavConfig
    from envs.policies.hyperparameters import Hyperparameters

CURVE_STEPS = 1000
"""Environment steps between two points of the learning curve, at least."""


def train_policy(
    algorithm: Literal["ppo", "recurrent_ppo", "sac", "tqc"] = "ppo",
    scenario: str = "circular_crossing",
    scenario_parameters: dict[str, Any] | None = None,
    robot: Literal["unicycle", "holonomic", "bicycle"] = "unicycle",
    forecaster: str = "constant_velocity",
    environment: dict[str, Any] | None = None,
    steps: PositiveInt | None = None,
    environments: PositiveInt | None = None,
    start: Path | None = None,
    out: Path = Path("runs/policy"),
    seed: NonNegativeInt = 0,
) -> None:
    """Train a robot policy and store it as JSON and safetensors.

    The folder is what `--policies` of `evaluate` takes. `curve.json` in it holds the return and
    the success of the latest 100 episodes as training went on. The hyperparameters are those of
    `envs/policies/zoo`, which RL Zoo reads as well.

    Args:
        algorithm: What trains it; `recurrent_ppo` gives it an LSTM, `sac` and `tqc` learn from
            stored steps, which takes longer.
        scenario: Name of the scenario to train in; of several joined by `+` each episode draws one.
        scenario_parameters: Keywords of the scenario, such as {"pedestrians": 5}.
        robot: Kind of robot.
        forecaster: `none`, `constant_velocity`, `fast`, `iterative_attention` or a checkpoint.
        environment: Further keywords of the environment, such as {"horizon": 2.4}.
        steps: Environment steps of all environments together, rounded up to whole updates, instead
            of the algorithm's own number.
        environments: Environments side by side, instead of the algorithm's own number.
        start: Folder of a policy of the same algorithm to go on from, in another scenario, say.
        out: Folder of the policy.
        seed: Seed of the weights, the exploration and the episodes.
    """
    require_folder(out)
    from dataclasses import asdict

    import torch

    from envs.config import make_config
    from envs.policies.hyperparameters import read_hyperparameters
    from envs.policies.policy_files import save_policy

    torch.set_num_threads(1)
    config = make_config(
        **{
            "scenario": scenario,
            "scenario_parameters": {} if scenario_parameters is None else scenario_parameters,
            "robot": robot,
            "forecaster": forecaster,
        }
        | ({} if environment is None else environment)
    )
    hyperparameters = read_hyperparameters(algorithm)
    if steps is None:
        steps = hyperparameters.steps
    if environments is None:
        environments = hyperparameters.environments
    model = make_model(hyperparameters, config, environments=environments, seed=seed)
    before = None if start is None else go_on_from(model, start, config)
    curve = learn(model, steps, progress_bar=True)
    training = {
        "before": before,
        "steps": model.num_timesteps,
        "environments": environments,
        "seed": seed,
        "hyperparameters": asdict(hyperparameters),
        "curve": curve[-1:],
    }
    save_policy(model, out, config=config, training=training)
    write_json(out / "curve.json", curve)
    print(report(curve, out))


def make_environment(config: "CrowdNavConfig", environments: int, seed: int) -> "VecEnv":
    """Environments side by side, as Stable-Baselines3 takes them, seeded for training.

    The episodes' seeds are drawn, so that they are not the small numbers of an evaluation.
    """
    from dataclasses import asdict

    import gymnasium
    import numpy as np
    from stable_baselines3.common.vec_env import VecMonitor

    from envs.sb3 import SB3VecEnv

    vector = gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=environments, **asdict(config))
    env = VecMonitor(SB3VecEnv(vector), info_keywords=("is_success",))
    env.seed(int(np.random.SeedSequence(seed).generate_state(1)[0]))
    return env


def make_model(
    hyperparameters: "Hyperparameters", config: "CrowdNavConfig", *, environments: int, seed: int
) -> "BaseAlgorithm":
    """An untrained model with environments of its own, all seeded."""
    from stable_baselines3.common.utils import set_random_seed
    from stable_baselines3.common.vec_env import VecNormalize

    from envs.policies.networks import ALGORITHMS

    keywords = dict(hyperparameters.keywords)
    keywords["learning_rate"] = schedule(keywords["learning_rate"])
    keywords["policy_kwargs"] = {
        **keywords["policy_kwargs"],
        "features_extractor_kwargs": {"frame_dt": config.frame_dt},
    }
    # Not the model's own `seed`: that would seed the episodes, too, with the numbers seed + i.
    set_random_seed(seed)
    env = make_environment(config, environments, seed)
    env.action_space.seed(seed)
    if hyperparameters.normalize is not None:
        env = VecNormalize(env, gamma=keywords["gamma"], **hyperparameters.normalize)
    algorithm = ALGORITHMS[hyperparameters.algorithm]
    return algorithm.model(algorithm.network, env, device="cpu", **keywords)


def go_on_from(model: "BaseAlgorithm", folder: Path, config: "CrowdNavConfig") -> dict[str, Any]:
    """Give a model the weights of a stored policy; critics that it has not stored stay new.

    Returns:
        Where and how that policy was trained, for the record.

    Raises:
        ValueError: The folder holds no policy, or one of another network or observation.
    """
    from envs.policies.policy_files import check_fits, load_weights, read_description

    description = read_description(folder)
    check_fits(description, config, folder)
    load_weights(model.policy, folder, description)
    return {key: description[key] for key in ("environment", "training")}


def schedule(learning_rate: float | str) -> "float | Callable[[float], float]":
    """RL Zoo's `lin_0.001`, which falls to 0, as Stable-Baselines3 takes it; or the constant."""
    if not isinstance(learning_rate, str):
        return learning_rate
    first = float(learning_rate.removeprefix("lin_"))
    return lambda left: left * first


def learn(model: "BaseAlgorithm", steps: int, *, progress_bar: bool) -> list[dict[str, float]]:
    """Train in place and return the learning curve, a point every `CURVE_STEPS` or more."""
    from stable_baselines3.common.callbacks import BaseCallback

    class Curve(BaseCallback):
        def __init__(self) -> None:
            super().__init__()
            self.points: list[dict[str, float]] = []
            self.next_step = CURVE_STEPS

        def _on_step(self) -> bool:
            return True

        def _on_rollout_end(self) -> None:
            latest = self.model.ep_info_buffer
            if latest and self.num_timesteps >= self.next_step:
                self.points.append(curve_point(self.num_timesteps, list(latest)))
                self.next_step = self.num_timesteps + CURVE_STEPS

    curve = Curve()
    model.learn(steps, callback=curve, progress_bar=progress_bar)
    return curve.points


def curve_point(step: int, episodes: list[dict[str, Any]]) -> dict[str, float]:
    """Mean return and success of the latest episodes, at most 100 of them."""
    count = len(episodes)
    return {
        "step": step,
        "episodes": count,
        "mean_return": round(float(sum(episode["r"] for episode in episodes)) / count, 3),
        "success": round(sum(bool(episode["is_success"]) for episode in episodes) / count, 3),
    }


def report(curve: list[dict[str, float]], out: Path) -> str:
    """What came out, in one line."""
    if not curve:
        return f"too few steps to finish an episode; policy in {out}"
    first, last = curve[0], curve[-1]
    return (
        f"mean return {first['mean_return']} -> {last['mean_return']}, success "
        f"{first['success']} -> {last['success']} over the latest {last['episodes']} episodes; "
        f"policy in {out}"
    )
