import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import (
    FlattenObservation,
    FrameStackObservation,
    RecordEpisodeStatistics,
    RecordVideo,
)
from numpy.testing import assert_allclose, assert_array_equal

from envs.observation import ROBOT_INDEX
from envs.wrappers import FlattenKeys, WorldFrame

MODAL = {"forecaster": "constant_velocity"}
GOAL = [ROBOT_INDEX["goal_x"], ROBOT_INDEX["goal_y"]]
VELOCITY = [ROBOT_INDEX["velocity_x"], ROBOT_INDEX["velocity_y"]]


def make(**keywords):
    return gymnasium.make("crowdnav/CrowdNav-v0", **keywords)


@pytest.mark.parametrize(
    "wrap",
    [
        FlattenKeys,
        WorldFrame,
        FlattenObservation,
        lambda env: FrameStackObservation(env, 3),
        lambda env: FlattenKeys(FrameStackObservation(WorldFrame(env), 2)),
    ],
)
def test_the_checker_has_nothing_to_say_about_wrapped_ones(wrap):
    env = wrap(make(observe_map=True, render_mode="rgb_array").unwrapped)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # That it is wrapped, which is what is asked for.
        warnings.filterwarnings("ignore", message=".*is different from the unwrapped.*")
        check_env(env, skip_render_check=True)


def test_flat_keys_are_those_of_the_flat_environment():
    ours, theirs = FlattenKeys(make()), gymnasium.make("crowdnav/CrowdNavFlat-v0")
    assert ours.observation_space == theirs.observation_space
    mine, other = ours.reset(seed=3)[0], theirs.reset(seed=3)[0]
    for key, values in other.items():
        assert_array_equal(mine[key], values)


def test_a_person_is_where_the_world_has_them():
    env = WorldFrame(make(sensor_range=50.0, record=True))
    observation, _ = env.reset(seed=3)
    for _ in range(9):
        observation, *_ = env.step(np.array([0.1, 0.7]))
    assert env.observation_space.contains(observation)
    episodes = env.unwrapped.episodes
    percept, row = episodes.percept(0)
    assert_allclose(observation["history"], percept.history[row], atol=1e-4)
    assert_allclose(observation["forecast"], percept.forecast[row], atol=1e-4)
    robots = episodes.worlds.robots
    assert_allclose(observation["pose"], [*robots.position[0], robots.heading[0]], atol=1e-6)
    assert_allclose(observation["robot"][GOAL], episodes.tasks.routes.goal[0], atol=1e-4)
    assert_allclose(observation["robot"][VELOCITY], robots.velocity[0], atol=1e-5)


def test_a_flat_environment_has_no_frame_to_change():
    with pytest.raises(ValueError, match="expected the keys"):
        WorldFrame(gymnasium.make("crowdnav/CrowdNavFlat-v0"))


def test_stacked_frames_are_the_ones_before():
    env = FrameStackObservation(make(), 3)
    first, _ = env.reset(seed=0)
    plain, seen = make(), []
    seen.append(plain.reset(seed=0)[0])
    for _ in range(2):
        action = np.array([0.3, 0.1], dtype=np.float32)
        stacked, *_ = env.step(action)
        seen.append(plain.step(action)[0])
    assert env.observation_space.contains(stacked)
    for key in stacked:
        assert_array_equal(stacked[key], np.stack([each[key] for each in seen]))
    assert first["lidar"].shape == (3, 64)


def test_a_video_is_recorded(tmp_path):
    pytest.importorskip("moviepy", reason="gymnasium's RecordVideo writes with moviepy")
    env = make(render_mode="rgb_array", time_limit=1.0)
    env = RecordEpisodeStatistics(RecordVideo(env, str(tmp_path)))
    env.reset(seed=0)
    ended = False
    while not ended:
        *_, terminated, truncated, info = env.step(np.array([-1.0, 0.0], dtype=np.float32))
        ended = terminated or truncated
    env.close()
    assert info["episode"]["l"] == 5
    assert [path.suffix for path in tmp_path.iterdir()] == [".mp4"]
