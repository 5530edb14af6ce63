import json

import pytest

from envs.config import CrowdNavConfig
from envs.policies import make_policy
from scripts.train_policy import curve_point, learn, make_environment, make_model

EASY = CrowdNavConfig(
    scenario_parameters={"pedestrians": 0, "radius": 2.0},
    forecaster="none",
    robot="holonomic",
    time_limit=10.0,
)


def test_ppo_learns_to_drive_to_the_goal():
    model = make_model(make_environment(EASY, environments=16, seed=0), seed=0)
    curve = learn(model, steps=8_192, progress_bar=False)
    assert curve[-1]["episodes"] == 100
    assert curve[-1]["mean_return"] > curve[0]["mean_return"] + 3.0


@pytest.mark.filterwarnings("ignore:rich is experimental")
def test_the_command_leaves_a_policy_that_acts(crowdnav, tmp_path):
    outcome = crowdnav(
        "train-policy",
        "--scenario_parameters.pedestrians=2",
        "--steps=256",
        "--environments=2",
        f"--out={tmp_path}",
    )
    assert outcome.status == 0
    assert "policy in" in outcome.out
    assert json.loads((tmp_path / "policy.json").read_text())["training"]["steps"] == 256
    config = CrowdNavConfig(scenario_parameters={"pedestrians": 2})
    assert make_policy(str(tmp_path), config).name == "ppo"


def test_a_point_of_the_curve_is_the_mean_of_the_latest_episodes():
    episodes = [{"r": 4.0, "is_success": True}, {"r": -1.0, "is_success": False}]
    assert curve_point(64, episodes) == {
        "step": 64,
        "episodes": 2,
        "mean_return": 1.5,
        "success": 0.5,
    }
