import numpy as np
import pytest
from hand_made_observations import Drive, add_person, empty_observation, stack

from envs.config import CrowdNavConfig
from envs.policies import MPPIParameters, MPPIPolicy, StraightPolicy
from envs.policies.scenes import interpolation

ROBOTS = ["unicycle", "holonomic", "bicycle"]
CROSSING = [((4.0, 4.0), (0.0, -1.0))]
ONCOMING = [((8.0, y), (-1.2, 0.0)) for y in (-1.0, 0.0, 1.0)]
STANDING = [((4.0, 0.0), (0.0, 0.0))]


def crowded(config, seed):
    """A robot on its way among five people at random places."""
    rng = np.random.default_rng(seed)
    observation = empty_observation(config, goal=rng.uniform(-8, 8, 2), velocity=(0.5, 0.0, 0.0))
    for slot in range(5):
        add_person(observation, config, slot, rng.uniform(-4, 4, 2), rng.uniform(-1.5, 1.5, 2))
    observation["lidar"][:] = rng.uniform(1.0, config.sensor_range, config.lidar_rays)
    return observation


@pytest.mark.parametrize("robot", ROBOTS)
def test_plans_do_not_depend_on_how_many_worlds_run_side_by_side(robot):
    config = CrowdNavConfig(robot=robot)
    together, observations = MPPIPolicy(config), [crowded(config, seed) for seed in range(3)]
    alone = [MPPIPolicy(config) for _ in observations]
    for _ in range(3):  # the second and third plan start from the one before
        batch = together.act(stack(observations))
        for policy, observation, actions in zip(alone, observations, batch, strict=True):
            np.testing.assert_array_equal(policy.act(observation), actions)


def test_reset_forgets_the_plans_of_the_masked_worlds_only():
    config = CrowdNavConfig()
    observations = stack([crowded(config, 0), crowded(config, 1)])
    policy, untouched = MPPIPolicy(config), MPPIPolicy(config)
    fresh = policy.act(observations)
    untouched.act(observations)
    policy.reset(np.array([True, False]))
    again, continued = policy.act(observations), untouched.act(observations)
    np.testing.assert_array_equal(again[0], fresh[0])
    np.testing.assert_array_equal(again[1], continued[1])
    assert not np.array_equal(continued[0], fresh[0])


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("goal", [(8.0, 0.0), (-5.0, 3.0), (0.0, 1.4)])
def test_an_empty_place_is_crossed_almost_as_fast_as_by_driving_straight(robot, goal):
    config = CrowdNavConfig(robot=robot)
    planned, straight = Drive(config, goal=goal), Drive(config, goal=goal)
    assert planned.run(MPPIPolicy(config))
    assert straight.run(StraightPolicy(config))
    assert planned.time <= 1.15 * straight.time + 0.4


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("people", [CROSSING, ONCOMING, STANDING])
def test_it_passes_people_whom_driving_straight_would_hit(robot, people):
    config = CrowdNavConfig(robot=robot)
    straight, planned = Drive(config, people=people), Drive(config, people=people)
    straight.run(StraightPolicy(config))
    assert straight.clearance < 0.0
    assert planned.run(MPPIPolicy(config), seconds=12.0)
    assert planned.clearance > 0.15


def test_without_forecasts_people_are_expected_to_stand_still():
    blind, seeing = CrowdNavConfig(forecaster="none"), CrowdNavConfig()
    observation = crowded(blind, 2)
    standing = dict(observation)
    standing["forecast"] = np.repeat(observation["history"][:, -1:], seeing.forecast_steps, axis=1)
    np.testing.assert_array_equal(
        MPPIPolicy(blind).act(observation), MPPIPolicy(seeing).act(standing)
    )


def test_after_the_last_forecast_people_are_held_where_it_ends():
    config = CrowdNavConfig()
    long = crowded(config, 3)
    long["forecast"][:, 3:] = long["forecast"][:, 2:3]
    short = long | {"forecast": long["forecast"][:, :3]}
    np.testing.assert_array_equal(MPPIPolicy(config).act(short), MPPIPolicy(config).act(long))


def test_what_lies_in_empty_slots_does_not_count():
    config = CrowdNavConfig()
    observation = crowded(config, 4)
    haunted = {key: value.copy() for key, value in observation.items()}
    haunted["forecast"][5:] = haunted["history"][5:] = 0.3
    haunted["neighbors_radius"][5:] = 1.0
    np.testing.assert_array_equal(
        MPPIPolicy(config).act(observation), MPPIPolicy(config).act(haunted)
    )


@pytest.mark.parametrize("robot", ROBOTS)
def test_it_brakes_in_front_of_a_wall(robot):
    config = CrowdNavConfig(robot=robot)
    observation = empty_observation(config, goal=(6.0, 0.0), velocity=(1.0, 0.0, 0.0))
    free = MPPIPolicy(config).act(observation)
    angles = 2.0 * np.pi * np.arange(config.lidar_rays) / config.lidar_rays
    facing = np.cos(angles) > 0.1
    observation["lidar"][facing] = np.minimum(0.55 / np.cos(angles[facing]), config.sensor_range)
    blocked = MPPIPolicy(config).act(observation)
    assert speed_ahead(free, config) > 0.8
    slowest = 1.0 - config.max_acceleration * config.policy_dt
    assert speed_ahead(blocked, config) == pytest.approx(slowest, abs=0.05)


def speed_ahead(action, config):
    """Speed ahead that an action commands [m/s]."""
    scale = 0.5 * (action[0] + 1.0) if config.robot != "holonomic" else action[0]
    return scale * config.max_speed


def test_interpolation_is_linear_between_frames_and_constant_after_the_last():
    weights = interpolation(np.array([0.2, 0.4, 0.7, 9.0]), np.array([0.0, 0.4, 0.8]))
    values = weights @ np.array([0.0, 1.0, 3.0])
    np.testing.assert_allclose(values, [0.5, 1.0, 2.5, 3.0])


def test_a_horizon_that_is_no_whole_number_of_steps_is_refused():
    with pytest.raises(ValueError, match="horizon"):
        MPPIPolicy(CrowdNavConfig(), MPPIParameters(horizon=4.7))
