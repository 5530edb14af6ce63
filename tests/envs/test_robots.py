import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from crowdsim.map import Map
from crowdsim.pedestrians import Pedestrians
from crowdsim.scenario import Scenario
from envs.config import make_config
from envs.robots import (
    Bicycle,
    Holonomic,
    RobotState,
    Unicycle,
    checked_actions,
    make_robot,
    to_robot,
    to_world,
    wrap_angle,
)
from envs.worlds import Worlds

BICYCLE = Bicycle(1.2, 2.5, 0.6, 0.5)


def drive(robot, action, seconds, *, dt=0.001, heading=0.0):
    """Integrates a robot whose body follows the asked velocity perfectly."""
    state = RobotState.zeros(1)
    state.restart(0, (1.0, 2.0, heading))
    robot.apply(np.array([action], dtype=float), state)
    planned = robot.rollout(state, np.array([seconds]))[0, 0]
    for velocity in np.moveaxis(robot.drive(state, dt, round(seconds / dt)), 1, 0):
        state.position += velocity * dt
        state.velocity[:] = velocity
    return state, planned


def test_unicycle_full_action_is_full_speed_ahead():
    state, _ = drive(Unicycle(1.2, 1.5), (1.0, 0.0), 2.0, heading=np.pi / 2)
    assert_allclose(state.position[0], (1.0, 2.0 + 2.4), atol=1e-9)


def test_unicycle_does_not_drive_backwards():
    state, _ = drive(Unicycle(1.2, 1.5), (-1.0, 0.0), 2.0)
    assert_allclose(state.position[0], (1.0, 2.0))


def test_unicycle_positive_second_action_turns_left():
    state, _ = drive(Unicycle(1.0, 1.0), (1.0, 1.0), np.pi / 2)
    # A quarter of a circle of radius 1 whose centre is to the left.
    assert_allclose(state.position[0], (2.0, 3.0), atol=2e-3)
    assert_allclose(state.heading[0], np.pi / 2, atol=1e-3)


def test_holonomic_moves_in_its_own_frame_and_keeps_its_heading():
    state, _ = drive(Holonomic(1.2), (0.0, 0.5), 1.0, heading=np.pi / 2)
    assert_allclose(state.position[0], (1.0 - 0.6, 2.0), atol=1e-9)  # left of north is west
    assert state.heading[0] == np.pi / 2


def test_holonomic_actions_beyond_the_disc_are_shortened():
    state = RobotState.zeros(2)
    Holonomic(1.2).apply(np.array([[1.0, 1.0], [0.3, 0.4]]), state)
    assert_allclose(np.hypot(*state.command.T), (1.2, 0.6))


@pytest.mark.parametrize("robot", [Unicycle(1.2, 1.5), Holonomic(1.2), BICYCLE])
@pytest.mark.parametrize("action", [(0.7, 0.4), (0.2, 0.0), (0.5, -1.0)])
def test_rollout_is_where_the_robot_gets_to(robot, action):
    state, planned = drive(robot, action, 2.0, heading=0.7)
    assert_allclose(planned, state.position[0], atol=2e-3)


def test_a_bicycle_cannot_turn_where_it_stands():
    state, _ = drive(BICYCLE, (-1.0, 1.0), 2.0)
    assert_allclose(state.position[0], (1.0, 2.0))
    assert state.heading[0] == 0.0


def test_a_bicycle_steers_around_its_turning_circle():
    # tan(0.6) / 0.5 is the curvature: half a circle later it is a diameter to the left.
    radius = 0.5 / np.tan(0.6)
    eager = Bicycle(1.0, 1e6, 0.6, 0.5)
    state, _ = drive(eager, (1.0, 1.0), np.pi * radius)
    assert_allclose(state.position[0], (1.0, 2.0 + 2.0 * radius), atol=5e-3)


def test_a_bicycle_gains_speed_by_its_acceleration():
    state, _ = drive(BICYCLE, (1.0, 0.0), 0.4)
    assert_allclose(state.position[0, 0], 1.0 + 0.5 * 2.5 * 0.4**2, atol=2e-3)


@settings(max_examples=40, deadline=None)
@given(
    kind=st.sampled_from(["unicycle", "holonomic", "bicycle"]),
    action=st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)),
    heading=st.floats(-3.0, 3.0),
    before=st.integers(0, 8),
)
def test_rollout_is_where_the_physics_takes_the_robot(kind, action, heading, before):
    config = make_config(robot=kind)
    robot, worlds = make_robot(config), Worlds(config, 1, record=False)
    worlds.restart(0, nobody_there(heading), np.random.default_rng(0))
    robot.apply(np.array([action]), worlds.robots)
    # Rollouts of these two take it that they move by their command already.
    for _ in range(before if kind == "bicycle" else 4):
        worlds.step(robot)
    planned = robot.rollout(worlds.robots, np.arange(1.0, 11.0) * config.policy_dt)[0]
    for position in planned:
        worlds.step(robot)
        # A physics step of a turn at full speed is not an arc, but nearly.
        assert_allclose(worlds.robots.position[0], position, atol=0.1)


def nobody_there(heading):
    return Scenario(
        name="by_hand",
        map=Map(bounds=(-20.0, -20.0, 20.0, 20.0)),
        pedestrians=Pedestrians.draw(
            np.random.default_rng(0), position=np.zeros((0, 2)), waypoints=np.zeros((0, 2))
        ),
        robot_start=(0.0, 0.0, heading),
        robot_goal=(8.0, 0.0),
        time_limit=10.0,
    )


def test_rollout_of_many_equals_rollouts_of_each():
    robot, rng = Unicycle(1.2, 1.5), np.random.default_rng(0)
    state = RobotState.zeros(5)
    state.position[:] = rng.normal(size=(5, 2))
    state.heading[:] = rng.uniform(-3, 3, 5)
    robot.apply(rng.uniform(-1, 1, (5, 2)), state)
    times = np.arange(1, 13) * 0.4
    together = robot.rollout(state, times)
    for world in range(5):
        alone = robot.rollout(state.rows(np.array([world])), times)
        assert (together[world] == alone[0]).all()


def test_actions_are_clipped_and_nan_is_refused():
    assert_allclose(checked_actions([[3.0, -7.0]], 1), [[1.0, -1.0]])
    with pytest.raises(ValueError, match="actions must be finite"):
        checked_actions([[0.0, np.nan]], 1)
    with pytest.raises(ValueError, match=r"actions must have shape \(2, 2\), got \(1, 2\)"):
        checked_actions([[0.0, 0.0]], 2)


@pytest.mark.parametrize("action", ["ab", [0.1, None], [1j, 0.0], [True, False], {"speed": 1.0}])
def test_actions_that_are_no_real_numbers_are_refused(action):
    with pytest.raises(ValueError, match="actions must be real numbers"):
        checked_actions([action], 1)


def test_the_configuration_chooses_the_robot():
    assert make_robot(make_config(robot="holonomic", max_speed=0.9)) == Holonomic(0.9)


def test_what_is_ahead_of_the_robot_is_at_plus_x():
    heading = np.array([np.pi / 2, np.pi])
    ahead = np.array([[0.0, 3.0], [-3.0, 0.0]])
    assert_allclose(to_robot(ahead, heading), [[3.0, 0.0], [3.0, 0.0]], atol=1e-12)
    points = np.random.default_rng(0).normal(size=(2, 4, 3, 2))
    assert_allclose(to_world(to_robot(points, heading), heading), points)


def test_wrapped_angles_point_the_same_way():
    angle = np.linspace(-20, 20, 101)
    assert_allclose(np.exp(1j * wrap_angle(angle)), np.exp(1j * angle), atol=1e-12)
    assert np.abs(wrap_angle(angle)).max() <= np.pi
