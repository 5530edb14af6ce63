"""Policies that choose a velocity or a control for now: ORCA, social force, dynamic window."""

import numpy as np
import pytest
from hand_made_observations import Drive, add_person, empty_observation, stack

from envs.config import CrowdNavConfig
from envs.policies import DWAPolicy, ORCAPolicy, SocialForcePolicy, StraightPolicy

POLICIES = [DWAPolicy, ORCAPolicy, SocialForcePolicy]
ROBOTS = ["unicycle", "holonomic", "bicycle"]
CROSSING = [((4.0, 4.0), (0.0, -1.0))]
ONCOMING = [((8.0, 0.1), (-1.0, 0.0))]
STANDING = [((4.0, 0.1), (0.0, 0.0))]


def crowded(config, seed):
    rng = np.random.default_rng(seed)
    observation = empty_observation(config, goal=rng.uniform(-8, 8, 2), velocity=(0.5, 0.0, 0.0))
    for slot in range(5):
        add_person(observation, config, slot, rng.uniform(-4, 4, 2), rng.uniform(-1.5, 1.5, 2))
    observation["lidar"][:] = rng.uniform(0.5, config.sensor_range, config.lidar_rays)
    return observation


@pytest.mark.parametrize("make", POLICIES)
@pytest.mark.parametrize("robot", ROBOTS)
def test_actions_are_within_bounds_and_do_not_depend_on_other_worlds(make, robot):
    config = CrowdNavConfig(robot=robot)
    observations = [crowded(config, seed) for seed in range(30)]
    batch = make(config).act(stack(observations))
    assert np.abs(batch).max() <= 1.0 + 1e-6
    for observation, actions in zip(observations, batch, strict=True):
        np.testing.assert_array_equal(make(config).act(observation), actions)


@pytest.mark.parametrize("make", POLICIES)
@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("goal", [(8.0, 0.0), (-5.0, 3.0), (0.0, 1.4)])
def test_an_empty_place_is_crossed_almost_as_fast_as_by_driving_straight(make, robot, goal):
    config = CrowdNavConfig(robot=robot)
    driven, straight = Drive(config, goal=goal), Drive(config, goal=goal)
    assert driven.run(make(config))
    assert straight.run(StraightPolicy(config))
    assert driven.time <= 1.4 * straight.time + 0.6


@pytest.mark.parametrize("make", POLICIES)
@pytest.mark.parametrize("people", [CROSSING, ONCOMING, STANDING])
def test_it_passes_people_whom_driving_straight_would_hit(make, people):
    config = CrowdNavConfig(robot="holonomic")
    straight, drive = Drive(config, people=people), Drive(config, people=people)
    straight.run(StraightPolicy(config))
    assert straight.clearance < 0.0
    assert drive.run(make(config))
    assert drive.clearance > 0.0


def towards_a_wall(make, gap):
    """Speed that a holonomic robot at 0.3 m/s chooses at such a gap before a wall."""
    config = CrowdNavConfig(robot="holonomic")
    observation = empty_observation(config, goal=(6.0, 0.0), velocity=(0.3, 0.0, 0.0))
    angles = 2.0 * np.pi * np.arange(config.lidar_rays) / config.lidar_rays
    ahead, distance = np.cos(angles) > 0.2, config.robot_radius + gap
    observation["lidar"][ahead] = np.minimum(distance / np.cos(angles[ahead]), config.sensor_range)
    return make(config).act(observation)[0] * config.max_speed


@pytest.mark.parametrize("make", [DWAPolicy, ORCAPolicy])
def test_it_brakes_before_a_wall(make):
    assert towards_a_wall(make, 0.05) < 0.15


def test_a_wall_repels_as_it_repels_people():
    free, near = (towards_a_wall(SocialForcePolicy, gap) for gap in (2.0, 0.05))
    # 2 m/s^2 exp(-0.05 / 0.08) over a step of 0.2 s
    assert free - near == pytest.approx(0.2 * 2.0 * np.exp(-0.05 / 0.08), rel=0.02)


@pytest.mark.parametrize("make", [ORCAPolicy, SocialForcePolicy])
def test_who_was_seen_once_is_taken_to_stand(make):
    config = CrowdNavConfig(robot="holonomic")
    known, new = (empty_observation(config) for _ in range(2))
    add_person(known, config, 0, (2.0, 0.3), (0.0, 0.0))
    add_person(new, config, 0, (2.0, 0.3), (-1.0, 0.0))
    new["history_valid"][0, :-1] = 0.0
    np.testing.assert_array_equal(make(config).act(known), make(config).act(new))


def test_the_dynamic_window_uses_forecasts():
    config = CrowdNavConfig(robot="holonomic")
    told, untold = (empty_observation(config) for _ in range(2))
    for observation in (told, untold):
        add_person(observation, config, 0, (1.5, 1.5), (0.0, -1.0))
    untold["forecast"][0] = untold["history"][0, -1]
    policy = DWAPolicy(config)
    assert not np.array_equal(policy.act(told), policy.act(untold))
