"""The optimizing planner, wherever CasADi is installed."""

import numpy as np
import pytest
from hand_made_observations import Drive, add_person, empty_observation, stack

from envs.config import CrowdNavConfig
from envs.policies import StraightPolicy, make_policy

pytest.importorskip("casadi", reason="the extra nmpc is not installed")

ROBOTS = ["unicycle", "holonomic", "bicycle"]
CROSSING = [((4.0, 4.0), (0.0, -1.0))]
STANDING = [((4.0, 0.1), (0.0, 0.0))]


def crowded(config, seed):
    rng = np.random.default_rng(seed)
    observation = empty_observation(config, goal=rng.uniform(-8, 8, 2), velocity=(0.5, 0.0, 0.0))
    for slot in range(5):
        add_person(observation, config, slot, rng.uniform(-4, 4, 2), rng.uniform(-1.5, 1.5, 2))
    return observation


@pytest.mark.parametrize("robot", ROBOTS)
def test_actions_are_within_bounds_and_do_not_depend_on_other_worlds(robot):
    config = CrowdNavConfig(robot=robot)
    observations = [crowded(config, seed) for seed in range(4)]
    together, alone = (make_policy("nmpc", config) for _ in range(2))
    for _ in range(2):
        batch = together.act(stack(observations))
        assert np.abs(batch).max() <= 1.0
        np.testing.assert_array_equal(batch[2], alone.act(observations[2]))


def test_a_new_episode_knows_no_old_plan():
    config = CrowdNavConfig()
    used, fresh = (make_policy("nmpc", config) for _ in range(2))
    used.act(stack([crowded(config, 0), crowded(config, 1)]))
    used.reset(np.array([False, True]))
    again = used.act(stack([crowded(config, 0), crowded(config, 2)]))
    np.testing.assert_array_equal(again[1], fresh.act(crowded(config, 2)))


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("people", [CROSSING, STANDING])
def test_it_passes_people_whom_driving_straight_would_hit(people, robot):
    config = CrowdNavConfig(robot=robot)
    straight, drive = Drive(config, people=people), Drive(config, people=people)
    straight.run(StraightPolicy(config))
    assert straight.clearance < 0.0
    assert drive.run(make_policy("nmpc", config))
    assert drive.clearance > 0.0
    assert drive.time < 1.3 * 8.0 / config.max_speed + 1.0


def test_it_brakes_before_a_wall():
    config = CrowdNavConfig(robot="holonomic")
    observation = empty_observation(config, goal=(6.0, 0.0), velocity=(0.3, 0.0, 0.0))
    angles = 2.0 * np.pi * np.arange(config.lidar_rays) / config.lidar_rays
    ahead = np.cos(angles) > 0.2
    distance = (config.robot_radius + 0.15) / np.cos(angles[ahead])
    observation["lidar"][ahead] = np.minimum(distance, config.sensor_range)
    assert make_policy("nmpc", config).act(observation)[0] * config.max_speed < 0.3
