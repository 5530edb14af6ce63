"""What must hold for every robot and every forecaster, whatever learns or plans on top."""

import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from numpy.testing import assert_array_equal
from stable_baselines3.common.env_checker import check_env as sb3_check_env

from envs.config import CrowdNavConfig
from envs.policies import SIMPLE, make_policy

IDS = ("crowdnav/CrowdNav-v0", "crowdnav/CrowdNavFlat-v0")
ROBOTS = ("unicycle", "holonomic", "bicycle")
FORECASTERS = (
    "none",
    "constant_velocity",
    "constant_velocity_map",
    "social_force",
    "iterative_attention",
    "fast",
    "oracle",
    "oracle_noisy@sigma=0.3+delay=0.4+drop=0.2",
)
SMALL = {"scenario_parameters": {"pedestrians": 3}, "pedestrians_observed": 2, "horizon": 1.2}


@pytest.mark.parametrize("forecaster", FORECASTERS)
@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("env_id", IDS)
def test_the_checkers_have_nothing_to_say(env_id, robot, forecaster):
    env = gymnasium.make(env_id, robot=robot, forecaster=forecaster, **SMALL)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)
        if env_id == "crowdnav/CrowdNavFlat-v0":
            # For keys of rank 3 it has no network of its own, and says so.
            sb3_check_env(env)


@pytest.mark.parametrize("policy", SIMPLE)
@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("people", [0, 12])
def test_every_policy_copes_with_nobody_and_with_more_than_it_observes(
    people, robot, policy, scene
):
    row, column = np.divmod(np.arange(people), 4)
    places = np.stack((3.0 + row, column - 1.5), axis=1)
    name = scene(people=places, goals=-places)
    config = CrowdNavConfig(scenario=name, robot=robot, pedestrians_observed=4)
    env = gymnasium.make("crowdnav/CrowdNav-v0", scenario=name, robot=robot, pedestrians_observed=4)
    observation, _ = env.reset(seed=0)
    assert observation["neighbors_valid"].sum() == min(people, 4)
    planner = make_policy(policy, config)
    for _ in range(4):
        action = planner.act(observation)
        assert np.isfinite(action).all()
        assert np.abs(action).max() <= 1.0 + 1e-6
        observation, *_ = env.step(action)


@pytest.mark.parametrize("forecaster", FORECASTERS[1:])
def test_an_episode_after_another_is_as_if_it_were_the_first(forecaster):
    keywords = {
        "forecaster": forecaster,
        "time_limit": 1.0,
        "missed_detections": 0.4,
        "track_memory": 2.0,
        **SMALL,
    }
    used = gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=2, **keywords)
    fresh = gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=2, **keywords)
    rolling = np.tile(np.array([0.2, 0.1], dtype=np.float32), (2, 1))
    used.reset(seed=0)
    for _ in range(5):
        used.step(rolling)  # the last one ends both episodes and starts the next
    used.unwrapped._generators = [np.random.default_rng(seed) for seed in (8, 9)]
    fresh.unwrapped._generators = [np.random.default_rng(seed) for seed in (8, 9)]
    for observation, other in zip(used.reset(), fresh.reset(), strict=True):
        same(observation, other)
    for _ in range(4):
        same(used.step(rolling)[0], fresh.step(rolling)[0])


def same(observation, other):
    assert observation.keys() == other.keys()
    for key, values in observation.items():
        assert_array_equal(values, other[key], key)
