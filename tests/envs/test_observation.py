import dataclasses

import gymnasium
import numpy as np
import pytest
from numpy.testing import assert_allclose

from crowdsim.map import Map
from crowdsim.recordings.surfaces import Surface
from envs.observation import GOAL_RANGE, MAP_PIXELS, MAP_SIDE, ROBOT_FIELDS, ROBOT_INDEX
from envs.robots import direction

ROBOTS = ("unicycle", "holonomic", "bicycle")
HEADINGS = (0.0, 2.1, -np.pi / 2)
STAND = {"unicycle": (-1.0, 0.0), "holonomic": (0.0, 0.0), "bicycle": (-1.0, 0.0)}


def turned(points, heading):
    """Points given ahead and left of a robot at (1, 2), in the world."""
    ahead, left = direction(np.array(heading)), direction(np.array(heading + np.pi / 2))
    points = np.asarray(points, dtype=float)
    return np.array([1.0, 2.0]) + points[..., :1] * ahead + points[..., 1:] * left


def facing(scene, heading, **changes):
    """A scene whose people, goals and goal are given in the robot's frame."""
    for key in ("people", "goals"):
        if key in changes:
            changes[key] = turned(np.reshape(changes[key], (-1, 2)), heading)
    goal = tuple(turned(changes.pop("goal", (8.0, 0.0)), heading))
    return scene(robot=(1.0, 2.0, heading), goal=goal, **changes)


def watch(env, steps):
    """Lets the robot stand for some steps and returns the last observation."""
    observation, _ = env.reset(seed=0)
    for _ in range(steps):
        observation, *_ = env.step(STAND[env.unwrapped.episodes.config.robot])
    return observation


@pytest.mark.parametrize("heading", HEADINGS)
@pytest.mark.parametrize("robot", ROBOTS)
def test_what_is_straight_ahead_is_at_plus_x(scene, robot, heading):
    name = facing(scene, heading, people=(3.0, 0.0), goals=(9.0, 0.0), goal=(7.0, 0.0))
    observation = watch(gymnasium.make("crowdnav/CrowdNav-v0", scenario=name, robot=robot), 6)
    assert_allclose(observation["history"][0, :, 1], 0.0, atol=0.05)
    steps = np.diff(observation["history"][0, -4:, 0])
    assert (steps > 0.2).all()  # walks away
    assert observation["history"][0, -1, 0] > 3.5
    assert_allclose(observation["forecast"][0, :, 1], 0.0, atol=0.3)
    assert (np.diff(observation["forecast"][0, :, 0]) > 0.2).all()
    robot_row = observation["robot"]
    assert_allclose(robot_row[[ROBOT_INDEX["goal_x"], ROBOT_INDEX["goal_y"]]], (7, 0), atol=1e-5)
    assert_allclose(
        robot_row[[ROBOT_INDEX["waypoint_x"], ROBOT_INDEX["waypoint_y"]]], (2, 0), atol=1e-5
    )


@pytest.mark.parametrize("heading", HEADINGS)
def test_what_is_to_the_left_is_at_plus_y(scene, heading):
    name = facing(scene, heading, people=(0.0, 3.0), goal=(0.0, 5.0))
    env = gymnasium.make("crowdnav/CrowdNav-v0", scenario=name, forecaster="constant_velocity")
    observation = watch(env, 0)
    assert_allclose(observation["history"][0, -1], (0.0, 3.0), atol=1e-5)
    assert_allclose(observation["forecast"][0], np.tile((0.0, 3.0), (12, 1)), atol=1e-5)
    assert_allclose(observation["robot"][ROBOT_INDEX["goal_y"]], 5.0, atol=1e-5)


@pytest.mark.parametrize("heading", HEADINGS)
def test_lidar_sees_walls_not_people_ray_0_ahead_then_left(scene, heading):
    wall = turned([[4.0, -0.5], [4.0, 0.5]], heading)
    left = turned([[-0.5, 6.0], [0.5, 6.0]], heading)
    ground = Map(bounds=(-20.0, -20.0, 20.0, 20.0), walls=np.stack([wall, left]))
    name = facing(scene, heading, people=(2.0, 0.0), goal=(3.0, 0.0), ground=ground)
    lidar = watch(gymnasium.make("crowdnav/CrowdNav-v0", scenario=name), 0)["lidar"]
    assert_allclose(lidar[0], 4.0, atol=1e-5)
    assert_allclose(lidar[16], 6.0, atol=1e-5)
    assert_allclose(lidar[[32, 48]], 10.0)


@pytest.mark.parametrize("heading", HEADINGS)
def test_map_crop_looks_along_the_heading(scene, heading):
    square = np.array([[2.0, 2.0], [4.0, 2.0], [4.0, 4.0], [2.0, 4.0]])
    ground = Map(
        bounds=(-30.0, -30.0, 30.0, 30.0),
        surfaces=((Surface.GRASS, turned(square, heading)),),
    )
    name = facing(scene, heading, ground=ground)
    env = gymnasium.make("crowdnav/CrowdNav-v0", scenario=name, observe_map=True)
    crop = watch(env, 0)["map"]
    row, column = np.nonzero((crop == Surface.GRASS.color_rgb).all(axis=-1))
    metre = MAP_PIXELS / MAP_SIDE
    # The robot is a quarter from the left edge and half-way down; the meadow ahead and to its left.
    assert_allclose(column.mean(), (4.0 + 3.0) * metre, atol=1.0)
    assert_allclose(row.mean(), (8.0 - 3.0) * metre, atol=1.0)


def test_nearest_come_first_and_far_ones_are_not_seen(scene):
    name = scene(people=[(6.0, 0.0), (2.0, 0.0), (11.0, 0.0), (0.0, 4.0)], goal=(0.0, -5.0))
    env = gymnasium.make("crowdnav/CrowdNav-v0", scenario=name, sensor_range=10.0)
    observation = watch(env, 0)
    assert_allclose(observation["neighbors_valid"], [1, 1, 1, 0, 0, 0, 0, 0])
    assert_allclose(observation["history"][:3, -1], [(2, 0), (0, 4), (6, 0)], atol=1e-5)
    assert_allclose(observation["neighbors_radius"][:4], [0.25, 0.25, 0.25, 0.0])
    assert not observation["forecast"][3:].any()


def test_first_history_has_one_frame_and_zeros_before(scene):
    name = scene(people=(3.0, 0.0))
    observation = watch(gymnasium.make("crowdnav/CrowdNav-v0", scenario=name), 0)
    assert_allclose(observation["history_valid"][0], [0] * 7 + [1])
    assert not observation["history"][0, :-1].any()


def test_waypoint_leads_around_a_wall(scene):
    wall = np.array([[[3.0, -1.0], [3.0, 12.0]]])
    ground = Map(bounds=(-15.0, -15.0, 15.0, 15.0), walls=wall)
    name = scene(ground=ground, goal=(6.0, 0.0))
    row = watch(gymnasium.make("crowdnav/CrowdNav-v0", scenario=name), 0)["robot"]
    waypoint = row[[ROBOT_INDEX["waypoint_x"], ROBOT_INDEX["waypoint_y"]]]
    assert_allclose(np.hypot(*waypoint), 2.0, atol=0.01)
    assert waypoint[1] < -0.5


def test_a_far_goal_keeps_its_direction(scene):
    ground = Map(bounds=(-10.0, -10.0, 400.0, 400.0))
    name = scene(ground=ground, goal=(300.0, 400.0))
    env = gymnasium.make("crowdnav/CrowdNav-v0", scenario=name)
    row = watch(env, 0)["robot"]
    goal = row[[ROBOT_INDEX["goal_x"], ROBOT_INDEX["goal_y"]]]
    assert_allclose(goal, (0.6 * GOAL_RANGE, 0.8 * GOAL_RANGE), rtol=1e-6)
    assert env.observation_space["robot"].contains(row)


def test_robot_fields_say_what_the_robot_does(scene):
    name = scene(robot=(0.0, 0.0, np.pi / 2), goal=(0.0, 8.0), time_limit=10.0)
    env = gymnasium.make("crowdnav/CrowdNav-v0", scenario=name, max_speed=1.0)
    env.reset(seed=0)
    for _ in range(5):
        observation, *_ = env.step((1.0, 0.0))
    fields = dict(zip(ROBOT_FIELDS, observation["robot"].tolist(), strict=True))
    expected = {
        "velocity_x": 1.0,
        "velocity_y": 0.0,
        "angular_speed": 0.0,
        "radius": 0.3,
        "max_speed": 1.0,
        "max_angular_speed": 1.5,
        "max_acceleration": 2.5,
        "time_left": 0.9,
    }
    assert_allclose([fields[name] for name in expected], list(expected.values()), atol=1e-5)


@pytest.mark.parametrize("name", ["circular_crossing", "parallel_traffic", "narrow_doorway"])
@pytest.mark.parametrize("robot", ROBOTS)
def test_long_runs_stay_within_the_boxes(name, robot, checkpoint):
    env = gymnasium.make(
        "crowdnav/CrowdNav-v0", scenario=name, robot=robot, forecaster=checkpoint, time_limit=8.0
    )
    rng = np.random.default_rng(0)
    observation, _ = env.reset(seed=3)
    seen = [observation]
    for _ in range(60):
        observation, _, terminated, truncated, _ = env.step(rng.uniform(-1.5, 1.5, 2))
        seen.append(observation)
        if terminated or truncated:
            seen.append(env.reset()[0])
    for observation in seen:
        assert env.observation_space.contains(observation)
        assert all(np.isfinite(values).all() for values in observation.values())


def test_configuration_decides_which_keys_there_are(scene):
    name = scene()
    with_map = gymnasium.make("crowdnav/CrowdNav-v0", scenario=name, observe_map=True)
    plain = gymnasium.make("crowdnav/CrowdNav-v0", scenario=name, forecaster="none")
    more = set(with_map.observation_space) - set(plain.observation_space)
    assert more == {"map", "forecast", "forecast_radius"}
    for env in (with_map, plain):
        assert set(watch(env, 1)) == set(env.observation_space)


def test_an_empty_scene_is_all_zeros(scene):
    observation = watch(gymnasium.make("crowdnav/CrowdNav-v0", scenario=scene()), 2)
    for key in ("neighbors_valid", "history", "history_valid", "forecast", "neighbors_radius"):
        assert not observation[key].any(), key


def test_rewards_of_the_configuration_reach_the_environment(scene):
    env = gymnasium.make("crowdnav/CrowdNav-v0", scenario=scene(), time_weight=-3.0)
    env.reset(seed=0)
    *_, info = env.step((-1.0, 0.0))
    assert_allclose(info["rewards"]["time"], -3.0 * 0.2)
    assert dataclasses.asdict(env.unwrapped.episodes.config)["time_weight"] == -3.0


def test_a_photographed_place_is_shown_as_it_would_be_drawn(data_root):
    parameters = {"scene": "crowds_zara01", "data": str(data_root)}
    env = gymnasium.make(
        "crowdnav/CrowdNav-v0",
        scenario="replay",
        scenario_parameters=parameters,
        forecaster="none",
        observe_map=True,
    )
    observation, _ = env.reset(seed=0)
    own_place = tuple(observation["map"][MAP_PIXELS // 2, MAP_PIXELS // 4].tolist())
    assert own_place in {surface.color_rgb for surface in Surface if surface.walkable}
