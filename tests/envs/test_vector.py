import hashlib
import subprocess
import sys

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers.vector import RecordEpisodeStatistics
from numpy.testing import assert_array_equal

from crowdsim.scenarios import SCENARIOS, make_scenario
from envs.vector import CrowdNavVector

WIDTH = 8
STEPS = 45
SHORT = {"time_limit": 4.0}
FORECASTERS = ("none", "constant_velocity", "checkpoint")


def actions_of(seed):
    """Actions of one environment, drawn for itself alone."""
    return np.random.default_rng((7, seed)).uniform(-1, 1, (STEPS, 2)).astype(np.float32)


def digest(hasher, observation, *numbers):
    for key in sorted(observation):
        hasher.update(np.ascontiguousarray(observation[key]).tobytes())
    hasher.update(np.array(numbers, dtype=np.float64).tobytes())


def single_digest(seed, **keywords):
    """Hashes all that one environment gives over several episodes."""
    hasher, ends = hashlib.sha256(), []
    env = gymnasium.make("crowdnav/CrowdNav-v0", **keywords).unwrapped
    digest(hasher, env.reset(seed=seed)[0])
    for action in actions_of(seed):
        observation, reward, terminated, truncated, info = env.step(action)
        digest(hasher, observation, reward, terminated, truncated)
        if terminated or truncated:
            ends.append(info["termination_reason"])
            digest(hasher, env.reset()[0])
    return hasher.hexdigest(), ends


def vector_digests(seed, width, **keywords):
    """The same for each of the environments of a vector environment."""
    hashers, ends = [hashlib.sha256() for _ in range(width)], [[] for _ in range(width)]
    env = gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=width, **keywords).unwrapped
    observation, _ = env.reset(seed=seed)
    for world, hasher in enumerate(hashers):
        digest(hasher, of(observation, world))
    for action in np.stack([actions_of(seed + world) for world in range(width)], axis=1):
        observation, reward, terminated, truncated, info = env.step(action)
        for world, hasher in enumerate(hashers):
            ended = terminated[world] or truncated[world]
            last = info["final_obs"][world] if ended else of(observation, world)
            digest(hasher, last, reward[world], terminated[world], truncated[world])
            if ended:
                ends[world].append(info["final_info"]["termination_reason"][world])
                digest(hasher, of(observation, world))
    return [hasher.hexdigest() for hasher in hashers], ends


def of(observation, world):
    return {key: values[world] for key, values in observation.items()}


def varied(rng):
    """Scenes of several kinds and crowd sizes, so that worlds side by side differ in width."""
    name = ("circular_crossing", "parallel_traffic", "narrow_doorway")[int(rng.integers(3))]
    return make_scenario(name, rng, pedestrians=int(rng.integers(2, 12)))


@pytest.fixture
def varied_scenario(monkeypatch):
    monkeypatch.setitem(SCENARIOS, "varied", varied)
    return "varied"


@pytest.mark.parametrize("forecaster", FORECASTERS)
def test_an_episode_does_not_depend_on_those_beside_it(forecaster, checkpoint, varied_scenario):
    spec = checkpoint if forecaster == "checkpoint" else forecaster
    keywords = {"scenario": varied_scenario, "forecaster": spec, **SHORT}
    together, ends = vector_digests(100, WIDTH, **keywords)
    assert sum(map(len, ends)) > WIDTH  # many a reset beside a running episode
    assert vector_digests(100, 1, **keywords)[0] == together[:1]
    for world in range(WIDTH):
        assert single_digest(100 + world, **keywords) == (together[world], ends[world])


def test_another_process_gives_the_same_bits(checkpoint):
    noisy = "oracle_noisy@sigma=0.3+delay=0.4+drop=0.2"
    specs = ("none", "constant_velocity", "social_force", noisy, checkpoint)
    program = (
        "import sys; sys.path.insert(0, 'tests/envs'); from test_vector import single_digest;"
        f"print(*[single_digest(100, forecaster=s, time_limit=4.0)[0] for s in {specs!r}])"
    )
    other = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    ours = [single_digest(100, forecaster=spec, **SHORT)[0] for spec in specs]
    assert other.stdout.split() == ours


def test_it_speaks_as_the_vector_environments_of_gymnasium_do():
    keywords = {"forecaster": "constant_velocity", **SHORT}
    ours = gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=3, **keywords)
    theirs = SyncVectorEnv(
        [lambda: gymnasium.make("crowdnav/CrowdNav-v0", **keywords)] * 3,
        autoreset_mode=AutoresetMode.SAME_STEP,
    )
    assert isinstance(ours.unwrapped, CrowdNavVector)
    assert ours.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    for mine, other in zip(ours.reset(seed=4), theirs.reset(seed=4), strict=True):
        same(mine, other)
    actions = np.stack([actions_of(seed) for seed in range(3)], axis=1)
    ended = 0
    for action in actions:
        for mine, other in zip(ours.step(action), theirs.step(action), strict=True):
            same(mine, other)
            ended += "final_obs" in mine if isinstance(mine, dict) else 0
    assert ended > 1


def same(mine, other):
    """Equal in structure, types and values; what the wall clock says may differ."""
    if isinstance(mine, dict):
        assert mine.keys() == other.keys()
        for key in mine.keys() - {"forecast_seconds"}:
            same(mine[key], other[key])
    elif isinstance(mine, np.ndarray) and mine.dtype == object:
        for one, two in zip(mine, other, strict=True):
            same(one, two)
    elif isinstance(mine, np.ndarray):
        assert mine.dtype == other.dtype
        assert_array_equal(mine, other)
    else:
        assert mine == other


def test_seeds_may_be_listed():
    env = gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=2)
    counted, _ = env.reset(seed=5)
    listed, _ = env.reset(seed=[6, 5])
    assert_array_equal(listed["history"], counted["history"][::-1])
    with pytest.raises(ValueError, match="expected 2 seeds, found 3"):
        env.reset(seed=[1, 2, 3])


def test_a_reset_without_seed_goes_on():
    env = gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=2)
    first, _ = env.reset(seed=5)
    second, _ = env.reset()
    env.reset(seed=5)
    again, _ = env.reset()
    assert (first["history"] != second["history"]).any()
    assert_array_equal(second["history"], again["history"])


def test_history_is_cleared_where_an_episode_ends_and_kept_where_it_goes_on():
    env = gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=4, sensor_range=100.0)
    env.reset(seed=0)
    since = np.zeros(4, dtype=int)
    ends = 0
    while ends < 3:
        observation, _, terminated, truncated, _ = env.step(env.action_space.sample())
        ended = terminated | truncated
        since = np.where(ended, 0, since + 1)
        frames = observation["history_valid"].sum(axis=2).max(axis=1)
        assert_array_equal(frames, np.minimum(8, 1 + since // 2))
        ends += int(ended.sum())


def test_recorded_traces_are_those_of_single_environments():
    keywords = {"record": True, "forecaster": "constant_velocity", **SHORT}
    vector = CrowdNavVector(3, **keywords)
    vector.reset(seed=20)
    found = {}
    for action in np.stack([actions_of(20 + world) for world in range(3)], axis=1):
        vector.step(action)
        for world, trace in vector.pop_traces().items():
            found.setdefault(world, trace)
    for world, trace in found.items():
        env = gymnasium.make("crowdnav/CrowdNav-v0", **keywords)
        env.reset(seed=20 + world)
        for action in actions_of(20 + world):
            if any(env.step(action)[2:4]):
                break
        same_trace(trace, env.unwrapped.trace)


def same_trace(trace, other):
    assert trace.termination_reason == other.termination_reason
    for name, values in vars(trace).items():
        if isinstance(values, np.ndarray) and name != "forecast_seconds":
            assert_array_equal(values, getattr(other, name), err_msg=name)


def test_statistics_wrapper_counts_whole_episodes():
    env = RecordEpisodeStatistics(
        gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=2, forecaster="none", time_limit=2.0)
    )
    env.reset(seed=0)
    stand = np.tile(np.array([-1.0, 0.0], dtype=np.float32), (2, 1))
    for _ in range(10):
        *_, info = env.step(stand)
    assert_array_equal(info["episode"]["l"], [10, 10])


def test_wrong_actions_are_refused():
    env = CrowdNavVector(2, forecaster="none")
    with pytest.raises(ResetNeeded, match="reset before the first step"):
        env.step(np.zeros((2, 2)))
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"actions must have shape \(2, 2\), got \(2,\)"):
        env.step(np.zeros(2))


def test_rendering_gives_a_picture_of_each_world():
    env = CrowdNavVector(2, render_mode="rgb_array")
    env.reset(seed=0)
    first, second = env.render()
    assert first.shape == second.shape
    assert (first != second).any()
