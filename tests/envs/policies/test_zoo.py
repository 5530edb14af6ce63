"""The files of hyperparameters are those of our networks, and RL Zoo takes them as they are."""

import subprocess
import sys
from pathlib import Path

import pytest
import yaml

import envs
from envs.config import CrowdNavConfig
from envs.policies import make_policy
from envs.policies.hyperparameters import ENVIRONMENT, ZOO, read_hyperparameters
from envs.policies.networks import ALGORITHMS
from envs.policies.policy_files import save_policy

NAMES_OF_THE_ZOO = {"ppo": "ppo", "recurrent_ppo": "ppo_lstm", "sac": "sac", "tqc": "tqc"}

RUN_ALL = """
import runpy, sys
for run in sys.argv[1:]:
    sys.argv[1:] = run.split("|")
    runpy.run_module("rl_zoo3.train", run_name="__main__")
    print("finished", sys.argv[2])
"""
"""`python -m rl_zoo3.train` for several algorithms, whose import takes longer than all of them."""


def test_every_algorithm_has_a_file_that_names_its_network():
    assert {path.stem for path in ZOO.glob("*.yml")} == set(ALGORITHMS)
    for name, algorithm in ALGORITHMS.items():
        network = yaml.safe_load((ZOO / f"{name}.yml").read_text())[ENVIRONMENT]["policy"]
        assert network == f"{algorithm.network.__module__}.{algorithm.network.__name__}"
        assert read_hyperparameters(name).steps >= 100_000


def test_rl_zoo_trains_with_every_file_what_then_acts(tmp_path):
    pytest.importorskip("huggingface_sb3", reason="RL Zoo is not installed")
    runs = ["|".join(arguments(name, tmp_path)) for name in ALGORITHMS]
    home = Path(envs.__file__).parent.parent
    told = subprocess.run(
        [sys.executable, "-c", RUN_ALL, *runs], cwd=home, capture_output=True, text=True
    )
    assert told.returncode == 0, told.stderr
    config = CrowdNavConfig(forecaster="constant_velocity")
    for name, zoo_name in NAMES_OF_THE_ZOO.items():
        assert f"finished {zoo_name}" in told.stdout
        trained = tmp_path / zoo_name / "crowdnav-CrowdNav-v0_1" / "crowdnav-CrowdNav-v0.zip"
        model = ALGORITHMS[name].model.load(trained)
        save_policy(model, tmp_path / name, config=config, training={})
        assert make_policy(str(tmp_path / name), config).name == name


def arguments(name, folder):
    """Of a training that is as short as it gets."""
    zoo = ["--algo", NAMES_OF_THE_ZOO[name], "--env", ENVIRONMENT, "--gym-packages", "envs"]
    short = ["learning_starts:4"] if ALGORITHMS[name].actor else ["n_steps:8", "batch_size:8"]
    few = ["-n", "16", "--eval-freq", "-1", "--num-threads", "1", "--hyperparams", "n_envs:2"]
    simple = ["--env-kwargs", "forecaster:'constant_velocity'"]
    return [*zoo, "--conf-file", str(ZOO / f"{name}.yml"), "-f", str(folder), *few, *short, *simple]
