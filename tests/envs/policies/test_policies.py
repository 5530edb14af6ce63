import json
import subprocess
import sys

import pytest

from envs.config import CrowdNavConfig
from envs.policies import MPPIPolicy, StraightPolicy, make_policy

LOAD = "import json, sys, envs.policies; print(json.dumps(sorted(sys.modules)))"


def test_policies_load_without_the_simulator_and_without_torch():
    output = subprocess.run(
        [sys.executable, "-c", LOAD], check=True, capture_output=True, text=True
    ).stdout
    loaded = set(json.loads(output))
    assert "envs.policies.mppi" in loaded
    assert not loaded & {"pymunk", "crowdsim.world", "torch", "stable_baselines3"}


def test_a_trained_policy_acts_without_the_simulator():
    load = LOAD.replace("envs.policies", "envs.policies.learned")
    output = subprocess.run(
        [sys.executable, "-c", load], check=True, capture_output=True, text=True
    ).stdout
    assert not set(json.loads(output)) & {"pymunk", "crowdsim.world"}


def test_policies_are_made_by_name():
    assert isinstance(make_policy("straight", CrowdNavConfig()), StraightPolicy)
    assert isinstance(make_policy("mppi", CrowdNavConfig()), MPPIPolicy)
    assert isinstance(make_policy("mppi@9.6", CrowdNavConfig()), MPPIPolicy)


@pytest.mark.parametrize("name", ["straight", "social_force", "orca", "dwa", "mppi"])
def test_each_policy_goes_by_its_own_name(name):
    assert make_policy(name, CrowdNavConfig()).name == name


def test_an_unknown_policy_is_refused_with_the_known_ones():
    with pytest.raises(ValueError, match=r"'mpc'.*straight, social_force, orca, dwa, mppi"):
        make_policy("mpc", CrowdNavConfig())


@pytest.mark.parametrize("spec", ["mppi@", "mppi@far", "mppi@-1", "mppi@inf", "mppi@0.5"])
def test_a_planning_horizon_is_a_positive_whole_number_of_steps(spec: str) -> None:
    with pytest.raises(ValueError, match=r"horizon|SECONDS"):
        make_policy(spec, CrowdNavConfig())


def test_a_folder_without_a_policy_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"policy\.json"):
        make_policy(str(tmp_path), CrowdNavConfig())
