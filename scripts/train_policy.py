"""`crowdnav train-policy`: train a robot policy with PPO."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from jsonargparse.typing import NonNegativeInt, PositiveInt

from scripts.output import require_folder, write_json

if TYPE_CHECKING:
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecEnv

    from envs.config import CrowdNavConfig

UPDATE_STEPS = 16
"""Steps of every environment between two updates of the weights: many small updates reach the
goal in half the steps that few large ones need."""

LEARNING_RATE = 7e-4
"""At the start; it falls to 0 in a straight line."""

DISCOUNT = 0.98
"""Per step: 10 s ahead count 1/e."""


def train_policy(
    scenario: str = "circular_crossing",
    scenario_parameters: dict[str, Any] | None = None,
    robot: Literal["unicycle", "holonomic", "bicycle"] = "unicycle",
    forecaster: str = "constant_velocity",
    steps: PositiveInt = 500_000,
    environments: PositiveInt = 64,
    out: Path = Path("runs/policy"),
    seed: NonNegativeInt = 0,
) -> None:
    """Train a robot policy with PPO and store it as JSON and safetensors.

    The folder is what `--policies` of `evaluate` takes. `curve.json` in it holds the return and
    the success of the latest 100 episodes after every update.

    Args:
        scenario: Name of the scenario to train in.
        scenario_parameters: Keywords of the scenario, such as {"pedestrians": 5}.
        robot: Kind of robot.
        forecaster: `none`, `constant_velocity`, `fast`, `iterative_attention` or a checkpoint.
        steps: Environment steps of all environments together; rounded up to whole updates.
        environments: Environments side by side.
        out: Folder of the policy.
        seed: Seed of the weights, the exploration and the episodes.
    """
    require_folder(out)
    import torch

    from envs.config import make_config
    from envs.policies.ppo import save_ppo

    torch.set_num_threads(1)
    config = make_config(
        scenario=scenario,
        scenario_parameters={} if scenario_parameters is None else scenario_parameters,
        robot=robot,
        forecaster=forecaster,
    )
    model = make_model(make_environment(config, environments, seed), seed)
    curve = learn(model, steps, progress_bar=True)
    training = {"steps": model.num_timesteps, "environments": environments, "seed": seed}
    save_ppo(model, out, config=config, training=training | {"curve": curve[-1:]})
    write_json(out / "curve.json", curve)
    print(report(curve, out))


def make_environment(config: "CrowdNavConfig", environments: int, seed: int) -> "VecEnv":
    """Environments side by side, as Stable-Baselines3 takes them, seeded for training.

    Rewards are divided by the spread of the returns; the curve shows them as they are. The
    episodes' seeds are drawn, so that they are not the small numbers of an evaluation.
    """
    from dataclasses import asdict

    import gymnasium
    import numpy as np
    from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

    from envs.sb3 import SB3VecEnv

    vector = gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=environments, **asdict(config))
    env = VecMonitor(SB3VecEnv(vector), info_keywords=("is_success",))
    env.seed(int(np.random.SeedSequence(seed).generate_state(1)[0]))
    return VecNormalize(env, norm_obs=False, gamma=DISCOUNT)


def make_model(env: "VecEnv", seed: int) -> "PPO":
    """An untrained PPO model for these environments."""
    from stable_baselines3 import PPO
    from stable_baselines3.common.utils import set_random_seed

    from envs.policies.ppo import policy_keywords

    # Not PPO's own `seed`: that would seed the episodes, too, with the numbers seed + i.
    set_random_seed(seed)
    return PPO(
        "MultiInputPolicy",
        env,
        learning_rate=lambda left: left * LEARNING_RATE,
        n_steps=UPDATE_STEPS,
        batch_size=min(256, UPDATE_STEPS * env.num_envs),
        n_epochs=4,
        gamma=DISCOUNT,
        policy_kwargs=policy_keywords() | {"log_std_init": -0.5},
        device="cpu",
    )


def learn(model: "PPO", steps: int, *, progress_bar: bool) -> list[dict[str, float]]:
    """Train in place and return the learning curve, a point after every collection of episodes."""
    from stable_baselines3.common.callbacks import BaseCallback

    class Curve(BaseCallback):
        def __init__(self) -> None:
            super().__init__()
            self.points: list[dict[str, float]] = []

        def _on_step(self) -> bool:
            return True

        def _on_rollout_end(self) -> None:
            latest = self.model.ep_info_buffer
            if latest:
                self.points.append(curve_point(self.num_timesteps, list(latest)))

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
