"""The time gap by hand: who walks behind whom, and how much that slows."""

import math
from dataclasses import replace

import numpy as np
import pytest

from crowdsim.following import NARROWNESS, allowed_speed, allowed_speeds, braking, follow
from crowdsim.forces import SocialForce
from crowdsim.map import Map
from crowdsim.pedestrians import Pedestrians
from crowdsim.scenario import Scenario
from crowdsim.world import World

BOTH = np.array([[0, 1]])
RIGHT = np.array([[1.0, 0.0], [1.0, 0.0]])
RADIUS = np.array([0.25, 0.25])


def at(*rows):
    return np.array(rows, dtype=float)


def test_straight_behind_somebody_the_speed_is_the_free_way_over_the_time_gap():
    assert allowed_speed(1.3, 0.0, 1.0, 0.0, 0.5, 0.8) == pytest.approx((1.3 - 0.5) / 0.8)


def test_to_the_side_the_free_way_is_longer_and_the_gap_shorter():
    free = 1.3 - math.sqrt(0.5**2 - 0.3**2)
    expected = free / (0.8 * (1 - 0.3 / 0.5) ** NARROWNESS)
    assert allowed_speed(1.3, 0.3, 1.0, 0.0, 0.5, 0.8) == pytest.approx(expected)


@pytest.mark.parametrize("place", [(-1.0, 0.0), (1.0, 0.5), (0.3, -0.6)])
def test_nobody_follows_those_behind_or_beside_the_way(place):
    assert allowed_speed(*place, 1.0, 0.0, 0.5, 0.8) == math.inf


def test_who_touches_somebody_ahead_is_to_stop():
    assert allowed_speed(0.48, 0.0, 1.0, 0.0, 0.5, 0.8) == 0.0


def test_only_the_one_behind_follows():
    limit = allowed_speeds(BOTH, at((0, 0, 1, 0), (1, 0, 1, 0)), RADIUS, RIGHT, 0.8)
    np.testing.assert_allclose(limit, [0.5 / 0.8, math.inf])


def test_of_two_whose_ways_meet_only_the_one_farther_back_follows():
    to_the_door = np.array([[2.0, 0.2], [1.8, -0.2]])
    facing = to_the_door / np.linalg.norm(to_the_door, axis=1, keepdims=True)
    limit = allowed_speeds(BOTH, at((0, 0, 1, 0), (0.2, 0.4, 1, 0)), RADIUS, facing, 0.8)
    assert limit[0] < 1.0
    assert limit[1] == math.inf


@pytest.mark.parametrize("other", [(-1.0, 0.0), (0.0, 1.0), (0.0, 0.0)])
def test_who_comes_along_crosses_or_stands_is_not_followed(other):
    direction = np.array([[1.0, 0.0], other])
    limit = allowed_speeds(BOTH, at((0, 0, 1, 0), (1, 0, 0, 0)), RADIUS, direction, 0.8)
    assert limit[0] == math.inf


def test_nobody_follows_the_robot():
    limit = allowed_speeds(BOTH, at((0, 0, 1, 0), (1, 0, 1, 0)), RADIUS, RIGHT[:1], 0.8)
    assert limit.tolist() == [math.inf]


def test_braking_makes_up_the_difference_in_the_relaxation_time_but_not_more_than_it_may():
    assert braking(1.0, 1.2, 1.0, 0.5, 5.0) == pytest.approx(1.0 + 0.2 / 0.5)
    assert braking(1.0, 1.2, 1.0, 0.5, 0.7) == 0.7
    assert braking(-2.0, 1.2, 1.0, 0.5, 5.0) == 0.0  # somebody else makes it brake already
    assert braking(1.0, 1.2, math.inf, 0.5, 5.0) == 0.0


def test_it_acts_against_the_wanted_direction_alone_whatever_its_length():
    total = np.array([[1.0, 0.6], [1.0, -0.4]])
    bodies = at((0, 0, 1.2, 0), (1.3, 0, 1.2, 0))
    follow(BOTH, bodies, RADIUS, 0.5 * RIGHT, np.array([0.5, 0.5]), 0.8, 5.0, total)
    np.testing.assert_allclose(total, [[(1.0 - 1.2) / 0.5, 0.6], [1.0, -0.4]])


def test_two_in_single_file_settle_at_the_time_gap():
    model = replace(SocialForce(), repulsion=0.0, whim=0.0, hold_back=5.0)
    place = np.array([[0.0, 0.0], [2.0, 0.0]])
    crowd = Pedestrians.draw(
        np.random.default_rng(0),
        position=place,
        waypoints=[[80.0, 0.0], [82.0, 0.0]],
        desired_speed=[1.5, 0.8],
        radius=0.25,
    )
    scenario = Scenario(
        name="file",
        map=Map(bounds=(-1.0, -1.0, 90.0, 1.0)),
        pedestrians=crowd,
        robot_start=(80.0, 0.9, 0.0),
        robot_goal=(80.0, 0.9),
    )
    world = World(scenario, rng=np.random.default_rng(1), social_force=model)
    for _ in range(600):
        world.step()
    gap = world.positions[1, 0] - world.positions[0, 0] - 0.5
    assert world.velocities[0, 0] == pytest.approx(0.8, abs=0.01)
    assert gap == pytest.approx(0.8 * model.time_gap, abs=0.02)
