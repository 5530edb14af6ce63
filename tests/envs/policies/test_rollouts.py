import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from envs.policies.robot_motion import Limits, advance, feasible, steer
from envs.policies.rollouts import (
    Costs,
    Scene,
    past,
    people_cost,
    proximity,
    rollout,
    wall_cost,
    walls_seen,
    way_left,
)

WHEELS = Limits(False, 1.2, 1.5, 2.5, 0.3, 0.3, 0.2)
BALL = WHEELS._replace(holonomic=True)
COSTS = Costs(contact=100.0, slack=0.1, person=10.0, person_margin=0.5, spread=0.2, discount=0.5)
CONTROLS = st.floats(-3.0, 3.0)


@settings(deadline=None)
@given(a=CONTROLS, b=CONTROLS, last_speed=st.floats(0.0, 1.2), last_turn=st.floats(-1.5, 1.5))
def test_a_unicycle_keeps_its_limits(a, b, last_speed, last_turn):
    speed, turn = feasible(a, b, last_speed, last_turn, WHEELS)
    assert 0.0 <= speed <= WHEELS.speed
    assert abs(turn) <= WHEELS.angular_speed
    assert abs(speed - last_speed) <= WHEELS.acceleration * WHEELS.dt + 1e-12


@settings(deadline=None)
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
    assert proximity(0.5, 0.5, 10.0, COSTS) == 0.0
    assert proximity(0.3, 0.5, 10.0, COSTS) == pytest.approx(2.5)
    assert proximity(0.1, 0.5, 10.0, COSTS) == pytest.approx(10.0)
    assert proximity(0.09, 0.5, 10.0, COSTS) == pytest.approx(110.0)


def test_people_ahead_in_time_are_wider_and_count_less():
    people, reach = np.array([[1.0, 0.0], [50.0, 0.0]]), np.array([0.5, 0.5])
    sure = np.zeros(2)
    now = people_cost(0.0, 0.0, 0.0, people, reach, sure, COSTS)
    later = people_cost(0.0, 0.0, 1.0, people, reach, sure, COSTS)
    assert now == 0.0  # exactly `person_margin` away
    assert later == pytest.approx(0.5 * proximity(0.5, 0.7, 10.0, COSTS))


def test_people_of_whom_nobody_is_sure_are_wider():
    people, reach = np.array([[1.0, 0.0]]), np.array([0.5])
    wary = COSTS._replace(chance=0.5)
    cost = people_cost(0.0, 0.0, 0.0, people, reach, np.array([0.4]), wary)
    assert cost == pytest.approx(proximity(0.5, 0.7, 10.0, COSTS))


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


def test_walls_are_the_rays_that_hit_counter_clockwise_from_ahead():
    walls = walls_seen(np.array([1.0, 2.0, 10.0, 3.0]), 10.0, 0.6)
    expected = [(1.0, 0.0, 0.0, 0.0), (0.0, 2.0, 0.0, 0.0), (0.0, -3.0, 0.0, 0.0)]
    np.testing.assert_allclose(walls, expected, atol=1e-12)


def test_rays_that_leave_no_hole_between_them_hit_one_wall():
    ranges = np.full(64, 10.0)
    ranges[[0, 1]] = 1.0, 1.0 / math.cos(2.0 * math.pi / 64)  # a wall across x = 1
    walls = walls_seen(ranges, 10.0, 0.6)
    beside = 1.0, math.tan(2.0 * math.pi / 64)
    np.testing.assert_allclose(walls[0], (1.0, 0.0, 0.0, beside[1]), atol=1e-12)
    between = wall_cost(0.5, 0.5 * beside[1], walls, 0.35, COSTS)
    assert between == pytest.approx(proximity(0.15, COSTS.wall_margin, COSTS.wall, COSTS))
    assert wall_cost(-1.0, 0.0, walls, 0.35, COSTS) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("limits", [WHEELS, BALL])
@pytest.mark.parametrize("share", [1.5, 0.999])
def test_a_rollout_is_given_up_only_if_it_is_bound_to_cost_more(limits, share):
    nobody = np.zeros((24, 0, 2)), np.zeros(0), np.zeros((24, 0)), np.zeros((0, 4))
    scene = Scene(np.zeros(2), np.array([2.0, 0.5]), np.array([4.0, 1.0]), *nobody)
    controls = np.tile([0.8, 0.1], (24, 1))
    cost = rollout(controls.copy(), False, math.inf, scene, limits, COSTS)
    again = rollout(controls.copy(), False, share * cost, scene, limits, COSTS)
    assert again == (cost if share > 1.0 else math.inf)


def test_a_rollout_ends_at_the_goal():
    nobody = np.zeros((40, 0, 2)), np.zeros(0), np.zeros((40, 0)), np.zeros((0, 4))
    goal = np.array([1.0, 0.0])
    scene = Scene(np.zeros(2), goal, goal, *nobody)
    costs = []
    for steps in (20, 40):
        costs.append(rollout(np.zeros((steps, 2)), True, math.inf, scene, BALL, COSTS))
    assert costs[0] == costs[1]
