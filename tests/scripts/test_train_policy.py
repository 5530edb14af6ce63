import json
from dataclasses import replace

import numpy as np
import pytest
import torch

from envs.config import CrowdNavConfig
from envs.policies import make_policy
from envs.policies.hyperparameters import read_hyperparameters
from envs.policies.networks import ALGORITHMS
from envs.policies.policy_files import own_weights, save_policy
from scripts.train_policy import (
    curve_point,
    go_on_from,
    learn,
    make_environment,
    make_model,
    schedule,
)

EASY = CrowdNavConfig(
    scenario_parameters={"pedestrians": 0, "radius": 2.0},
    forecaster="none",
    robot="holonomic",
    time_limit=10.0,
)
ON_POLICY = {"n_steps": 32, "batch_size": 64}
OFF_POLICY = {"learning_starts": 64, "buffer_size": 512, "batch_size": 64, "gradient_steps": 1}
SHORT = {
    "ppo": ON_POLICY,
    "recurrent_ppo": ON_POLICY,
    "sac": OFF_POLICY,
    "tqc": OFF_POLICY,
}


def short_model(algorithm, environments=4, **changes):
    usual = read_hyperparameters(algorithm)
    short = replace(usual, keywords={**usual.keywords, **SHORT[algorithm], **changes})
    return make_model(short, EASY, environments=environments, seed=0)


def test_ppo_learns_to_drive_to_the_goal():
    model = short_model("ppo", environments=16, n_steps=64, batch_size=256)
    curve = learn(model, steps=8_192, progress_bar=False)
    assert curve[-1]["episodes"] == 100
    assert curve[-1]["mean_return"] > curve[0]["mean_return"] + 3.0


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_every_algorithm_is_trained_stored_and_acts_as_its_model_does(tmp_path, algorithm):
    model = short_model(algorithm)
    before = {name: value.clone() for name, value in own_weights(model.policy).items()}
    learn(model, steps=256, progress_bar=False)
    after = own_weights(model.policy)
    assert all(bool(torch.isfinite(value).all()) for value in after.values())
    assert any(not torch.equal(before[name], value) for name, value in after.items())

    save_policy(model, tmp_path, config=EASY, training={})
    env = make_environment(EASY, environments=8, seed=1)
    observation, policy, state = env.reset(), make_policy(str(tmp_path), EASY), None
    for _ in range(3):
        expected, state = model.predict(observation, state=state, deterministic=True)
        np.testing.assert_array_equal(policy.act(observation), expected)
        observation, *_ = env.step(expected)


def test_training_goes_on_from_a_stored_policy(tmp_path):
    first, second = short_model("ppo"), short_model("ppo")
    learn(first, steps=256, progress_bar=False)
    save_policy(first, tmp_path, config=EASY, training={"steps": 256})
    before = go_on_from(second, tmp_path, EASY)
    assert before["environment"]["robot"] == "holonomic"
    assert before["training"] == {"steps": 256}
    expected = own_weights(first.policy)
    assert all(
        torch.equal(value, expected[name]) for name, value in own_weights(second.policy).items()
    )


def test_training_goes_on_from_a_fitting_policy_only(tmp_path):
    save_policy(short_model("ppo"), tmp_path, config=EASY, training={})
    with pytest.raises(ValueError, match="does not fit the network"):
        go_on_from(short_model("sac"), tmp_path, EASY)
    with pytest.raises(ValueError, match="was trained with the observation"):
        go_on_from(short_model("ppo"), tmp_path, replace(EASY, lidar_rays=32))


@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_the_same_seed_trains_the_same_weights(algorithm):
    weights = []
    for _ in range(2):
        model = short_model(algorithm)
        learn(model, steps=256, progress_bar=False)
        weights.append(own_weights(model.policy))
    assert all(torch.equal(value, weights[1][name]) for name, value in weights[0].items())


def test_the_curve_has_a_point_every_thousand_steps():
    curve = learn(short_model("sac", learning_starts=10_000), 2_200, progress_bar=False)
    assert [point["step"] for point in curve] == [1_000, 2_000]


@pytest.mark.filterwarnings("ignore:rich is experimental")
def test_the_command_leaves_a_policy_that_acts(crowdnav, tmp_path):
    outcome = crowdnav(
        "train-policy",
        "--algorithm=recurrent_ppo",
        "--scenario_parameters.pedestrians=2",
        '--environment={"horizon": 1.2}',
        "--steps=256",
        "--environments=4",
        f"--out={tmp_path}",
    )
    assert outcome.status == 0
    assert "policy in" in outcome.out
    training = json.loads((tmp_path / "policy.json").read_text())["training"]
    assert training["steps"] == 256
    assert training["hyperparameters"]["algorithm"] == "recurrent_ppo"
    config = CrowdNavConfig(scenario_parameters={"pedestrians": 2}, horizon=1.2)
    assert make_policy(str(tmp_path), config).name == "recurrent_ppo"


def test_a_learning_rate_can_fall_in_a_straight_line():
    assert schedule(0.25) == 0.25
    assert [schedule("lin_0.25")(left) for left in (1.0, 0.5, 0.0)] == [0.25, 0.125, 0.0]


def test_a_point_of_the_curve_is_the_mean_of_the_latest_episodes():
    episodes = [{"r": 4.0, "is_success": True}, {"r": -1.0, "is_success": False}]
    assert curve_point(64, episodes) == {
        "step": 64,
        "episodes": 2,
        "mean_return": 1.5,
        "success": 0.5,
    }
