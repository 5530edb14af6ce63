import json

import gymnasium
import numpy as np
import pytest
from hand_made_observations import add_person, empty_observation, stack
from stable_baselines3 import PPO

from envs.config import CrowdNavConfig
from envs.observation import observation_space
from envs.policies import make_policy
from envs.policies.ppo import (
    DESCRIPTION,
    WEIGHTS,
    PPOPolicy,
    box_from_json,
    policy_keywords,
    save_ppo,
)
from envs.robots import action_space

CONFIG = CrowdNavConfig(pedestrians_observed=3)
MAP_CONFIG = CrowdNavConfig(pedestrians_observed=3, forecaster="none", observe_map=True)


class Standstill(gymnasium.Env):
    """Spaces of the environment, and nothing behind them."""

    def __init__(self, config):
        self.observation_space = observation_space(config)
        self.action_space = action_space(config)


def untrained(config):
    return PPO(
        "MultiInputPolicy",
        Standstill(config),
        policy_kwargs=policy_keywords(),
        n_steps=8,
        batch_size=8,
        seed=0,
        device="cpu",
    )


def random_observations(config, count, seed=0):
    rng = np.random.default_rng(seed)
    observations = []
    for _ in range(count):
        one = empty_observation(config, goal=rng.uniform(-8, 8, 2))
        for slot in range(2):
            add_person(one, config, slot, rng.uniform(-4, 4, 2), rng.uniform(-1, 1, 2))
        if "map" in one:
            one["map"][:] = rng.integers(0, 256, one["map"].shape)
        observations.append(one)
    return stack(observations)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("policy")
    save_ppo(untrained(CONFIG), path, config=CONFIG, training={"steps": 0})
    return path


@pytest.mark.parametrize("config", [CONFIG, MAP_CONFIG])
def test_a_saved_policy_acts_as_the_model_did(tmp_path, config):
    model, observations = untrained(config), random_observations(config, 8)
    save_ppo(model, tmp_path, config=config, training={})
    expected, _ = model.predict(observations, deterministic=True)
    actions = make_policy(str(tmp_path), config).act(observations)
    assert np.ptp(actions) > 0.0
    np.testing.assert_array_equal(actions, expected)


def test_actions_do_not_depend_on_how_many_worlds_are_shown(folder):
    policy, observations = PPOPolicy(folder), random_observations(CONFIG, 11)
    batch = policy.act(observations)
    for world in range(11):
        single = {key: value[world] for key, value in observations.items()}
        np.testing.assert_array_equal(policy.act(single), batch[world])


def test_the_order_of_people_does_not_matter(folder):
    policy, observations = PPOPolicy(folder), random_observations(CONFIG, 4)
    people = ["history", "history_valid", "forecast", "neighbors_valid", "neighbors_radius"]
    shuffled = observations | {key: observations[key][:, [2, 1, 0]] for key in people}
    np.testing.assert_allclose(policy.act(shuffled), policy.act(observations), atol=1e-6)


def test_a_place_without_people_gives_finite_actions(folder):
    assert np.isfinite(PPOPolicy(folder).act(empty_observation(CONFIG))).all()


@pytest.fixture
def copy(folder, tmp_path):
    for name in (DESCRIPTION, WEIGHTS):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    return tmp_path


def test_damaged_weights_are_refused(copy):
    weights = bytearray((copy / WEIGHTS).read_bytes())
    weights[-7] ^= 1
    (copy / WEIGHTS).write_bytes(weights)
    with pytest.raises(ValueError, match="damaged: expected SHA-256"):
        PPOPolicy(copy)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("format", "other", "crowdnav-ppo"),
        ("layers", [64, 32], "does not fit"),
        ("layers", [10**9], "layers"),
        ("action_space", {"shape": [2]}, "malformed"),
    ],
)
def test_a_wrong_description_is_refused(copy, key, value, message):
    description = json.loads((copy / DESCRIPTION).read_text())
    (copy / DESCRIPTION).write_text(json.dumps(description | {key: value}))
    with pytest.raises(ValueError, match=message):
        PPOPolicy(copy)


def test_an_implausibly_large_space_is_refused_before_it_is_allocated():
    with pytest.raises(ValueError, match="larger than"):
        box_from_json("history", {"shape": [10**6] * 2, "dtype": "float32", "low": 0, "high": 1})


@pytest.mark.parametrize(
    "config",
    [
        CrowdNavConfig(pedestrians_observed=3, robot="holonomic"),
        CrowdNavConfig(pedestrians_observed=3, forecaster="none"),
        CrowdNavConfig(pedestrians_observed=3, horizon=9.6),
    ],
)
def test_a_policy_is_refused_where_it_does_not_fit(folder, config):
    with pytest.raises(ValueError, match="was trained"):
        make_policy(str(folder), config)


def test_a_missing_key_is_named(folder):
    observation = empty_observation(CONFIG)
    del observation["forecast"]
    with pytest.raises(ValueError, match="trained with forecast"):
        PPOPolicy(folder).act(observation)
