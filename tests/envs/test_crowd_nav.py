import json
import pickle
import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import RecordEpisodeStatistics
from numpy.testing import assert_allclose, assert_array_equal
from stable_baselines3.common.env_checker import check_env as sb3_check_env

import envs
from crowdsim.map import Map
from envs.evaluation.twin import run_twin
from envs.rewards import REWARD_TERMS

IDS = ("crowdnav/CrowdNav-v0", "crowdnav/CrowdNavFlat-v0")
ROBOTS = ("unicycle", "holonomic", "bicycle")
AHEAD = {"unicycle": (1.0, 0.0), "holonomic": (1.0, 0.0), "bicycle": (1.0, 0.0)}
STAND = {"unicycle": (-1.0, 0.0), "holonomic": (0.0, 0.0), "bicycle": (-1.0, 0.0)}


def make(scenario="circular_crossing", **keywords):
    return gymnasium.make("crowdnav/CrowdNav-v0", scenario=scenario, **keywords)


def run(env, action, seed=0):
    """Repeats one action until the episode ends."""
    env.reset(seed=seed)
    steps = 0
    while True:
        _, reward, terminated, truncated, info = env.step(action)
        steps += 1
        if terminated or truncated:
            return steps, reward, terminated, truncated, info


@pytest.mark.parametrize("env_id", IDS)
def test_the_checkers_have_nothing_to_say_about_maps_and_pictures(env_id):
    env = gymnasium.make(env_id, observe_map=True, render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)
        if env_id == "crowdnav/CrowdNav-v0":
            # SB3 has no network of its own for keys of rank 3, and says so.
            warnings.simplefilter("ignore")
        sb3_check_env(env)


def test_ids_are_registered_once_and_by_module():
    envs.register_environments()
    ours = [env_id for env_id in gymnasium.registry if env_id.startswith("crowdnav/")]
    assert sorted(ours) == sorted(IDS)
    env = gymnasium.make("envs:crowdnav/CrowdNav-v0", forecaster="none", horizon=2.4)
    assert json.loads(env.spec.to_json())["kwargs"] == {"forecaster": "none", "horizon": 2.4}


@pytest.mark.parametrize("keywords", [{"scenario": "circular_crosing"}, {"forecasters": "none"}])
def test_a_misspelt_keyword_or_scenario_is_refused(keywords):
    with pytest.raises(ValueError, match=r"known are|must be one of"):
        gymnasium.make("crowdnav/CrowdNav-v0", **keywords)


def test_frames_that_the_forecaster_does_not_know_are_refused():
    with pytest.raises(ValueError, match=r"frame_dt must be 0\.4 for the forecaster"):
        make(frame_dt=0.6, horizon=4.8)


@pytest.mark.parametrize("robot", ROBOTS)
def test_reaching_the_goal_terminates_with_success(scene, robot):
    env = make(scene(goal=(3.0, 0.0)), robot=robot, max_speed=1.0)
    steps, _, terminated, truncated, info = run(env, AHEAD[robot])
    assert (terminated, truncated) == (True, False)
    assert info["is_success"] is True
    assert info["termination_reason"] == "goal"
    assert info["rewards"]["goal"] == 10.0
    assert 2.7 / 0.2 <= steps <= 3.2 / 0.2


@pytest.mark.parametrize("robot", ROBOTS)
def test_running_out_of_time_truncates(scene, robot):
    env = make(scene(time_limit=4.0), robot=robot)
    steps, _, terminated, truncated, info = run(env, STAND[robot])
    assert (terminated, truncated) == (False, True)
    assert steps == 20
    assert info["is_success"] is False
    assert info["termination_reason"] == "timeout"
    assert run(make(scene(), time_limit=1.0), STAND["unicycle"])[0] == 5


def test_running_into_somebody_who_stands_is_the_robots_doing(scene):
    env = make(scene(people=(3.0, 0.0)), record=True, robot_visible=False)
    _, _, terminated, _, info = run(env, AHEAD["unicycle"])
    assert terminated
    assert info["termination_reason"] == "collision_pedestrian"
    assert info["rewards"]["collision"] == -10.0
    assert env.unwrapped.trace.collision_role == "robot_on_person"
    assert env.unwrapped.trace.clearance_pedestrian[-1] < 0.01


def test_being_run_into_is_the_persons_doing(scene):
    name = scene(people=(4.0, 0.0), goals=(-4.0, 0.0))
    env = make(name, record=True, robot_visible=False)
    _, _, _, _, info = run(env, STAND["unicycle"])
    assert info["termination_reason"] == "collision_pedestrian"
    assert env.unwrapped.trace.collision_role == "person_on_robot"


def test_touching_a_wall_terminates(scene):
    walls = np.array([[[2.0, -3.0], [2.0, 3.0]]])
    name = scene(ground=Map(bounds=(-5.0, -5.0, 12.0, 5.0), walls=walls))
    env = make(name, record=True)
    _, _, terminated, _, info = run(env, AHEAD["unicycle"])
    assert terminated
    assert info["termination_reason"] == "collision_wall"
    assert env.unwrapped.trace.collision_role is None
    assert env.unwrapped.trace.robot_position[:, 0].max() < 1.75


def test_a_goal_without_a_way_is_refused(scene):
    around = np.array([[6, -2], [10, -2], [10, 2], [6, 2], [6, -2]], dtype=float)
    walls = np.stack([around[:-1], around[1:]], axis=1)
    name = scene(ground=Map(bounds=(-5.0, -5.0, 12.0, 5.0), walls=walls))
    with pytest.raises(ValueError, match="must be reachable"):
        make(name).reset(seed=0)


def test_progress_is_the_way_that_was_gained(scene):
    env = make(scene(goal=(3.0, 0.0)), record=True, max_speed=1.0)
    run(env, AHEAD["unicycle"])
    trace = env.unwrapped.trace
    left = np.linalg.norm(trace.robot_goal - trace.robot_position, axis=1)
    assert_allclose(trace.rewards["progress"], np.append(0.0, -np.diff(left)), atol=1e-12)


def test_rewards_are_floats_that_sum_to_the_reward():
    env = make()
    env.reset(seed=0)
    _, reward, terminated, _, info = env.step(env.action_space.sample())
    assert type(reward) is float
    assert type(terminated) is bool
    assert tuple(info["rewards"]) == REWARD_TERMS
    assert_allclose(reward, sum(info["rewards"].values()))


def test_actions_that_are_not_finite_are_refused_and_change_nothing():
    env = make()
    env.reset(seed=0)
    with pytest.raises(ValueError, match="actions must be finite"):
        env.unwrapped.step(np.array([0.5, np.nan]))
    after = env.step(np.array([0.5, 0.0], dtype=np.float32))
    env.reset(seed=0)
    assert_array_equal(
        after[0]["history"], env.step(np.array([0.5, 0.0], dtype=np.float32))[0]["history"]
    )


def test_a_reset_in_mid_episode_forgets_it():
    env = make("parallel_traffic")
    env.reset(seed=5)
    for _ in range(20):
        env.step(AHEAD["unicycle"])
    again, _ = env.reset(seed=5)
    fresh, _ = make("parallel_traffic").reset(seed=5)
    for key, values in fresh.items():
        assert_array_equal(again[key], values)


def test_the_next_episode_is_another_one():
    env = make()
    first, _ = env.reset(seed=5)
    second, _ = env.reset()
    assert (first["history"] != second["history"]).any()


def test_observations_share_no_memory():
    env = make(observe_map=True)
    earlier, _ = env.reset(seed=0)
    kept = {key: values.copy() for key, values in earlier.items()}
    for _ in range(3):
        env.step(AHEAD["unicycle"])
    for key, values in kept.items():
        assert_array_equal(earlier[key], values)


def test_histories_never_jump_when_people_enter_anew():
    env = make("parallel_traffic", time_limit=30.0, robot_visible=False)
    env.reset(seed=1)
    worst = 0.0
    for _ in range(140):
        observation, _, terminated, _, _ = env.step(STAND["unicycle"])
        jump = np.linalg.norm(np.diff(observation["history"], axis=1), axis=-1)
        both = observation["history_valid"][:, 1:] * observation["history_valid"][:, :-1]
        worst = max(worst, float((jump * both).max()))
        if terminated:
            env.reset()
    assert 0.3 < worst < 0.4 * 3.5


def test_an_environment_pickles():
    env = pickle.loads(pickle.dumps(gymnasium.make(IDS[1], forecaster="none").unwrapped))
    assert env.reset(seed=0)[0]["history"].ndim == 1


def test_wrappers_of_gymnasium_work(scene):
    env = make(scene(goal=(1.0, 0.0)), render_mode="rgb_array")
    assert env.metadata["render_fps"] == 5
    env.reset(seed=0)
    assert env.render().dtype == np.uint8
    env = RecordEpisodeStatistics(env)
    steps, *_, info = run(env, AHEAD["unicycle"])
    assert info["episode"]["l"] == steps


def test_a_trace_tells_the_whole_episode(scene):
    name = scene(people=[(3.0, 1.5), (5.0, -1.0)], goals=[(-3.0, 1.5), (-5.0, -1.0)])
    env = make(name, record=True, max_speed=1.0, forecaster="constant_velocity")
    with pytest.raises(RuntimeError, match="an episode that has ended"):
        _ = env.unwrapped.trace
    steps, *_ = run(env, AHEAD["unicycle"])
    trace = env.unwrapped.trace
    rows = steps + 1
    assert trace.duration == pytest.approx(steps * 0.2)
    assert trace.position.shape == trace.velocity.shape == (rows, 2, 2)
    assert trace.valid.shape == trace.ids.shape == trace.visible.shape == (rows, 2)
    assert trace.forecast.shape == (rows, 8, 12, 2)
    assert_array_equal(np.sort(trace.forecast_ids[0]), [-1] * 6 + [0, 1])
    assert trace.shortest_path_lengths == pytest.approx(8.0)
    now = np.linalg.norm(trace.position - trace.robot_position[:, None], axis=-1) - 0.25 - 0.3
    assert (trace.clearance_pedestrian <= now.min(axis=1) + 1e-9).all()
    assert trace.clearance_pedestrian[0] == pytest.approx(now[0].min())
    assert np.isinf(trace.clearance_wall).all()
    assert (trace.forecast_seconds > 0.0).all()
    assert trace.social_work[0] == 0.0 < trace.social_work[1:].max()
    assert all(terms.shape == (rows,) for terms in trace.rewards.values())
    # Seen once, a person is taken to stand.
    assert_allclose(trace.forecast[0, 0], np.tile(trace.position[0, 0], (12, 1)))


def test_a_recorded_episode_does_not_go_on_after_its_end():
    env = make(record=True, time_limit=0.4).unwrapped
    env.reset(seed=0)
    env.step(np.zeros(2))
    assert env.step(np.zeros(2))[3]
    with pytest.raises(RuntimeError, match="reset after the episode's end"):
        env.step(np.zeros(2))
    env.reset()
    env.step(np.zeros(2))


@pytest.mark.parametrize("name", ["circular_crossing", "parallel_traffic", "narrow_doorway"])
def test_the_twin_lives_the_same_life_until_the_robot_comes_near(name):
    env = make(name, record=True, robot_visible=False, time_limit=6.0)
    run(env, STAND["unicycle"], seed=2)
    trace = env.unwrapped.trace
    twin = run_twin(trace, longer=1.0)
    assert len(twin.position) == len(trace.position) + 5
    untouched = len(trace.position) - (trace.termination_reason == "collision_pedestrian")
    assert_array_equal(twin.position[:untouched], trace.position[:untouched])
    assert_array_equal(twin.ids[:untouched], trace.ids[:untouched])


def test_people_give_way_to_a_robot_that_they_see(scene):
    name = scene(people=(4.0, 0.4), goals=(-4.0, 0.4), time_limit=5.0)
    env = make(name, record=True)
    run(env, STAND["unicycle"])
    trace = env.unwrapped.trace
    aside = np.abs(trace.position[:, 0, 1] - run_twin(trace).position[:, 0, 1]).max()
    assert aside > 0.1


def test_importing_policies_or_the_layout_leaves_the_simulator_out():
    program = (
        "import sys; import envs, envs.config, envs.observation;"
        "print(sorted({'pymunk', 'torch', 'crowdsim.world'} & set(sys.modules)))"
    )
    found = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert found.stdout.strip() == "[]"
