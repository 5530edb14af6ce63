"""Steps made in one call of a kernel are those made one by one, and part by part."""

import numpy as np
import pytest

from crowdsim.robot_body import RobotBody
from crowdsim.scenarios import make_scenario
from crowdsim.world import CONTACT_GAP, World

COMMANDS = np.random.default_rng(3).uniform(-1.5, 1.5, (240, 2))
CROWDS = {
    "circular_crossing": {"pedestrians": 20, "on_arrival": "respawn"},
    "bottleneck": {},
    "perpendicular_traffic": {},
    "group_crossing": {},
}


def world(name, robot=True):
    rng = np.random.default_rng(1)
    body = RobotBody(awareness=0.5) if robot else None
    return World(make_scenario(name, rng, **CROWDS[name]), rng=rng, robot=body)


def state(running):
    return np.concatenate([running.positions.ravel(), running.velocities.ravel(), running.ids])


@pytest.mark.parametrize("name", CROWDS)
def test_a_run_is_the_same_as_its_steps(name):
    stepped, run = world(name), world(name)
    for commands in np.split(COMMANDS, 40):
        before = np.concatenate([run.positions, run.velocities], axis=1)
        passage = run.run(commands)
        clearances = []
        for command in commands:
            stepped.step(command)
            clearances.append((stepped.robot_clearance, stepped.robot_wall_clearance))
        np.testing.assert_array_equal(state(run), state(stepped))
        np.testing.assert_array_equal(passage.states[0, :-1], before)
        np.testing.assert_array_equal(passage.states[-1, -1, :2], run.robot_position)
        np.testing.assert_array_equal(passage.clearances[1:], clearances)
    assert run.step_count == stepped.step_count == len(COMMANDS)
    assert run.held_count == stepped.held_count
    assert run.robot_contact == (run.robot_clearance <= CONTACT_GAP)


@pytest.mark.parametrize("robot", [True, False])
@pytest.mark.parametrize("name", ["circular_crossing", "bottleneck"])
def test_the_kernel_makes_the_steps_that_its_parts_make(name, robot):
    in_one, by_parts = world(name, robot), world(name, robot)
    assert in_one._dynamics._is_free
    vars(by_parts._dynamics)["_is_free"] = False  # a cached property
    for command in COMMANDS:
        for running in (in_one, by_parts):
            running.step(command if robot else None)
    np.testing.assert_array_equal(state(in_one), state(by_parts))
    assert in_one.robot_clearance == by_parts.robot_clearance


def test_a_run_wants_finite_velocities_and_a_robot():
    with pytest.raises(ValueError, match=r"expected \(S, 2\) finite numbers"):
        world("circular_crossing").run(np.array([[0.0, np.nan]]))
    with pytest.raises(ValueError, match=r"expected \(S, 2\) finite numbers"):
        world("circular_crossing").run(np.zeros(2))
    with pytest.raises(ValueError, match="no robot"):
        world("circular_crossing", robot=False).run(np.zeros((1, 2)))


def test_a_world_that_takes_over_a_solver_moves_as_if_it_had_built_one():
    def crowded(seed, former=None):
        rng = np.random.default_rng(seed)
        scenario = make_scenario("circular_crossing", rng, pedestrians=40)
        return World(scenario, rng=rng, robot=RobotBody(), former=former)

    former, fresh = crowded(1), crowded(2)
    former.run(COMMANDS)
    solver = former._solid._solver
    heir = crowded(2, former)
    assert heir._solid._solver is solver
    assert former._solid._solver is not solver
    for commands in np.split(COMMANDS, 40):
        np.testing.assert_array_equal(heir.run(commands).states, fresh.run(commands).states)


def test_a_solver_is_not_taken_over_where_it_does_not_fit():
    former = world("circular_crossing")
    former.run(COMMANDS)
    solver = former._solid._solver
    rng = np.random.default_rng(1)
    more = make_scenario("circular_crossing", rng, pedestrians=21)
    assert World(more, rng=rng, robot=RobotBody(), former=former)._solid._solver is not solver
