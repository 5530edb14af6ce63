"""The trained policies that come with the package: small, alike, without simulator, and of use."""

import json
import subprocess
import sys
from functools import cache
from pathlib import Path

import gymnasium
import numpy as np
import pytest

import envs  # noqa: F401
from envs.config import CrowdNavConfig
from envs.policies import make_policy
from envs.policies.bundled import BUNDLED

FOLDERS = sorted((BUNDLED / "ppo").iterdir())
NAMES = [folder.name for folder in FOLDERS]
ARMS = ("none", "constant_velocity", "fast", "iterative_attention")
EPISODES = 24

ACT = """
import json, sys
from pathlib import Path
import numpy as np
from envs.policies.learned import LearnedPolicy

for folder in sys.argv[1:]:
    policy = LearnedPolicy(Path(folder))
    keys = policy.description["observation_space"]
    action = policy.act({key: np.zeros(box["shape"], np.float32) for key, box in keys.items()})
    assert action.shape == (2,) and np.abs(action).max() <= 1.0
print(json.dumps(sorted(sys.modules)))
"""


def description(folder):
    return json.loads((folder / "policy.json").read_text())


def test_every_forecaster_has_the_same_seeds_steps_and_network():
    seeds = {name.rpartition("-")[2] for name in NAMES}
    assert {f"{arm}-{seed}" for arm in ARMS for seed in seeds} == set(NAMES)
    trained = [description(folder) for folder in FOLDERS]
    assert len({one["training"]["steps"] for one in trained}) == 1
    assert all(one["network"] == trained[0]["network"] for one in trained)


def test_all_together_take_less_than_six_megabytes():
    files = [path for path in BUNDLED.rglob("*") if path.is_file()]
    assert sum(path.stat().st_size for path in files) < 6_000_000


def test_each_acts_without_the_simulator():
    output = subprocess.run(
        [sys.executable, "-c", ACT, *map(str, FOLDERS)], check=True, capture_output=True, text=True
    ).stdout
    assert not set(json.loads(output)) & {"pymunk", "crowdsim.world"}


def test_the_example_of_the_page_runs(capsys):
    page = (Path(__file__).parents[3] / "docs" / "policies.md").read_text(encoding="utf-8")
    exec(page.partition("```python\n")[2].partition("```")[0], {})
    assert len(capsys.readouterr().out.split()) >= 2


@cache
def goals(spec, forecaster):
    """In how many of the same few episodes of circular_crossing a policy reaches the goal."""
    config = CrowdNavConfig(forecaster=forecaster)
    policy = make_policy(spec, config)
    env = gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=EPISODES, forecaster=forecaster)
    observation, _ = env.reset(seed=10_000)
    ended, reached = np.zeros((2, EPISODES), dtype=bool)
    while not ended.all():
        observation, _, terminated, truncated, info = env.step(policy.act(observation))
        if (terminated | truncated).any():
            reached |= info["final_info"]["is_success"] & ~ended
        ended |= terminated | truncated
    env.close()
    return int(reached.sum())


@pytest.mark.parametrize("forecaster", ARMS)
def test_the_first_of_each_arm_crosses_a_circle_better_than_straight_on(forecaster):
    assert goals("ppo", forecaster) > goals("straight", "none")
