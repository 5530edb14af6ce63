"""Other people's training loops run on the environment as it is."""

import os
import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.wrappers import (
    ClipAction,
    FlattenObservation,
    NormalizeObservation,
    NormalizeReward,
    RecordEpisodeStatistics,
    TransformObservation,
    TransformReward,
)

SHORT = {"time_limit": 1.0, "horizon": 1.2}
ROOT = Path(__file__).parents[2]
OLD_GYMNASIUM = Path(sys.prefix) / "gymnasium-0.29.1"


def as_cleanrl_makes_it():
    """The wrappers of CleanRL's `ppo_continuous_action.py`, in its order."""
    env = gymnasium.make("envs:crowdnav/CrowdNav-v0", **SHORT)
    env = RecordEpisodeStatistics(FlattenObservation(env))
    env = NormalizeObservation(ClipAction(env))
    env = TransformObservation(env, lambda seen: np.clip(seen, -10, 10), env.observation_space)
    return TransformReward(NormalizeReward(env, gamma=0.99), lambda gain: np.clip(gain, -10, 10))


def test_the_wrappers_of_cleanrl_give_what_its_loop_reads():
    envs = gymnasium.vector.SyncVectorEnv(
        [as_cleanrl_makes_it] * 2, autoreset_mode=gymnasium.vector.AutoresetMode.SAME_STEP
    )
    seen, _ = envs.reset(seed=1)
    size = envs.single_observation_space.shape[0]
    actor = torch.nn.Linear(size, 2)
    for _ in range(5):
        assert seen.shape == (2, size)
        action = torch.distributions.Normal(actor(torch.Tensor(seen)), 1.0).sample()
        seen, reward, terminated, truncated, infos = envs.step(action.numpy())
        assert np.isfinite(reward).all()
    assert truncated.all()
    assert not terminated.any()
    assert infos["final_info"]["_episode"].all()
    np.testing.assert_array_equal(infos["final_info"]["episode"]["l"], [5, 5])


AS_CLEANRL_PINNED_IT = """
import gymnasium as gym, numpy as np

def make():
    env = gym.make("envs:crowdnav/CrowdNav-v0", time_limit=1.0, horizon=1.2)
    env = gym.wrappers.RecordEpisodeStatistics(gym.wrappers.FlattenObservation(env))
    env = gym.wrappers.NormalizeObservation(gym.wrappers.ClipAction(env))
    env = gym.wrappers.TransformObservation(env, lambda seen: np.clip(seen, -10, 10))
    env = gym.wrappers.NormalizeReward(env, gamma=0.99)
    return gym.wrappers.TransformReward(env, lambda gain: np.clip(gain, -10, 10))

envs = gym.vector.SyncVectorEnv([make] * 2)
seen, _ = envs.reset(seed=1)
draw = np.random.default_rng(1)
for _ in range(5):
    assert seen.shape == (2, envs.single_observation_space.shape[0])
    assert np.isfinite(seen).all()
    seen, reward, terminated, truncated, infos = envs.step(draw.normal(size=(2, 2)))
    assert np.isfinite(reward).all()
print(gym.__version__, truncated, [info["episode"]["l"].tolist() for info in infos["final_info"]])
try:
    from envs.sb3 import SB3VecEnv
except ImportError as error:
    print(error)
"""


@pytest.mark.skipif(
    not OLD_GYMNASIUM.exists(), reason=f"needs {OLD_GYMNASIUM}, which `make test` installs"
)
def test_the_gymnasium_that_cleanrl_pinned_runs_the_single_environment():
    path = os.pathsep.join([str(OLD_GYMNASIUM), str(ROOT)])
    run = subprocess.run(
        [sys.executable, "-c", AS_CLEANRL_PINNED_IT],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    finished, refused = run.stdout.splitlines()[-2:]
    assert finished == "0.29.1 [ True  True] [[5], [5]]"
    assert "needs Gymnasium 1.1 or later" in refused


def test_ppo_of_skrl_trains_on_the_batched_environment(tmp_path):
    pytest.importorskip("skrl", reason="skrl is not installed")
    from skrl.agents.torch.ppo import PPO
    from skrl.envs.wrappers.torch import wrap_env
    from skrl.memories.torch import RandomMemory
    from skrl.trainers.torch import SequentialTrainer

    env = wrap_env(gymnasium.make_vec("envs:crowdnav/CrowdNav-v0", num_envs=2, **SHORT))
    spaces = {"observation_space": env.observation_space, "action_space": env.action_space}
    policy, value = skrl_models(gymnasium.spaces.flatdim(env.observation_space))
    models = {"policy": policy(**spaces), "value": value(**spaces)}
    before = models["policy"].layer.weight.detach().clone()
    quiet = {"directory": str(tmp_path), "write_interval": 0, "checkpoint_interval": 0}
    agent = PPO(
        models=models,
        memory=RandomMemory(memory_size=8, num_envs=2),
        cfg={"rollouts": 8, "learning_epochs": 1, "experiment": quiet},
        **spaces,
    )
    run = {"timesteps": 16, "disable_progressbar": True, "headless": True}
    run["close_environment_at_exit"] = False  # after the test, when there is nothing to log to
    SequentialTrainer(env=env, agents=agent, cfg=run).train()
    after = models["policy"].layer.weight
    assert torch.isfinite(after).all()
    assert not torch.equal(after, before)


def skrl_models(size):
    """The smallest policy and value that skrl takes."""
    from skrl.models.torch import DeterministicMixin, GaussianMixin, Model

    class Policy(GaussianMixin, Model):
        def __init__(self, **spaces):
            Model.__init__(self, **spaces)
            GaussianMixin.__init__(self)
            self.layer = torch.nn.Linear(size, 2)
            self.log_std = torch.nn.Parameter(torch.zeros(2))

        def compute(self, inputs, role):
            return self.layer(inputs["observations"]), {"log_std": self.log_std}

    class Value(DeterministicMixin, Model):
        def __init__(self, **spaces):
            Model.__init__(self, **spaces)
            DeterministicMixin.__init__(self)
            self.layer = torch.nn.Linear(size, 1)

        def compute(self, inputs, role):
            return self.layer(inputs["observations"]), {}

    return Policy, Value
