import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from numpy.testing import assert_array_equal
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecMonitor

from envs.sb3 import SB3VecEnv
from envs.vector import CrowdNavFlatVector, CrowdNavVector

STAND = np.tile(np.array([-1.0, 0.0], dtype=np.float32), (2, 1))


def test_what_ends_in_time_is_marked_as_truncated_and_keeps_its_last_observation():
    env = SB3VecEnv(CrowdNavVector(2, forecaster="none", time_limit=1.0, robot_visible=False))
    env.seed(3)
    env.reset()
    for _ in range(5):
        observation, reward, done, infos = env.step(STAND)
    assert done.all()
    assert reward.shape == (2,)
    for world, info in enumerate(infos):
        assert info["TimeLimit.truncated"] is True
        assert info["is_success"] is False
        assert info["termination_reason"] == "timeout"
        last = info["terminal_observation"]["history"]
        assert (last != observation["history"][world]).any()
        assert last.shape == (8, 8, 2)


def test_a_collision_is_no_time_limit():
    env = SB3VecEnv(CrowdNavVector(2, forecaster="none"))
    env.seed(0)
    env.reset()
    ahead = np.tile(np.array([1.0, 0.0], dtype=np.float32), (2, 1))
    seen = []
    while not seen:
        *_, done, infos = env.step(ahead)
        seen = [info for info, ended in zip(infos, done, strict=True) if ended]
    assert seen[0]["termination_reason"] == "collision_pedestrian"
    assert seen[0]["TimeLimit.truncated"] is False


def test_seeds_reach_the_environments():
    env = SB3VecEnv(CrowdNavVector(2))
    env.seed(9)
    observation = env.reset()
    single, _ = gymnasium.make("crowdnav/CrowdNav-v0").reset(seed=10)
    assert_array_equal(observation["history"][1], single["history"])


def test_ppo_learns_a_little_through_it():
    env = VecMonitor(SB3VecEnv(CrowdNavFlatVector(4, forecaster="constant_velocity")))
    model = PPO("MultiInputPolicy", env, n_steps=32, batch_size=64, n_epochs=1, seed=0)
    model.learn(256)
    assert model.num_timesteps == 256
    assert len(model.ep_info_buffer) > 0


def test_it_wants_resets_within_the_step():
    next_step = SyncVectorEnv([lambda: gymnasium.make("crowdnav/CrowdNav-v0", forecaster="none")])
    assert next_step.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    with pytest.raises(ValueError, match="SAME_STEP"):
        SB3VecEnv(next_step)
