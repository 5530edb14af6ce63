"""People pause, stop dead and change their minds as often and as long as they are told to."""

from dataclasses import replace

import numpy as np
import pytest
from test_world import CALM, SQUARE, run, scenario, world

from crowdsim.behaviour import Behaviour
from crowdsim.motion import MODEL_NAMES
from crowdsim.pedestrians import Pedestrians
from crowdsim.robot_body import RobotBody
from crowdsim.scenario import Scenario
from crowdsim.scenarios import make_scenario
from crowdsim.world import World

ALWAYS = 1e9  # [1/s]


def hall(count=12, *, model="social_force", group=-1, apart=20.0, **changes):
    """People who walk along lanes far from each other, 2 km long."""
    place = np.stack([np.zeros(count), apart * np.arange(count)], axis=1)
    crowd = Pedestrians.draw(
        np.random.default_rng(3),
        position=place,
        waypoints=place + np.array([2000.0, 0.0]),
        desired_speed=1.3,
        model=model,
        group=group,
    )
    return Scenario(
        name="hall",
        map=SQUARE,
        pedestrians=crowd,
        robot_start=(0.0, -11.0, 0.0),
        robot_goal=(0.0, -11.0),
        **changes,
    )


def speeds(running, steps):
    rows = []
    for _ in range(steps):
        running.step()
        rows.append(np.linalg.norm(running.velocities, axis=1))
    return np.array(rows)


def stretches(standing):
    """Lengths of the runs of True in `(T, N)` that begin and end within."""
    lengths = []
    for column in standing.T:
        edges = np.flatnonzero(np.diff(column.astype(int)))
        edges = edges[1:] if column[0] else edges
        lengths += list(np.diff(edges)[::2])
    return np.array(lengths)


@pytest.mark.parametrize(
    ("behaviour", "rate", "seconds"),
    [
        (Behaviour(pause_rate=0.1, pause_time=4.0), 0.1, 4.0),
        (Behaviour(stop_rate=0.2, stop_time=2.0), 0.2, 2.0),
    ],
    ids=["pause", "stop"],
)
def test_rates_and_durations_are_those_asked_for(behaviour, rate, seconds):
    running = world(hall(40, behaviour=behaviour), social_force=CALM)
    distractions = running._distractions
    standing = []
    for _ in range(2000):
        running.step()
        standing.append(distractions.stands_until > distractions._step)
    standing = np.array(standing)
    lengths = 0.05 * stretches(standing)
    walked = 0.05 * (~standing).sum()
    assert len(lengths) == pytest.approx(rate * walked, rel=0.2)
    assert lengths.mean() == pytest.approx(seconds, rel=0.1)
    assert lengths.min() > 0.45 * seconds
    assert np.percentile(lengths, 95) < 1.55 * seconds  # some follow each other at once


@pytest.mark.parametrize("model", MODEL_NAMES)
def test_people_of_every_model_stop_and_walk_on(model):
    behaviour = Behaviour(stop_rate=0.2, stop_time=3.0)
    seen = speeds(world(hall(model=model, behaviour=behaviour), social_force=CALM), 1500)
    assert 0.15 < (seen < 0.1).mean() < 0.55
    assert ((seen > 0.9 * 1.3).mean(axis=0) > 0.2).all()


def test_a_sudden_stop_takes_less_than_a_stride_and_a_pause_does_not():
    def path(behaviour):
        running = world(hall(1, behaviour=behaviour), social_force=CALM)
        running.step()
        run(running, 1.0)
        return running.positions[0, 0]

    assert path(Behaviour(stop_rate=ALWAYS)) < 0.25
    assert 0.4 < path(Behaviour(pause_rate=ALWAYS)) < 0.8


def test_people_pause_at_the_waypoints_asked_for():
    place = np.array([[0.0, 20.0 * i] for i in range(40)])
    way = place[:, None] + np.array([[3.0, 0.0], [50.0, 0.0]])
    start = scenario(place, way, desired_speed=1.3)
    start = replace(start, behaviour=Behaviour(waypoint_pause=0.5, pause_time=10.0))
    running = world(start, social_force=CALM)
    run(running, 5.5)
    paused = np.linalg.norm(running.velocities, axis=1) < 0.1
    assert 0.3 < paused.mean() < 0.7
    np.testing.assert_array_less(running.positions[paused, 0], 4.0)
    np.testing.assert_array_less(5.0, running.positions[~paused, 0])


def test_who_changes_the_goal_walks_to_another_ones_and_stays_who_he_is():
    start = scenario([[-5.0, 0.0], [5.0, 8.0]], [[5.0, 0.0], [-5.0, 8.0]])
    running = world(replace(start, behaviour=Behaviour(goal_change_rate=1.0)))
    goals = set()
    for _ in range(400):
        running.step()
        goals.add(tuple(running.goals[0]))
    assert goals == {(5.0, 0.0), (-5.0, 8.0)}
    np.testing.assert_array_equal(running.ids, [0, 1])


def test_who_changes_the_goal_walks_around_walls():
    walls = np.array([[[-12.0, 2.0], [8.0, 2.0]]])
    # The straight ways of both are free, but from one's start to the other's goal they are not.
    start = scenario(
        [[-5.0, 0.0], [-5.0, 5.0]],
        [[-1.0, 0.0], [-1.0, 5.0]],
        world_map=replace(SQUARE, walls=walls),
        desired_speed=1.5,
        on_arrival="return",
    )
    running = world(replace(start, behaviour=Behaviour(goal_change_rate=0.2)))
    sides = np.array([np.sign(running.positions[:, 1] - 2.0)])
    for _ in range(2000):
        running.step()
        sides = np.append(sides, [np.sign(running.positions[:, 1] - 2.0)], axis=0)
    assert running.held_count == 0
    assert (np.abs(np.diff(sides, axis=0)).max(axis=0) > 0).all()


def test_a_new_person_has_the_planned_way_again():
    start = scenario(
        [[0.0, 0.0], [0.0, 8.0]], [[4.0, 0.0], [-4.0, 8.0]], on_arrival="respawn", desired_speed=1.5
    )
    running = world(replace(start, behaviour=Behaviour(goal_change_rate=0.3)))
    changed, renewed = 0, 0
    for _ in range(3000):
        ids = running.ids
        running.step()
        changed += tuple(running.goals[0]) == (-4.0, 8.0)
        if running.ids[0] != ids[0]:
            renewed += 1
            np.testing.assert_array_equal(running.goals[0], [4.0, 0.0])
    assert changed > 100
    assert renewed > 5


def test_members_of_a_group_pause_together():
    behaviour = Behaviour(pause_rate=0.2)
    group = np.repeat(np.arange(4), 3)
    running = world(hall(12, group=group, apart=1.0, behaviour=behaviour), social_force=CALM)
    some = False
    for _ in range(600):
        running.step()
        until = running._distractions.stands_until.reshape(4, 3)
        np.testing.assert_array_equal(until, until[:, :1].repeat(3, axis=1))
        some |= len(np.unique(until[:, 0])) > 1
    assert some


def test_no_behaviour_and_one_that_does_nothing_walk_alike():
    paths = []
    for behaviour in (None, Behaviour()):
        start = make_scenario("parallel_traffic", np.random.default_rng(0), pedestrians=10)
        running = world(replace(start, behaviour=behaviour), robot=RobotBody(awareness=0.5))
        run(running, 20.0)
        paths.append(running.positions)
    np.testing.assert_array_equal(*paths)


def test_every_scenario_takes_a_behaviour_by_name():
    start = make_scenario("parallel_traffic", np.random.default_rng(0), behaviour={"stop_rate": 1})
    assert start.behaviour == Behaviour(stop_rate=1)
    with pytest.raises(ValueError, match=r"behaviour: expected pause_rate, .*, found stops"):
        make_scenario("parallel_traffic", np.random.default_rng(0), behaviour={"stops": 1})


def test_the_twin_without_the_robot_is_distracted_alike():
    start = hall(behaviour=Behaviour(pause_rate=0.2))
    with_robot, twin = world(start, robot=RobotBody()), world(start)
    run(with_robot, 20.0)
    run(twin, 20.0)
    np.testing.assert_array_equal(
        with_robot._distractions.stands_until, twin._distractions.stands_until
    )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"pause_rate": -0.1}, r"behaviour pause_rate: expected .* >= 0, found -0\.1"),
        ({"stop_time": np.nan}, "behaviour stop_time: expected a finite"),
        ({"waypoint_pause": 1.5}, r"waypoint_pause: expected 0 to 1, found 1\.5"),
    ],
)
def test_what_nobody_can_do_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        Behaviour(**changes)


def test_who_leaves_for_good_does_not_come_back():
    running = World(
        scenario([[0.0, 0.0], [0.0, 5.0]], [[2.0, 0.0], [9.0, 5.0]], on_arrival="leave"),
        rng=np.random.default_rng(0),
    )
    run(running, 5.0)
    np.testing.assert_array_equal(running.valid, [False, True])
    run(running, 20.0)
    assert not running.valid.any()
    np.testing.assert_array_equal(running.ids, [0, 1])


def test_people_enter_at_their_time_as_soon_as_there_is_room():
    start = scenario(
        [[0.0, 0.0], [0.0, 0.0], [0.0, 0.0]],
        [[9.0, 0.0]] * 3,
        on_arrival="leave",
        entry_times=np.array([0.0, 0.2, 5.0]),
        desired_speed=1.0,
    )
    running = world(start)
    entered = {}
    for _ in range(200):
        running.step()
        for row in np.flatnonzero(running.valid):
            entered.setdefault(row, running.time)
    assert entered[0] == pytest.approx(0.05)
    assert 0.6 < entered[1] < 1.0  # there was no room before
    assert entered[2] == pytest.approx(5.0)
    assert len(set(running.ids)) == 3


def test_entering_is_checked():
    with pytest.raises(ValueError, match=r"entry_times must be finite seconds >= 0, got -1\.0"):
        scenario([[0.0, 0.0]], [[9.0, 0.0]], entry_times=np.array([-1.0]))
    with pytest.raises(ValueError, match=r"entry_times must be \(1,\), got \(2,\)"):
        scenario([[0.0, 0.0]], [[9.0, 0.0]], entry_times=np.zeros(2))
