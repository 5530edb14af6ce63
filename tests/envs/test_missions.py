"""Robots that go to and fro: where they turn back, what that is worth, and how it is measured."""

import warnings
from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from hand_made_scenes import set_scene
from numpy.testing import assert_allclose, assert_array_equal

from crowdsim.scenarios import make_scenario
from envs.config import CrowdNavConfig, make_config
from envs.crowd_nav import CrowdNav
from envs.episodes import Episodes
from envs.evaluation.metrics import navigation_metrics
from envs.evaluation.runs import run_episodes
from envs.observation import ROBOT_INDEX
from envs.routes import Routes
from envs.tasks import check_mission

GOAL = [ROBOT_INDEX["goal_x"], ROBOT_INDEX["goal_y"]]
TIME_LEFT = ROBOT_INDEX["time_left"]
FORTH, BACK, STAND = (1.0, 0.0), (-1.0, 0.0), (0.0, 0.0)


@pytest.fixture
def env(scene):
    """A robot that faces its goal, 3 m ahead of it in the open, and goes forward and back."""

    def make(mission=6.0, people=(), **changes):
        name = scene(goal=(3.0, 0.0), people=people, **changes)
        return CrowdNav(
            scenario=name,
            robot="holonomic",
            robot_visible=False,
            forecaster="none",
            mission=mission,
            record=True,
        )

    return make


def drive(env, steps=400, after=None):
    """Goes to and fro until the episode ends; `after` one arrival it does something else."""
    observation, _ = env.reset(seed=0)
    arrivals = 0
    for _ in range(steps):
        ahead = observation["robot"][GOAL[0]] > 0
        action = after if after is not None and arrivals else FORTH if ahead else BACK
        observation, _, terminated, truncated, info = env.step(action)
        arrivals += info["rewards"]["goal"] > 0
        if terminated or truncated:
            return arrivals, terminated, info
    raise AssertionError("the episode goes on")


def test_the_first_arrival_after_the_mission_ends_it(env):
    arrivals, terminated, info = drive(running := env(mission=6.0))
    assert terminated
    assert info["termination_reason"] == "goal"
    trace = running.trace
    assert 6.0 <= trace.duration < 6.0 + 3.5
    assert arrivals == len(trace.ways) >= 3
    ends = [way.stop - 1 for way in trace.ways]
    assert trace.dt * ends[-2] < 6.0
    at = trace.robot_goal[[way.start for way in trace.ways]]
    assert_array_equal(at, [((3.0, 0.0), (0.0, 0.0))[way % 2] for way in range(len(at))])


def test_the_observation_of_an_arrival_is_that_of_the_next_way(env):
    running = env()
    observation, _ = running.reset(seed=0)
    info = {"rewards": {"goal": 0.0}}
    while info["rewards"]["goal"] == 0.0:
        assert observation["robot"][TIME_LEFT] == 1.0 or observation["robot"][GOAL[0]] > 0.0
        observation, _, _, _, info = running.step(FORTH)
    position = running.episodes.worlds.robots.position[0]
    assert_allclose(observation["robot"][GOAL], -position, atol=1e-6)
    assert observation["robot"][TIME_LEFT] == 1.0


def test_progress_adds_up_over_every_way_and_nothing_jumps(env):
    drive(running := env())
    trace = running.trace
    progress = trace.rewards["progress"]
    assert np.abs(progress).max() <= 1.2 * 0.2 + 1e-9
    for way in trace.ways:
        away = np.linalg.norm((trace.robot_goal[way.start] - trace.robot_position)[way], axis=1)
        assert progress[way][1:].sum() == pytest.approx(away[0] - away[-1])


def test_every_way_has_the_time_limit(env):
    arrivals, terminated, info = drive(running := env(mission=60.0), after=STAND)
    assert (arrivals, terminated) == (1, False)
    assert info["termination_reason"] == "timeout"
    first, last = running.trace.ways
    assert running.trace.dt * (last.stop - 1 - last.start) == pytest.approx(10.0)
    assert first.stop - 1 == last.start


def test_contact_ends_a_mission(env):
    _, terminated, info = drive(env(mission=60.0, people=[(5.0, 0.0)]), after=FORTH)
    assert terminated
    assert info["termination_reason"] == "collision_pedestrian"


def test_metrics_are_taken_way_by_way(env):
    drive(running := env(mission=60.0), after=STAND)
    trace = running.trace
    metrics = navigation_metrics(trace)
    first = trace.dt * trace.ways[1].start
    assert metrics["goals_reached"] == 1
    assert metrics["time_without_contact"] == pytest.approx(trace.duration)
    assert metrics["time_to_goal"] == pytest.approx(first)
    assert metrics["time_to_goal_penalized"] == pytest.approx((first + 10.0) / 2)
    assert metrics["spl"] == pytest.approx(0.5)  # a straight way, and one that led nowhere
    assert metrics["failure_to_progress"] == 2
    assert_allclose(trace.shortest_path_lengths[0], 3.0)
    assert_allclose(trace.shortest_path_lengths[1], trace.robot_position[trace.ways[1].start, 0])


def test_a_single_way_has_no_mission(env):
    drive(running := env(mission=0.0))
    metrics = navigation_metrics(running.trace)
    assert len(running.trace.ways) == 1
    assert np.isnan(metrics["goals_reached"])
    assert np.isnan(metrics["time_without_contact"])
    assert metrics["time_to_goal"] == pytest.approx(running.trace.duration)


def test_the_way_back_leads_around_the_same_walls():
    scenario = make_scenario("narrow_doorway", np.random.default_rng(0))
    routes, world = Routes(1), np.array([0])
    routes.restart(0, scenario)
    start, goal = (np.array([point[:2]]) for point in (scenario.robot_start, scenario.robot_goal))
    forth = routes.distance(start, world)
    routes.turn_back(0)
    assert_allclose(routes.distance(goal, world), forth, rtol=0.02)
    assert_allclose(routes.goal, start)
    routes.turn_back(0)
    assert_array_equal(routes.distance(start, world), forth)


MISSION = {
    "mission": 30.0,
    "frame_jitter": 0.2,
    "scenario_parameters": {"pedestrians": 4, "radius": 2.0},
    "forecaster": "constant_velocity",
    "robot": "holonomic",
}


def roll(episodes, steps):
    """Observations of robots that go straight at their goals."""
    seen, observation = [], None
    for _ in range(steps):
        if observation is None:
            action = np.zeros((len(episodes), 2))
        else:
            offset = observation["robot"][:, GOAL]
            action = offset / np.linalg.norm(offset, axis=1, keepdims=True)
        observation = episodes.step(action).observation
        seen.append(observation)
    return seen


def test_no_mission_depends_on_the_others():
    together = Episodes(make_config(**MISSION), 8)
    together.reset([np.random.default_rng(seed) for seed in range(8)])
    rows = roll(together, 25)
    turned = together.tasks.routes.goal[:, 1] < 0.0
    assert turned.any()
    for world in (0, int(turned.argmax()), 7):
        alone = Episodes(make_config(**MISSION), 1)
        alone.reset([np.random.default_rng(world)])
        for one, all_of_them in zip(roll(alone, 25), rows, strict=True):
            for key in one:
                assert_array_equal(one[key][0], all_of_them[key][world], key)


def test_a_reset_on_the_way_back_leaves_nothing_behind():
    used, fresh = (Episodes(make_config(**MISSION), 1) for _ in range(2))
    used.reset([np.random.default_rng(0)])
    roll(used, 20)
    assert used.tasks.routes.goal[0, 1] < 0.0  # on the way back
    first, second = (each.reset([np.random.default_rng(7)]) for each in (used, fresh))
    rows = [(first, second), *zip(roll(used, 20), roll(fresh, 20), strict=True)]
    for one, other in rows:
        for key in one:
            assert_array_equal(one[key], other[key], key)


def test_branches_follow_a_mission_beyond_its_first_goal():
    config = CrowdNavConfig(**{**MISSION, "mission": 12.0, "time_limit": 60.0})
    ((_, trace),) = run_episodes(config, "mppi", [10000], 1, branched=True)
    assert len(trace.ways) > 1
    assert trace.branches[-1].row > trace.ways[1].start
    metrics = navigation_metrics(trace)
    assert np.isnan(metrics["pedestrian_delay"])


@pytest.mark.parametrize("env_id", ["crowdnav/CrowdNav-v0", "crowdnav/CrowdNavFlat-v0"])
def test_the_checkers_have_nothing_to_say(env_id):
    env = gymnasium.make(env_id, **MISSION)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)


def test_a_crowd_that_ends_some_day_is_refused():
    scenario = set_scene(np.random.default_rng(0), people=[(3.0, 3.0)])
    check_mission(scenario, 0.3)
    with pytest.raises(ValueError, match="do not leave for good, found by_hand"):
        check_mission(replace(scenario, on_arrival="leave"), 0.3)
    with pytest.raises(ValueError, match=r"a start at least 0.6 m from the goal, found 0.50 m"):
        check_mission(replace(scenario, robot_goal=(0.5, 0.0)), 0.3)
