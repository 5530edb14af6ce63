import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from envs.policies.rollouts import (
    Limits,
    advance,
    feasible,
    past,
    proximity,
    steer,
    wall_points,
    way_left,
)

WHEELS = Limits(False, 1.2, 1.5, 2.5, 0.3, 0.3, 0.2)
BALL = WHEELS._replace(holonomic=True)
CONTROLS = st.floats(-3.0, 3.0)


@given(a=CONTROLS, b=CONTROLS, last_speed=st.floats(0.0, 1.2), last_turn=st.floats(-1.5, 1.5))
def test_a_unicycle_keeps_its_limits(a, b, last_speed, last_turn):
    speed, turn = feasible(a, b, last_speed, last_turn, WHEELS)
    assert 0.0 <= speed <= WHEELS.speed
    assert abs(turn) <= WHEELS.angular_speed
    assert abs(speed - last_speed) <= WHEELS.acceleration * WHEELS.dt + 1e-12


@given(a=CONTROLS, b=CONTROLS, speed=st.floats(0.0, 1.2), course=st.floats(-3.2, 3.2))
def test_a_holonomic_robot_keeps_its_limits(a, b, speed, course):
    last = speed * math.cos(course), speed * math.sin(course)
    velocity = feasible(a, b, *last, BALL)
    assert math.hypot(*velocity) <= BALL.speed + 1e-9
    assert math.dist(velocity, last) <= BALL.acceleration * BALL.dt + 1e-9


def test_a_full_turn_of_a_unicycle_ends_where_it_began():
    steps = 1000
    limits = WHEELS._replace(dt=2.0 * math.pi / steps)
    pose = (1.0, 2.0, 0.3)
    for _ in range(steps):
        pose = advance(*pose, 1.0, 1.0, limits)
    np.testing.assert_allclose(pose, (1.0, 2.0, 0.3 + 2.0 * math.pi), atol=1e-9)


def test_cost_of_nearness_is_a_parabola_and_contact_comes_on_top():
    assert proximity(0.5, 0.5, 10.0, 100.0) == 0.0
    assert proximity(0.25, 0.5, 10.0, 100.0) == pytest.approx(2.5)
    assert proximity(0.0, 0.5, 10.0, 100.0) == pytest.approx(10.0)
    assert proximity(-0.01, 0.5, 10.0, 100.0) == pytest.approx(110.0)


def test_the_way_leads_over_the_waypoint_until_it_is_passed():
    waypoint, goal = np.array([2.0, 0.0]), np.array([2.0, 3.0])
    assert way_left(0.0, 0.0, waypoint, goal) == pytest.approx(5.0)
    assert way_left(2.5, 3.0, waypoint, goal) == pytest.approx(0.5)
    assert past(2.1, 1.0, waypoint)
    assert not past(1.9, 1.0, waypoint)


def test_steering_turns_left_to_a_target_on_the_left():
    speed, turn = steer(0.0, 0.0, 0.0, np.array([1.0, 1.0]), WHEELS)
    assert 0.0 < speed < WHEELS.speed
    assert turn > 0.0
    np.testing.assert_allclose(steer(0.0, 0.0, 0.0, np.array([0.0, 2.0]), BALL), (0.0, 1.2))


def test_wall_points_are_the_rays_that_hit_counter_clockwise_from_ahead():
    points = wall_points(np.array([1.0, 2.0, 10.0, 3.0]), 10.0)
    np.testing.assert_allclose(points, [(1.0, 0.0), (0.0, 2.0), (0.0, -3.0)], atol=1e-12)
