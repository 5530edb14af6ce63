import numpy as np
import pytest
from hand_made_observations import Drive, empty_observation

from envs.config import CrowdNavConfig
from envs.policies import StraightPolicy


def test_a_unicycle_turns_towards_the_waypoint_before_it_drives():
    policy = StraightPolicy(CrowdNavConfig())
    ahead = policy.act(empty_observation(CrowdNavConfig(), goal=(5.0, 0.0)))
    left = policy.act(empty_observation(CrowdNavConfig(), goal=(0.0, 5.0)))
    behind = policy.act(empty_observation(CrowdNavConfig(), goal=(-5.0, 0.1)))
    np.testing.assert_allclose(ahead, [1.0, 0.0])
    np.testing.assert_allclose(left, [-1.0, 1.0], atol=1e-6)
    np.testing.assert_allclose(behind, [-1.0, 1.0])


def test_a_holonomic_robot_moves_sideways_at_full_speed():
    config = CrowdNavConfig(robot="holonomic")
    action = StraightPolicy(config).act(empty_observation(config, goal=(0.0, -5.0)))
    np.testing.assert_allclose(action, [0.0, -1.0], atol=1e-6)


def test_the_waypoint_comes_before_the_goal():
    config = CrowdNavConfig(robot="holonomic")
    observation = empty_observation(config, goal=(5.0, 0.0), waypoint=(0.0, 2.0))
    np.testing.assert_allclose(StraightPolicy(config).act(observation), [0.0, 1.0], atol=1e-6)


@pytest.mark.parametrize("robot", ["unicycle", "holonomic", "bicycle"])
@pytest.mark.parametrize("goal", [(8.0, 0.0), (-5.0, 3.0), (0.0, 0.8)])
def test_it_reaches_goals_all_around_without_circling(robot, goal):
    config = CrowdNavConfig(robot=robot)
    drive = Drive(config, goal=goal)
    # A bicycle needs room and time for what lies within its turning circle.
    turning = 5.0 if robot == "bicycle" else np.pi / config.max_angular_speed
    assert drive.run(StraightPolicy(config), np.hypot(*goal) / config.max_speed + turning + 1.0)
