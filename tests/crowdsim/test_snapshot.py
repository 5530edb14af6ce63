"""A world that was put back, forked or sent elsewhere continues bit by bit like the original."""

import copy
import multiprocessing
import pickle
from dataclasses import replace

import numpy as np
import pytest

from crowdsim.behaviour import Behaviour
from crowdsim.bodies import SKIN
from crowdsim.forces import SocialForce
from crowdsim.map import Map
from crowdsim.pedestrians import Pedestrians
from crowdsim.recordings import Recording
from crowdsim.robot_body import RobotBody
from crowdsim.scenario import Scenario
from crowdsim.scenarios import make_scenario
from crowdsim.world import World

COMMAND = (0.9, 0.4)
EVERY_MODEL = {
    "social_force": 0.25,
    "headed_social_force": 0.25,
    "orca": 0.25,
    "constant_velocity": 0.25,
}


def packed(columns=7, model="social_force"):
    """Three people per square metre in a closed room, all of whom want to be elsewhere."""
    rng = np.random.default_rng(5)
    spacing = 3.0**-0.5
    half = columns * spacing / 2 + 0.1
    line = (np.arange(columns) + 0.5) * spacing - columns * spacing / 2
    place = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    place = place[np.linalg.norm(place, axis=1) > 0.6]
    room = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    crowd = Pedestrians.draw(
        rng,
        position=place,
        waypoints=rng.uniform(0.4 - half, half - 0.4, (len(place), 5, 2)),
        radius=0.25,
        model=model,
    )
    return Scenario(
        name="packed",
        map=Map(bounds=(-half, -half, half, half), walls=np.stack([room, np.roll(room, -1, 0)], 1)),
        pedestrians=crowd,
        robot_start=(0.0, 0.0, 0.0),
        robot_goal=(0.0, 1.0),
        on_arrival="return",
    )


def coming_and_going():
    return make_scenario("parallel_traffic", np.random.default_rng(1), pedestrians=30, width=3.0)


def distracted():
    """People of every model who come at times, pause, stop dead, change their minds, and leave."""
    behaviour = Behaviour(
        pause_rate=0.1, waypoint_pause=0.5, stop_rate=0.1, stop_time=1.0, goal_change_rate=0.2
    )
    start = packed(5, EVERY_MODEL)
    times = np.linspace(0.0, 5.0, len(start.pedestrians))
    return replace(start, behaviour=behaviour, entry_times=times, on_arrival="respawn")


def recorded():
    """Four people who walk past the robot and leave."""
    start = packed()
    steps = np.arange(40.0)[:, None, None]
    track = np.array([[-2.0, 0.3], [-1.0, -0.4], [1.0, 0.1], [0.0, 2.0]])
    positions = track + steps * np.array([[0.1, 0.0], [0.12, 0.01], [-0.1, 0.0], [0.0, -0.1]])
    valid = np.ones((40, 4), dtype=bool)
    valid[30:, 1] = valid[:5, 2] = False
    recording = Recording(
        name="four",
        positions=np.where(valid[..., None], positions, 0.0),
        valid=valid,
        ids=np.arange(4),
        frames=np.arange(40),
    )
    crowd = Pedestrians.draw(
        np.random.default_rng(0), position=track, waypoints=track + 1.0, radius=0.25
    )
    return replace(start, replay=recording, pedestrians=crowd, on_arrival="stop")


SCENARIOS = {
    "packed": packed,
    "every_model": lambda: packed(5, EVERY_MODEL),
    "coming_and_going": coming_and_going,
    "distracted": distracted,
    "recorded": recorded,
}


def world(scenario, seed=0):
    robot = RobotBody(awareness=0.5)  # who notices it is drawn from the generator
    return World(scenario, rng=np.random.default_rng(seed), robot=robot)


def run(running, steps):
    """Bits of everything that can be seen, after so many steps with the robot driving."""
    for _ in range(steps):
        running.step(COMMAND)
    return bits(running)


def bits(running):
    on_robot, on_pedestrians = running.robot_social_forces()
    seen = (
        running.positions,
        running.velocities,
        running.valid,
        running.ids,
        running.goals,
        running.robot_position,
        running.robot_velocity,
        on_robot,
        on_pedestrians,
    )
    contact = running.robot_contact, running.robot_wall_contact
    clearance = running.robot_clearance, running.robot_wall_clearance
    return [array.tobytes() for array in seen], contact, clearance, running.time, running.held_count


def continue_elsewhere(message, steps):
    """What a fresh process makes of a snapshot that was sent to it."""
    running = world(packed(5), seed=99)
    running.restore(pickle.loads(message))
    return run(running, steps)


def test_a_packed_crowd_touches_all_the_time():
    running = world(packed())
    touching = []
    for _ in range(100):
        running.step(COMMAND)
        apart = running.positions[:, None] - running.positions
        pairs = np.linalg.norm(apart, axis=-1)[np.triu_indices(len(running.ids), 1)]
        touching.append((pairs < 0.5 + 2 * SKIN).sum())
    assert np.mean(touching) > 10


def test_a_fork_of_a_packed_crowd_walks_like_the_original():
    original = world(packed())
    run(original, 300)
    fork = original.fork()
    for _ in range(20):
        assert run(fork, 100) == run(original, 100)


@pytest.mark.parametrize("name", SCENARIOS)
@pytest.mark.parametrize("steps_before", [0, 1, 137])
def test_restored_forked_and_untouched_worlds_are_the_same(name, steps_before):
    scenario = SCENARIOS[name]()
    untouched, original = world(scenario), world(scenario)
    run(untouched, steps_before)
    run(original, steps_before)
    snapshot = original.snapshot()
    fork = original.fork()
    later = run(original, 250)
    assert run(untouched, 250) == later
    assert run(fork, 250) == later
    for _ in range(2):
        original.restore(snapshot)
        assert run(original, 250) == later
    rebuilt = world(scenario, seed=77)
    rebuilt.restore(snapshot)
    assert run(rebuilt, 250) == later


def test_a_fork_goes_its_own_way_beside_the_original():
    original = world(packed(5))
    run(original, 50)
    expected = run(original.fork(), 100)
    fork = original.fork()
    for _ in range(100):
        fork.step((-1.0, 0.0))
        original.step(COMMAND)
    assert bits(original) == expected
    assert bits(fork) != expected


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_fork_without_the_robot_leaves_the_original_as_it_is(name):
    original = world(SCENARIOS[name]())
    run(original, 20)
    expected = run(original.fork(), 50)
    gone = original.without_robot()
    assert gone.valid.tolist() == original.valid.tolist()
    for _ in range(50):
        gone.step()
    assert gone.robot_clearance > 1000
    assert not gone.robot_contact
    assert run(original, 50) == expected


def test_another_process_continues_a_snapshot():
    running = world(packed(5))
    run(running, 200)
    message = pickle.dumps(running.snapshot())
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        elsewhere = pool.apply(continue_elsewhere, (message, 300))
    assert elsewhere == run(running, 300)


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_attribute_that_changes_is_in_the_state(name):
    running = world(SCENARIOS[name]())
    parts = running._parts()
    before = {part: copy_of_attributes(holder) for part, holder in parts.items()}
    run(running, 300)
    for part, holder in parts.items():
        after = copy_of_attributes(holder)
        changed = {key for key in after if after[key] != before[part][key]}
        measured_anew = {key for key in changed if key.startswith("robot_")}
        assert changed - measured_anew <= set(holder.STATE)


def copy_of_attributes(part):
    plain = (bool, int, float, str, np.ndarray, np.random.Generator)
    return {
        key: pickle.dumps(copy.deepcopy(value))
        for key, value in vars(part).items()
        if isinstance(value, plain)
    }


def changed(scenario, **columns):
    return replace(scenario, pedestrians=replace(scenario.pedestrians, **columns))


@pytest.mark.parametrize(
    "other",
    [
        lambda start: packed(7),
        lambda start: packed(5, EVERY_MODEL),
        lambda start: replace(start, on_arrival="stop"),
        lambda start: replace(start, behaviour=Behaviour()),
        lambda start: changed(start, mass=start.pedestrians.mass + 1.0),
        lambda start: replace(start, map=Map(bounds=start.map.bounds)),
    ],
    ids=["people", "models", "arrival", "behaviour", "mass", "map"],
)
def test_a_snapshot_of_another_scenario_is_refused(other):
    start = packed(5)
    snapshot = world(start).snapshot()
    running = world(other(start))
    before = bits(running)
    with pytest.raises(ValueError, match=r"built from the same scenario \(packed"):
        running.restore(snapshot)
    assert bits(running) == before


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("physics_dt", {"physics_dt": 0.025}),
        ("robot", {"robot": None}),
        ("robot", {"robot": RobotBody(mass=51.0)}),
        ("models", {"social_force": SocialForce(whim=0.0)}),
    ],
)
def test_a_snapshot_of_a_world_with_another_setting_is_refused(name, changes):
    snapshot = world(packed(5)).snapshot()
    settings = {"robot": RobotBody(awareness=0.5), **changes}
    with pytest.raises(ValueError, match=f"built from the same {name}"):
        World(packed(5), rng=np.random.default_rng(0), **settings).restore(snapshot)
