"""Nobody walks through walls, hardly into each other, and nothing drifts or leaks.

The same tests also run for up to 10^6 steps, some minutes each, and log what they measure:

    CROWDSIM_LONG=1 python -m pytest tests/crowdsim/test_rigid_contacts.py --log-cli-level=INFO
"""

import logging
import os
from pathlib import Path

import numpy as np
import pytest

import crowdsim.bodies
from crowdsim.forces import SocialForce
from crowdsim.map import Map
from crowdsim.pedestrians import Pedestrians
from crowdsim.robot_body import RobotBody
from crowdsim.scenario import Scenario
from crowdsim.scenarios import make_scenario
from crowdsim.world import World

LOG = logging.getLogger(__name__)
ROOM = 2.0  # edge of the rooms that people try to break out of [m]
MEMORY = Path("/proc/self/statm")
FASTEST = 3.0  # of people and robot [m/s]

long_run = (
    pytest.mark.skipif("CROWDSIM_LONG" not in os.environ, reason="minutes: set CROWDSIM_LONG=1"),
    pytest.mark.timeout(3600),
)


def steps_or(short, long):
    return pytest.mark.parametrize("steps", [short, pytest.param(long, marks=long_run)])


def world(scenario, **changes):
    return World(scenario, rng=np.random.default_rng(0), **changes)


def start(position, goals, walls, half, **changes):
    bounds = (-half, -half, half, half)
    return Scenario(
        name="rooms",
        map=Map(bounds=bounds, walls=walls),
        pedestrians=Pedestrians.draw(
            np.random.default_rng(1), position=position, waypoints=goals, **changes
        ),
        robot_start=(0.5 * ROOM, 0.5 * ROOM, 0.0),
        robot_goal=(0.5 * ROOM, 0.5 * ROOM),
        on_arrival="return",
    )


def four_rooms():
    """Thirteen people in four rooms without doors who all want to be in the opposite one."""
    lines = [-ROOM, 0.0, ROOM]
    walls = [[[x, -ROOM], [x, ROOM]] for x in lines] + [[[-ROOM, y], [ROOM, y]] for y in lines]
    offsets = np.array([[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]])
    middles = ROOM * offsets
    place = (middles[:, None] + offsets).reshape(-1, 2)[:-3]  # three make room for the robot
    place[-1] = middles[-1] - 0.6
    return start(
        place, -3.0 * place, np.array(walls), 4 * ROOM, desired_speed=FASTEST / 1.3, radius=0.25
    )


def packed_room(columns, seed=5):
    """Three people per square metre, of all sizes, who walk about in a closed room."""
    rng = np.random.default_rng(seed)
    spacing = 3.0**-0.5
    inside = columns * spacing / 2
    line = (np.arange(columns) + 0.5) * spacing - inside
    place = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    half = inside + crowdsim.bodies.WALL_RADIUS
    corners = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    walls = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    goals = rng.uniform(0.4 - inside, inside - 0.4, (len(place), 8, 2))
    return start(place, goals, walls, 2 * half)


def counterflow():
    """Three people per square metre, two streams against each other in a corridor."""
    rng = np.random.default_rng(2)
    spacing = 3.0**-0.5
    x, y = (np.arange(16) - 7.5) * spacing, (np.arange(6) - 2.5) * spacing
    place = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    half = 3 * spacing + crowdsim.bodies.WALL_RADIUS
    walls = np.array([[[-8.0, side], [8.0, side]] for side in (-half, half)])
    goals = np.column_stack([np.where(rng.random(len(place)) < 0.5, 7.0, -7.0), place[:, 1]])
    return start(place, goals, walls, 8.0)


@steps_or(10_000, 1_000_000)
def test_nobody_breaks_out_of_a_room(steps, monkeypatch):
    monkeypatch.setattr(crowdsim.bodies, "WALL_RADIUS", 0.025)  # 5 cm thick, half of ours
    careless = SocialForce(wall_repulsion=0.0, max_speed_ratio=1.3)
    robot = RobotBody(max_acceleration=40.0)
    running = world(four_rooms(), social_force=careless, robot=robot)
    rooms = np.sign(running.positions)
    rng = np.random.default_rng(3)
    crossings, fastest = 0, 0.0
    for step in range(steps):
        if step % 20 == 0:
            angle = rng.uniform(-np.pi, np.pi)
            command = (FASTEST * np.cos(angle), FASTEST * np.sin(angle))
        running.step(command)
        positions, robot_position = running.positions, running.robot_position
        crossings += (np.sign(positions) != rooms).any() or (np.abs(positions) > ROOM).any()
        crossings += (robot_position < 0.0).any() or (robot_position > ROOM).any()
        fastest = max(
            fastest, np.abs(running.velocities).max(), np.abs(running.robot_velocity).max()
        )
    LOG.info("%d steps: %d crossings, %d held back", steps, crossings, running.held_count)
    assert crossings == 0
    assert fastest > 0.9 * FASTEST


@pytest.mark.parametrize("scene", [lambda: packed_room(7), counterflow], ids=["room", "corridor"])
@steps_or(2_000, 100_000)
def test_bodies_hardly_overlap_at_three_per_square_metre(steps, scene):
    running = world(scene())
    radius = running.radius
    i, j = np.triu_indices(len(radius), 1)
    overlaps = []
    for step in range(steps):
        running.step()
        if step % 20 == 0 or step < 200:
            apart = running.positions[i] - running.positions[j]
            overlap = radius[i] + radius[j] - np.sqrt((apart**2).sum(axis=1))
            overlaps.append(overlap[overlap > 0])
    overlap = np.concatenate(overlaps)
    high, most = np.percentile(overlap, 99), overlap.max()
    LOG.info(
        "%d steps: %.1f pairs touch, overlap of these: 99th percentile %.1f cm, largest %.1f cm",
        steps, len(overlap) / len(overlaps), 100 * high, 100 * most,
    )  # fmt: skip
    assert len(overlap) > 100  # else nobody was pushed, and nothing was measured
    assert high < 0.05
    assert most < 0.10


@pytest.mark.skipif(not MEMORY.exists(), reason="tells the memory in use on Linux only")
@steps_or(10_000, 1_000_000)
def test_nothing_drifts_or_leaks(steps):
    scenario = make_scenario("parallel_traffic", np.random.default_rng(0), pedestrians=10)
    running = world(scenario, robot=RobotBody())
    walk(running, steps // 10)
    before = memory_in_use()
    walk(running, steps - steps // 10)
    grown = memory_in_use() - before
    LOG.info("%d steps: %d people came, memory grew by %d KiB", steps, running.ids.max(), grown)
    assert grown < 1000
    x_min, y_min, x_max, y_max = scenario.map.bounds
    here = running.positions[running.valid]
    assert ((here > (x_min, y_min)) & (here < (x_max, y_max))).all()
    assert np.isfinite(running.velocities).all()
    assert np.linalg.norm(running.velocities, axis=1).mean() > 0.5
    assert running.time == pytest.approx(steps * 0.05)
    assert len(set(running.ids)) == len(running.ids)
    fork = running.fork()
    walk(running, 500)
    walk(fork, 500)
    np.testing.assert_array_equal(running.positions, fork.positions)


def memory_in_use():
    """Resident memory of this process [KiB]."""
    pages = int(MEMORY.read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") // 1024


def walk(running, steps):
    for step in range(steps):
        running.step((1.0 if step // 300 % 2 == 0 else -1.0, 0.0))
