import hashlib
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from crowdsim.behaviour import Behaviour
from crowdsim.forces import SocialForce
from crowdsim.map import Map
from crowdsim.pedestrians import Pedestrians
from crowdsim.recordings.recording import Recording
from crowdsim.robot_body import RobotBody
from crowdsim.scenario import Scenario
from crowdsim.world import World

SQUARE = Map(bounds=(-12.0, -12.0, 12.0, 12.0))
CALM = SocialForce(whim=0.0)


def scenario(
    position, waypoints, *, world_map=SQUARE, robot=(0.0, -11.0, 0.0), desired_speed=None, **changes
):
    crowd = Pedestrians.draw(
        np.random.default_rng(0),
        position=position,
        waypoints=waypoints,
        radius=0.25,
        desired_speed=desired_speed,
    )
    return Scenario(
        name="test",
        map=world_map,
        pedestrians=crowd,
        robot_start=robot,
        robot_goal=robot[:2],
        **changes,
    )


def nobody(**changes):
    return scenario(np.empty((0, 2)), np.empty((0, 1, 2)), **changes)


def world(start, *, seed=0, **changes):
    return World(start, rng=np.random.default_rng(seed), **changes)


def crossing(count=16, radius=6.0):
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    place = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return scenario(place, -place, on_arrival="return")


def digest_of_a_crossing():
    running = world(crossing(), robot=RobotBody())
    for _ in range(400):
        running.step((0.3, 0.9))
    state = running.positions.tobytes() + running.velocities.tobytes()
    return hashlib.sha256(state + running.robot_position.tobytes()).hexdigest()


def run(running, seconds, robot_velocity=None):
    for _ in range(round(seconds / running.physics_dt)):
        running.step(robot_velocity)


class TestWalking:
    def test_somebody_alone_walks_straight_at_the_desired_speed(self):
        running = world(scenario([[-5.0, 0.0]], [[5.0, 0.0]], desired_speed=1.2), social_force=CALM)
        run(running, 4.0)
        np.testing.assert_allclose(running.positions, [[-0.2, 0.0]], atol=1e-9)
        assert running.time == pytest.approx(4.0)

    def test_speed_grows_as_the_relaxation_time_says(self):
        start = scenario([[-5.0, 0.0]], [[5.0, 0.0]], desired_speed=1.0)
        still = replace(
            start.pedestrians, velocity=np.zeros((1, 2)), relaxation_time=np.array([0.8])
        )
        running = world(replace(start, pedestrians=still), social_force=CALM, physics_dt=0.001)
        run(running, 0.8)
        assert running.velocities[0, 0] == pytest.approx(1 - np.exp(-1), abs=1e-3)

    def test_two_who_meet_head_on_pass_without_touching_or_stopping(self):
        running = world(scenario([[-6.0, 0.0], [6.0, 0.0]], [[6.0, 0.0], [-6.0, 0.0]]))
        gap, slowest = np.inf, np.inf
        for _ in range(120):
            running.step()
            gap = min(gap, np.linalg.norm(np.subtract(*running.positions)) - 0.5)
            slowest = min(slowest, np.linalg.norm(running.velocities, axis=1).min())
        assert gap > 0.05
        assert slowest > 0.7
        assert running.positions[0, 0] > 0.5

    def test_crowd_of_a_square_keeps_moving(self):
        rng = np.random.default_rng(1)
        grid = np.stack(np.meshgrid(*2 * [np.linspace(-9, 9, 9)]), axis=-1).reshape(-1, 2)
        running = world(scenario(grid, rng.uniform(-9, 9, (81, 5, 2)), on_arrival="return"))
        run(running, 10.0)
        speed = []
        for _ in range(200):
            running.step()
            speed.append(np.linalg.norm(running.velocities, axis=1) / running.desired_speed)
        assert np.mean(speed) > 0.7
        assert np.mean(np.array(speed) < 0.1) < 0.05

    def test_people_pass_a_door_of_one_metre(self):
        walls = np.array([[[0.0, -12.0], [0.0, -0.5]], [[0.0, 0.5], [0.0, 12.0]]])
        place = np.array([(-6.0 + 1.2 * i, -3.0 + 1.5 * j) for i in range(4) for j in range(5)])
        running = world(scenario(place, place * [-1, 1], world_map=replace(SQUARE, walls=walls)))
        run(running, 30.0)
        assert (running.positions[:, 0] > 0).all()

    def test_who_stops_stands_at_the_goal(self):
        running = world(scenario([[0.0, 0.0]], [[3.0, 1.0]]), social_force=CALM)
        run(running, 12.0)
        np.testing.assert_allclose(running.positions, [[3.0, 1.0]], atol=0.01)
        np.testing.assert_allclose(running.velocities, 0.0, atol=0.01)

    def test_who_returns_walks_back_to_the_start(self):
        there_and_back = scenario(
            [[0.0, 0.0]], [[3.0, 0.0]], on_arrival="return", desired_speed=1.0
        )
        running = world(there_and_back)
        np.testing.assert_array_equal(running.goals, [[3.0, 0.0]])
        run(running, 3.5)
        np.testing.assert_array_equal(running.goals, [[0.0, 0.0]])


class TestEnteringAndLeaving:
    def test_a_respawned_pedestrian_is_somebody_new_at_the_start(self):
        running = world(scenario([[0.0, 0.0]], [[4.0, 0.0]], on_arrival="respawn"))
        while running.valid[0]:
            running.step()
        assert running.positions[0, 0] > 100.0
        running.step()
        assert running.valid[0]
        assert running.ids[0] == 1
        np.testing.assert_array_equal(running.positions, [[0.0, 0.0]])

    def test_nobody_enters_where_somebody_stands(self):
        start = scenario([[0.0, 0.0]], [[4.0, 0.0]], on_arrival="respawn", robot=(-3.0, 0.0, 0.0))
        running = world(start, robot=RobotBody(awareness=0.0))
        run(running, 2.0, (1.5, 0.0))
        run(running, 10.0)
        assert not running.valid[0]
        run(running, 2.0, (0.0, 1.0))
        assert running.valid[0]

    def test_ids_are_never_used_twice(self):
        place = np.array([[0.0, y] for y in range(5)])
        running = world(scenario(place, place + np.array([3.0, 0.0]), on_arrival="respawn"))
        owners = {}
        for _ in range(600):
            before, valid_before = running.positions, running.valid
            running.step()
            moved = np.linalg.norm(running.positions - before, axis=1)
            for row in np.flatnonzero(running.valid):
                known = owners.setdefault(int(running.ids[row]), row)
                assert known == row
                assert not valid_before[row] or moved[row] < 0.3
        assert len(owners) > 10


class TestSolidBodies:
    def test_nobody_crosses_a_thin_wall_however_hard_pushed(self):
        room = np.array([[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]])
        walls = np.stack([room, np.roll(room, -1, axis=0)], axis=1)
        place = np.array([(x, y) for x in (-1.4, 0.0, 1.4) for y in (-1.4, 0.0, 1.4)])
        place = place[np.abs(place).max(axis=1) > 0]
        start = scenario(
            place,
            place * 6,
            desired_speed=2.3,
            world_map=replace(SQUARE, walls=walls),
            robot=(0.1, 0.2, 0.0),
        )
        running = world(start, robot=RobotBody(), social_force=SocialForce(wall_repulsion=0.0))
        rng = np.random.default_rng(3)
        for _ in range(200):
            angle = rng.uniform(-np.pi, np.pi)
            run(running, 1.0, (3 * np.cos(angle), 3 * np.sin(angle)))
            assert np.abs(running.positions).max() < 2.0
            assert np.abs(running.robot_position).max() < 2.0

    def test_dense_counterflow_hardly_overlaps(self):
        walls = np.array([[[-12.0, -2.0], [12.0, -2.0]], [[-12.0, 2.0], [12.0, 2.0]]])
        place = np.array([(x, y) for x in np.arange(-5, 5, 0.7) for y in np.linspace(-1.6, 1.6, 6)])
        goal = np.where(place[:, :1] < 0, 1.0, -1.0) * [11.0, 0.0] + place * [0.0, 1.0]
        running = world(scenario(place, goal, world_map=replace(SQUARE, walls=walls)))
        overlaps = []
        for _ in range(200):
            running.step()
            apart = running.positions[:, None] - running.positions[None]
            distance = np.linalg.norm(apart, axis=-1)[np.triu_indices(len(place), 1)]
            overlaps.append(0.5 - distance[distance < 0.5])
        overlap = np.concatenate(overlaps)
        assert len(overlap) > 100
        assert np.percentile(overlap, 99) < 0.04
        assert overlap.max() < 0.10

    @pytest.mark.parametrize("apart", [0.0, 0.44])
    def test_bodies_cannot_start_inside_each_other(self, apart):
        message = rf"pedestrian 0 at \(1.*pedestrian 1 at .* {0.5 - apart:.3f} m inside each other"
        with pytest.raises(ValueError, match=message):
            world(scenario([[1.0, 1.0], [1.0 + apart, 1.0]], [[2.0, 0.0], [3.0, 0.0]]))

    def test_nobody_can_start_inside_the_robot(self):
        start = scenario([[1.0, 1.0], [3.0, 1.0]], [[2.0, 0.0]] * 2, robot=(3.3, 1.0, 0.0))
        with pytest.raises(ValueError, match=r"pedestrian 1 at .* and the robot at"):
            world(start, robot=RobotBody(radius=0.3))
        world(start)

    def test_bodies_may_start_as_near_as_in_a_dense_crowd(self):
        world(scenario([[1.0, 1.0], [1.46, 1.0]], [[2.0, 0.0], [3.0, 0.0]]))


class TestWallsBetween:
    def test_somebody_behind_a_wall_moves_nobody(self):
        walls = np.array([[[-9.0, 0.0], [9.0, 0.0]]])
        start = scenario(
            [[-6.0, 0.45], [6.0, -0.45]],
            [[6.0, 0.45], [-6.0, -0.45]],
            world_map=replace(SQUARE, walls=walls),
            desired_speed=1.3,
        )
        alone = replace(start.pedestrians, position=np.array([[-6.0, 0.45], [6.0, -8.0]]))
        running = [world(s, social_force=CALM) for s in (start, replace(start, pedestrians=alone))]
        aside = 0.0
        for _ in range(200):
            for each in running:
                each.step()
            aside = max(aside, abs(running[0].positions[0, 1] - running[1].positions[0, 1]))
        assert running[0].positions[0, 0] > 5.0
        assert aside < 0.005


class TestRobot:
    def test_robot_follows_its_command_exactly_in_the_open(self):
        running = world(nobody(robot=(1.0, 2.0, 0.0)), robot=RobotBody(max_acceleration=40.0))
        run(running, 2.0, (0.6, -0.8))
        np.testing.assert_allclose(running.robot_velocity, [0.6, -0.8])
        np.testing.assert_allclose(running.robot_position, [2.2, 0.4])

    def test_robot_accelerates_no_harder_than_it_can(self):
        running = world(nobody(), robot=RobotBody(max_acceleration=2.0))
        running.step((1.0, 0.0))
        np.testing.assert_allclose(running.robot_velocity, [0.1, 0.0])

    def test_clearance_is_measured_between_surfaces(self):
        start = scenario([[3.0, 0.0]], [[3.0, 0.0]], robot=(0.0, 0.0, 0.0))
        running = world(start, robot=RobotBody(radius=0.4))
        assert running.robot_clearance == pytest.approx(3.0 - 0.25 - 0.4)
        assert running.robot_wall_clearance == np.inf
        assert not running.robot_contact

    def test_contact_with_a_person_is_noticed_and_nobody_is_walked_through(self):
        start = scenario([[2.0, 0.0]], [[2.0, 0.0]], robot=(0.0, 0.0, 0.0))
        running = world(start, robot=RobotBody(awareness=0.0))
        touched = []
        for _ in range(40):
            running.step((1.2, 0.0))
            touched.append(running.robot_contact)
        assert any(touched)
        assert touched.index(True) == pytest.approx((2.0 - 0.55) / 1.2 / 0.05, abs=4)
        assert running.positions[0, 0] > running.robot_position[0] + 0.5

    def test_contact_with_a_wall_is_noticed(self):
        walls = np.array([[[1.0, -3.0], [1.0, 3.0]]])
        start = nobody(world_map=replace(SQUARE, walls=walls), robot=(0.0, 0.0, 0.0))
        running = world(start, robot=RobotBody(radius=0.3))
        assert running.robot_wall_clearance == pytest.approx(1.0 - 0.05 - 0.3)
        run(running, 2.0, (1.0, 0.2))
        assert running.robot_wall_contact
        assert running.robot_position[0] == pytest.approx(0.65, abs=0.03)
        assert running.robot_velocity[1] == pytest.approx(0.2, abs=0.05)

    @pytest.mark.parametrize("visible", [True, False])
    def test_people_turn_aside_for_a_visible_robot_only(self, visible):
        start = scenario([[-4.0, 0.05]], [[4.0, 0.05]], robot=(0.0, 0.0, 0.0))
        running = world(start, robot=RobotBody(awareness=float(visible)), social_force=CALM)
        touched = False
        for _ in range(100):
            running.step()
            touched |= running.robot_contact
        assert touched is not visible

    def test_the_share_who_notice_the_robot_is_drawn_and_changes_no_whim(self):
        rows = np.array([[x, y] for x in np.arange(-10, 10, 1.0) for y in np.arange(-10, 10, 1.0)])
        start = scenario(rows, rows + np.array([0.0, 5.0]), robot=(0.5, 0.5, 0.0))
        moved = [world(start, robot=RobotBody(awareness=share)) for share in (0.0, 0.5, 1.0)]
        for running in moved:
            running.step()
        unseen, some, seen = (running.velocities for running in moved)
        near = np.linalg.norm(rows - 0.5, axis=1) < 3.0
        feels = np.abs(some - unseen).max(axis=1) > 1e-12
        assert 0.25 < feels[near].mean() < 0.75
        np.testing.assert_allclose(some[feels], seen[feels], atol=1e-12)
        np.testing.assert_array_equal(some[~feels & near], unseen[~feels & near])

    def test_who_is_told_not_to_notice_the_robot_does_not(self):
        start = scenario([[-4.0, 0.05]], [[4.0, 0.05]], robot=(0.0, 0.0, 0.0))
        blind = replace(start.pedestrians, notices_robot=np.array([False]))
        running = world(replace(start, pedestrians=blind), robot=RobotBody(), social_force=CALM)
        run(running, 2.0)
        assert running.positions[0, 1] == pytest.approx(0.05, abs=1e-9)

    def test_social_forces_are_those_of_two_people(self):
        start = scenario([[1.0, 0.0]], [[-5.0, 0.0]], robot=(0.0, 0.0, 0.0), desired_speed=0.0)
        model = SocialForce(anisotropy=1.0)
        running = world(start, robot=RobotBody(radius=0.3, awareness=0.0), social_force=model)
        on_robot, on_pedestrians = running.robot_social_forces()
        strength = model.repulsion * np.exp((0.55 - 1.0) / model.repulsion_range)
        np.testing.assert_allclose(on_robot, [-strength, 0.0])
        np.testing.assert_allclose(on_pedestrians, [[strength, 0.0]])

    @pytest.mark.parametrize("command", [(np.nan, 0.0), (0.0, np.inf), (1.0,)])
    def test_broken_commands_are_refused(self, command):
        running = world(nobody(), robot=RobotBody())
        with pytest.raises(ValueError, match="robot_velocity: expected"):
            running.step(command)

    def test_a_world_without_a_robot_says_so(self):
        with pytest.raises(ValueError, match="no robot"):
            _ = world(nobody()).robot_position


class TestReplay:
    def recording(self):
        valid = np.array([[1, 0], [1, 1], [1, 1], [0, 1]], dtype=bool)
        track = np.array([[0.0, 0.0], [0.4, 0.1], [1.0, 0.1], [0.0, 0.0]])
        other = np.array([[0.0, 0.0], [5.0, 5.0], [5.0, 5.5], [5.0, 6.1]])
        return Recording(
            name="two",
            positions=np.stack([track, other], axis=1),
            valid=valid,
            ids=np.array([17, 4]),
            frames=np.arange(4),
        )

    def start(self, **changes):
        still = scenario(np.zeros((2, 2)), np.zeros((2, 1, 2)), **changes)
        return replace(still, replay=self.recording())

    def test_people_are_where_they_were_at_every_recorded_frame(self):
        running, recording = world(self.start()), self.recording()
        for row in range(4):
            np.testing.assert_array_equal(running.valid, recording.valid[row])
            seen = recording.valid[row]
            np.testing.assert_array_equal(running.positions[seen], recording.positions[row][seen])
            run(running, 0.4)
        assert not running.valid.any()
        np.testing.assert_array_equal(running.ids, [17, 4])
        np.testing.assert_array_equal(running.goals, [[1.0, 0.1], [5.0, 6.1]])

    def test_between_frames_they_move_evenly(self):
        running = world(self.start())
        run(running, 0.5)
        np.testing.assert_allclose(running.positions[0], [0.55, 0.1])
        np.testing.assert_allclose(running.velocities[0], [1.5, 0.0], atol=1e-12)

    def test_recorded_people_cannot_be_pushed_but_push(self):
        running = world(self.start(robot=(0.8, 0.1, 0.0)), robot=RobotBody())
        run(running, 0.8)
        np.testing.assert_array_equal(running.positions[0], [1.0, 0.1])
        assert running.robot_contact
        assert running.robot_position[0] > 1.2

    @pytest.mark.parametrize(
        "changes", [{"behaviour": Behaviour()}, {"entry_times": np.zeros(2)}], ids=str
    )
    def test_recorded_people_do_what_they_did(self, changes):
        with pytest.raises(ValueError, match="a replay takes no behaviour and no entry_times"):
            replace(self.start(), **changes)

    def test_physics_step_must_divide_the_frame(self):
        with pytest.raises(ValueError, match=r"whole part of the recording's 0\.4 s"):
            world(self.start(), physics_dt=0.07)


class TestDeterminism:
    def test_same_seed_gives_the_same_bits_in_another_process(self):
        command = "import test_world; print(test_world.digest_of_a_crossing())"
        root, here = Path(__file__).parents[2], Path(__file__).parent
        other = subprocess.run(
            [sys.executable, "-c", command],
            env={**os.environ, "PYTHONPATH": f"{root}{os.pathsep}{here}"},
            capture_output=True,
            text=True,
            check=True,
        )
        assert other.stdout.strip() == digest_of_a_crossing()

    def test_another_seed_gives_other_whims(self):
        one, other = world(crossing(), seed=0), world(crossing(), seed=1)
        one.step()
        other.step()
        assert (one.velocities != other.velocities).all()

    def test_arrays_given_out_are_not_the_state(self):
        running = world(crossing())
        kept = running.positions
        before = kept.copy()
        running.step()
        np.testing.assert_array_equal(kept, before)
