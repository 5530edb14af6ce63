"""The files of hyperparameters are those of our networks, and RL Zoo takes them as they are."""

import subprocess
import sys
from pathlib import Path

import pytest
import yaml

import envs
from envs.policies.hyperparameters import ENVIRONMENT, ZOO, read_hyperparameters
from envs.policies.networks import ALGORITHMS

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


def test_rl_zoo_trains_with_every_file(tmp_path):
    pytest.importorskip("huggingface_sb3", reason="RL Zoo is not installed")
    runs = ["|".join(arguments(name, tmp_path)) for name in ALGORITHMS]
    home = Path(envs.__file__).parent.parent
    told = subprocess.run(
        [sys.executable, "-c", RUN_ALL, *runs], cwd=home, capture_output=True, text=True
    )
    assert told.returncode == 0, told.stderr
    for name in NAMES_OF_THE_ZOO.values():
        assert f"finished {name}" in told.stdout
        assert (tmp_path / name / "crowdnav-CrowdNav-v0_1" / "crowdnav-CrowdNav-v0.zip").is_file()


def arguments(name, folder):
    """Of a training that is as short as it gets."""
    zoo = ["--algo", NAMES_OF_THE_ZOO[name], "--env", ENVIRONMENT, "--gym-packages", "envs"]
    short = ["learning_starts:4"] if ALGORITHMS[name].actor else ["n_steps:8", "batch_size:8"]
    few = ["-n", "16", "--eval-freq", "-1", "--num-threads", "1", "--hyperparams", "n_envs:2"]
    simple = ["--env-kwargs", "forecaster:'constant_velocity'"]
    return [*zoo, "--conf-file", str(ZOO / f"{name}.yml"), "-f", str(folder), *few, *short, *simple]
