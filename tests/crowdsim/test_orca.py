import math
from dataclasses import replace

import numpy as np
import pytest
from test_world import SQUARE, run, scenario, world

from crowdsim.distance_field import DistanceField
from crowdsim.half_planes import nearest_permitted
from crowdsim.line_of_sight import list_walls
from crowdsim.motion import MotionModel
from crowdsim.orca import Orca, avoid, person_plane, wall_planes
from crowdsim.velocity_obstacle import way_out

MODEL = Orca(wavering=0.0)
NO_WALLS = np.empty((0, 2, 2))


def orca(position, waypoints, **changes):
    start = scenario(position, waypoints, **changes)
    model = np.full(len(position), MotionModel.ORCA)
    return replace(start, pedestrians=replace(start.pedestrians, model=model))


def choose(bodies, direction, *, walls=NO_WALLS, model=MODEL, gives_way=None, noticed=True):
    """Velocities (M, 2) that everybody of (M, 4), 0.25 m wide and wanting 1.3 m/s, chooses."""
    count, dt = len(bodies), 0.05
    field = DistanceField(walls, (-20.0, -20.0, 20.0, 20.0))
    acceleration = np.zeros((count, 2))
    avoid(
        np.ones(count, dtype=bool) if gives_way is None else np.array(gives_way),
        np.ones(count - (not noticed), dtype=bool),
        np.full(count, noticed),
        bodies,
        np.ones(count, dtype=bool),
        np.full(count, 0.25),
        direction,
        np.full(count, 1.3),
        np.full(count, 1.7),
        np.zeros((count, 2)),
        dt,
        walls,
        field.grid,
        field.origin,
        field.cell,
        list_walls(walls, model.interaction_range),
        replace(model, max_acceleration=1e9).record(),
        acceleration,
    )
    return bodies[:, 2:] + dt * acceleration


def random_crowd(count, seed=0, spread=12.0):
    """Bodies (N, 4) that do not overlap, and directions (N, 2)."""
    rng = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(*2 * [np.arange(-spread, spread, 1.0)]), axis=-1).reshape(-1, 2)
    place = rng.permutation(grid)[:count] + rng.uniform(-0.2, 0.2, (count, 2))
    angle = rng.uniform(-np.pi, np.pi, count)
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.concatenate([place, rng.normal(0, 0.8, (count, 2))], axis=1), direction


class TestVelocityObstacle:
    def test_straight_on_the_way_out_is_to_the_nearer_leg(self):
        ux, uy, nx, ny = way_out(4.0, 0.0, 2.0, 0.0, 0.5, 2.0, 0.05)
        # The leg leaves the axis by asin(0.5 / 4): it is 2 sin of that away.
        assert math.hypot(ux, uy) == pytest.approx(2.0 * 0.5 / 4.0)
        assert (nx, ny) == pytest.approx((-0.125, -math.sqrt(1 - 0.125**2)))

    def test_whoever_comes_too_slowly_to_meet_in_time_may_come_faster(self):
        # At T the disc has its centre at 2 m/s and a radius of 0.25 m/s.
        way = way_out(4.0, 0.0, 1.0, 0.0, 0.5, 2.0, 0.05)
        assert way == pytest.approx((0.75, 0.0, -1.0, 0.0))

    def test_who_overlaps_parts_within_a_step(self):
        way = way_out(0.4, 0.0, 0.0, 0.0, 0.5, 2.0, 0.05)
        assert way == pytest.approx((-2.0, 0.0, -1.0, 0.0))

    def test_each_takes_half_or_one_takes_all(self):
        body, other = np.array([0.0, 0.0, 1.0, 0.0]), np.array([4.0, 0.0, -1.0, 0.0])
        half = person_plane(body, other, 0.5, 0.5, 2.0, 0.05)
        whole = person_plane(body, other, 0.5, 1.0, 2.0, 0.05)
        np.testing.assert_allclose(
            np.subtract(whole[:2], body[2:]), 2 * np.subtract(half[:2], body[2:])
        )
        assert half[2:] == whole[2:]

    def test_both_see_the_same_evasion_from_their_side(self):
        rng = np.random.default_rng(0)
        for _ in range(100):
            x, y, vx, vy = rng.normal(0, [2, 2, 1, 1])
            way = way_out(x, y, vx, vy, 0.5, 3.0, 0.05)
            np.testing.assert_allclose(
                way_out(-x, -y, -vx, -vy, 0.5, 3.0, 0.05), np.negative(way), atol=1e-12
            )

    def test_two_who_do_their_half_do_not_meet_within_the_horizon(self):
        rng = np.random.default_rng(1)
        evasions = 0
        for _ in range(300):
            one, other = rng.normal(0, [2, 2, 0.5, 0.5], (2, 4))
            one[2:] += 0.5 * (other[:2] - one[:2])
            if np.linalg.norm(one[:2] - other[:2]) < 0.5:
                continue
            chosen = [
                nearest_permitted(
                    np.array([person_plane(a, b, 0.5, 0.5, 3.0, 0.05)]), 1, 0, *a[2:], 10.0
                )
                for a, b in ((one, other), (other, one))
            ]
            evasions += chosen[0] != tuple(one[2:])
            time = np.linspace(0, 3, 601)[:, None]
            apart = one[:2] - other[:2] + time * np.subtract(*chosen)
            assert np.linalg.norm(apart, axis=1).min() > 0.5 - 1e-6
        assert evasions > 30


class TestWalls:
    def test_half_plane_by_hand(self):
        planes = np.zeros((2, 4))
        walls = np.array([[[1.0, -5.0], [1.0, 5.0]], [[-9.0, -5.0], [-9.0, 5.0]]])
        body = np.array([0.0, 0.0, 1.0, 1.0])
        model = Orca(wall_horizon=0.5).record()
        assert wall_planes(body, 0.25, 2.0, walls, model, planes) == 1
        np.testing.assert_allclose(planes[0], [(1.0 - 0.25 - 0.05) / 0.5, 0.0, -1.0, 0.0])

    def test_along_a_wall_nobody_is_slower_and_into_it_nobody_walks(self):
        walls = np.array([[[-10.0, 0.32], [10.0, 0.32]]])
        bodies = np.array([[0.0, 0.0, 0.9, 0.0]])
        velocity = choose(bodies, np.array([[0.8, 0.6]]), walls=walls)
        np.testing.assert_allclose(velocity, [[0.8 * 1.3, 0.02 / 0.5]])

    def test_walls_hold_where_people_press(self):
        walls = np.array([[[0.31, -9.0], [0.31, 9.0]]])
        bodies = np.array([[0.0, 0.0, 0.0, 0.0], [-0.55, 0.05, 1.3, 0.0]])
        velocity = choose(bodies, np.array([[0.0, 1.0], [1.0, 0.0]]), walls=walls)
        assert velocity[0, 0] <= 0.01 / 0.5 + 1e-9


class TestCrowd:
    def test_neighbors_from_cells_are_the_nearest_within_the_range(self):
        bodies, direction = random_crowd(150)
        expected = []
        for i, body in enumerate(bodies):
            distance = np.linalg.norm(bodies[:, :2] - body[:2], axis=1)
            near = [j for j in np.argsort(distance) if j != i and distance[j] < 6.0][:10]
            planes = np.array([person_plane(body, bodies[j], 0.5, 0.5, 3.0, 0.05) for j in near])
            expected.append(nearest_permitted(planes, len(near), 0, *(1.3 * direction[i]), 1.7))
        np.testing.assert_allclose(choose(bodies, direction), expected, atol=1e-9)

    def test_turning_the_scene_turns_the_velocities(self):
        bodies, direction = random_crowd(40)
        walls = np.array([[[-6.0, -6.3], [7.0, -6.3]], [[2.4, -6.0], [2.4, 9.0]]])
        cos, sin = np.cos(0.7), np.sin(0.7)
        turned = np.array([[cos, sin], [-sin, cos]])
        bodies_turned = np.concatenate([bodies[:, :2] @ turned, bodies[:, 2:] @ turned], axis=1)
        velocity = choose(bodies, direction, walls=walls)
        velocity_turned = choose(bodies_turned, direction @ turned, walls=walls @ turned)
        np.testing.assert_allclose(velocity_turned, velocity @ turned, atol=1e-9)

    def test_somebody_alone_does_what_he_wants(self):
        bodies, direction = np.array([[0.0, 0.0, 0.5, 0.5]]), np.array([[0.6, -0.8]])
        np.testing.assert_allclose(choose(bodies, direction), 1.3 * direction)

    def test_who_does_not_give_way_is_avoided_alone(self):
        bodies = np.array([[0.0, 0.0, 1.3, 0.0], [3.0, 0.1, -1.3, 0.0]])
        direction = np.array([[1.0, 0.0], [-1.0, 0.0]])
        aside = choose(bodies, direction, gives_way=[True, True])[0, 1]
        further = choose(bodies, direction, gives_way=[True, False])[0, 1]
        assert further == pytest.approx(2 * aside, rel=0.05)
        assert aside < -0.05

    def test_who_is_hidden_behind_a_wall_is_not_avoided(self):
        bodies = np.array([[0.0, 0.0, 1.3, 0.0], [3.0, 0.1, -1.3, 0.0]])
        direction = np.array([[1.0, 0.0], [-1.0, 0.0]])
        walls = np.array([[[1.5, -5.0], [1.5, 5.0]]])
        velocity = choose(bodies, direction, walls=walls)
        np.testing.assert_allclose(velocity[0], [1.3, 0.0])
        assert abs(choose(bodies, direction)[0, 1]) > 0.05

    def test_who_does_not_notice_the_robot_walks_into_it(self):
        bodies = np.array([[0.0, 0.0, 1.3, 0.0], [2.0, 0.1, 0.0, 0.0]])
        direction = np.array([[1.0, 0.0], [0.0, 0.0]])
        velocity = choose(bodies, direction, noticed=False)
        np.testing.assert_allclose(velocity[0], [1.3, 0.0])
        assert abs(choose(bodies, direction)[0, 1]) > 0.05

    def test_people_change_their_velocity_no_harder_than_they_can(self):
        start = orca([[0.0, 0.0]], [[5.0, 0.0]])
        still = replace(start.pedestrians, velocity=np.array([[0.0, 0.5]]))
        running = world(replace(start, pedestrians=still), orca=Orca(max_acceleration=2.0))
        running.step()
        change = running.velocities[0] - [0.0, 0.5]
        assert np.linalg.norm(change) == pytest.approx(2.0 * 0.05)

    def test_two_who_meet_head_on_choose_the_same_side(self):
        running = world(orca([[-6.0, 0.0], [6.0, 0.0]], [[6.0, 0.0], [-6.0, 0.0]]))
        aside, gap = [], np.inf
        for _ in range(120):
            running.step()
            aside.append(running.positions[:, 1])
            gap = min(gap, np.linalg.norm(np.subtract(*running.positions)) - 0.5)
        left, right = np.array(aside)[np.abs(aside).max(axis=1).argmax()]
        assert left * right < 0
        assert min(abs(left), abs(right)) > 0.05
        assert gap > -0.005
        assert running.positions[0, 0] > 0.5

    def test_ten_on_a_circle_all_reach_the_other_side(self):
        angle = np.linspace(0, 2 * np.pi, 10, endpoint=False)
        place = 6.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        running = world(orca(place, -place, desired_speed=1.3))
        gap = np.inf
        for _ in range(320):
            running.step()
            apart = running.positions[:, None] - running.positions[None]
            gap = min(gap, np.linalg.norm(apart, axis=-1)[np.triu_indices(10, 1)].min() - 0.5)
        assert gap > -0.01
        np.testing.assert_allclose(running.positions, -place, atol=0.3)

    @pytest.mark.parametrize("seed", range(3))
    def test_nobody_waits_for_ever_in_a_door_of_one_metre(self, seed):
        walls = np.array([[[0.0, -12.0], [0.0, -0.5]], [[0.0, 0.5], [0.0, 12.0]]])
        place = np.array([(-6.0 + 1.2 * i, -3.0 + 1.5 * j) for i in range(4) for j in range(5)])
        running = world(
            orca(place, place * [-1, 1], world_map=replace(SQUARE, walls=walls)), seed=seed
        )
        run(running, 40.0)
        assert (running.positions[:, 0] > 0).all()
        assert running.held_count == 0


@pytest.mark.parametrize("broken", [{"horizon": 0.0}, {"neighbors": 0}, {"wavering": -0.1}])
def test_broken_parameters_are_refused(broken):
    with pytest.raises(ValueError, match=f"{next(iter(broken))}: expected"):
        Orca(**broken)
