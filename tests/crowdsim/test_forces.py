import math
from dataclasses import replace

import numpy as np
import pytest

from crowdsim.cell_list import near_pairs
from crowdsim.distance_field import DistanceField
from crowdsim.forces import (
    ELLIPTICAL,
    MOUSSAID_2009,
    SocialForce,
    accelerations,
    goal_drive,
    people_repulsion,
    robot_repulsion,
    sight,
)
from crowdsim.line_of_sight import list_walls, nearest_walls

ISOTROPIC = SocialForce(anisotropy=1.0, anticipation=0.0)
BOUNDS = (-8.0, -8.0, 8.0, 8.0)


def walls_of(*segments):
    """What the kernels take of such walls: grid, origin and cell of their field, and the list."""
    segments = np.array(segments, dtype=float).reshape(-1, 2, 2)
    field = DistanceField(segments, BOUNDS)
    reach = SocialForce().interaction_range
    return field.grid, field.origin, field.cell, list_walls(segments, reach)


NO_WALLS = walls_of()


def crowd(count, seed=0, spread=6.0):
    """Bodies (N, 4), radius (N,), direction (N, 2) of random people."""
    rng = np.random.default_rng(seed)
    bodies = np.concatenate(
        [rng.uniform(-spread, spread, (count, 2)), rng.normal(0, 1, (count, 2))], axis=1
    )
    angle = rng.uniform(-np.pi, np.pi, count)
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return bodies, rng.uniform(0.2, 0.3, count), direction


def everybody(bodies):
    return np.ones(len(bodies), dtype=bool)


def people(bodies, radius, direction, model, walls=NO_WALLS):
    all_notice = np.ones(len(bodies) - 1, dtype=bool)
    *field, screens = walls
    nearest = nearest_walls(bodies, *field)
    pairs = near_pairs(bodies, everybody(bodies), model.interaction_range)
    return people_repulsion(
        pairs, bodies, radius, direction, all_notice, nearest, screens, model.record()
    )


def plain_repulsion(bodies, radius, direction, model):
    """The module's equation for everybody against everybody, in plain numpy."""
    apart = bodies[:, None, :2] - bodies[None, :, :2]  # (N, N, 2) from j to i
    closing = bodies[:, None, 2:] - bodies[None, :, 2:]
    distance = np.linalg.norm(apart, axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        approach = -(apart * closing).sum(-1)
        wait = np.where(approach > 0, approach / (closing**2).sum(-1), 0.0)
        urgency = np.ones_like(wait)
        if model.anticipation > 0:
            urgency = np.clip(1 - wait / model.anticipation, 0, None)
            nearest = apart + wait[..., None] * closing
        else:
            nearest = apart
        miss = np.linalg.norm(nearest, axis=-1)
        gap = miss - radius[:, None] - radius[None]
        cos_phi = -(apart * direction[:, None]).sum(-1) / distance
        weight = model.anisotropy + (1 - model.anisotropy) * (1 + cos_phi) / 2
        size = model.repulsion * np.exp(-gap / model.repulsion_range) * weight * urgency
        force = size[..., None] * nearest / miss[..., None]
    near = (distance < model.interaction_range) & (urgency > 0)
    np.fill_diagonal(near, val=False)
    return np.where(near[..., None], force, 0.0).sum(axis=1)


def test_goal_drive_closes_the_gap_to_the_wanted_velocity_within_the_relaxation_time():
    assert goal_drive(1.3, -1.0, 0.2, 0.5) == pytest.approx((-1.3 - 0.2) / 0.5)


def test_those_behind_count_for_the_anisotropy_alone():
    assert sight(0.3, 1.0) == 1.0
    assert sight(0.3, -1.0) == pytest.approx(0.3)


def test_two_standing_people_by_hand():
    bodies = np.array([[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]])
    model = SocialForce(repulsion=2.0, repulsion_range=0.5, anisotropy=0.4)
    facing_right = np.array([[1.0, 0.0], [1.0, 0.0]])
    force = people(bodies, np.array([0.2, 0.3]), facing_right, model)
    strength = 2.0 * math.exp((0.5 - 1.0) / 0.5)
    np.testing.assert_allclose(force, [[-strength, 0.0], [0.4 * strength, 0.0]])


def test_force_is_minus_the_gradient_of_the_potential_of_all_others():
    bodies, radius, direction = crowd(12)
    bodies[:, 2:] = 0.0

    def potential(place):
        distance = np.linalg.norm(bodies[1:, :2] - place, axis=1)
        near = distance < ISOTROPIC.interaction_range
        gap = distance - radius[1:] - radius[0]
        reach = ISOTROPIC.repulsion_range
        return (ISOTROPIC.repulsion * reach * np.exp(-gap / reach))[near].sum()

    steps = 1e-6 * np.eye(2)
    here = bodies[0, :2]
    slope = [(potential(here + step) - potential(here - step)) / 2e-6 for step in steps]
    force = people(bodies, radius, direction, ISOTROPIC)[0]
    np.testing.assert_allclose(force, -np.array(slope), rtol=1e-5, atol=1e-8)


def test_without_anisotropy_action_equals_reaction():
    bodies, radius, direction = crowd(30)
    total = people(bodies, radius, direction, ISOTROPIC).sum(axis=0)
    np.testing.assert_allclose(total, 0.0, atol=1e-10)


@pytest.mark.parametrize("model", [SocialForce(), ISOTROPIC, SocialForce(interaction_range=1.5)])
@pytest.mark.parametrize(("count", "spread"), [(2, 1.0), (60, 6.0), (150, 30.0), (40, 0.5)])
def test_cell_list_equals_everybody_against_everybody(count, spread, model):
    bodies, radius, direction = crowd(count, seed=count, spread=spread)
    np.testing.assert_allclose(
        people(bodies, radius, direction, model),
        plain_repulsion(bodies, radius, direction, model),
        rtol=1e-9,
        atol=1e-9,
    )


def test_forces_turn_with_the_scene():
    bodies, radius, direction = crowd(25)
    walls = np.random.default_rng(6).uniform(-6, 6, (4, 2, 2))
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])  # a quarter, so that the wall grid turns too

    def total(bodies, direction, walls):
        speed, time, still = np.full(25, 1.3), np.full(25, 0.5), np.zeros((25, 2))
        crowd = bodies, everybody(bodies), radius, direction, speed, time, everybody(bodies)
        return accelerations(*crowd, still, 0.05, *walls_of(*walls), SocialForce().record())

    turned = np.concatenate([bodies[:, :2] @ turn.T, bodies[:, 2:] @ turn.T], axis=1)
    np.testing.assert_allclose(
        total(turned, direction @ turn.T, walls @ turn.T),
        total(bodies, direction, walls) @ turn.T,
        atol=1e-9,
    )


def test_absent_people_neither_feel_nor_are_felt():
    bodies, radius, direction = crowd(10)
    present = everybody(bodies)
    present[3] = False
    model = SocialForce()
    nearest = nearest_walls(bodies, *NO_WALLS[:3])
    pairs = near_pairs(bodies, present, model.interaction_range)
    arguments = pairs, bodies, radius, direction, present, nearest
    force = people_repulsion(*arguments, NO_WALLS[3], model.record())
    rest = np.delete(np.arange(10), 3)
    np.testing.assert_allclose(
        force[rest], people(bodies[rest], radius[rest], direction[rest], model), atol=1e-12
    )
    np.testing.assert_array_equal(force[3], 0.0)


def test_a_wall_pushes_straight_away_and_by_its_own_parameters():
    model = SocialForce(wall_repulsion=3.0, wall_range=0.2)
    force = accelerations(
        np.array([[0.0, 0.4, 0.0, 0.0]]),
        np.ones(1, dtype=bool),
        np.array([0.25]),
        np.zeros((1, 2)),
        np.array([1.3]),
        np.array([0.5]),
        np.ones(1, dtype=bool),
        np.zeros((1, 2)),
        0.05,
        *walls_of([[-5.0, 0.0], [5.0, 0.0]]),
        model.record(),
    )
    np.testing.assert_allclose(force, [[0.0, 3.0 * math.exp(-0.15 / 0.2)]], atol=1e-12)


def test_robot_repulsion_is_its_share_of_everybody_against_everybody():
    bodies, radius, direction = crowd(9)
    model = SocialForce()
    shares = robot_repulsion(
        bodies, everybody(bodies), radius, direction, *NO_WALLS, model.record()
    )
    with_robot = people(bodies, radius, direction, model)
    without = people(bodies[:-1], radius[:-1], direction[:-1], model)
    np.testing.assert_allclose(shares[:-1], with_robot[:-1] - without, atol=1e-12)
    np.testing.assert_allclose(shares[-1], with_robot[-1], atol=1e-12)


@pytest.mark.parametrize(
    "change", [{"repulsion": np.nan}, {"wall_range": 0.0}, {"anisotropy": 1.5}, {"whim": -1.0}]
)
def test_parameters_out_of_range_are_refused(change):
    with pytest.raises(ValueError, match=f"{next(iter(change))}.*: expected"):
        SocialForce(**change)


class TestAwareness:
    bodies = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 1.0, 1.0, 0.0], [1.0, 0.4, 0.0, 0.0]])
    radius = np.array([0.2, 0.3, 0.4])
    direction = np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 0.0]])

    def forces(self, *notices):
        pairs = near_pairs(self.bodies, everybody(self.bodies), 4.0)
        crowd = pairs, self.bodies, self.radius, self.direction
        nearest = nearest_walls(self.bodies, *NO_WALLS[:3])
        arguments = np.array(notices), nearest, NO_WALLS[3], SocialForce().record()
        return people_repulsion(*crowd, *arguments)

    def test_who_does_not_notice_the_robot_feels_only_people(self):
        without = people(self.bodies[:2], self.radius[:2], self.direction[:2], SocialForce())
        one, both = self.forces(True, False), self.forces(True, True)
        np.testing.assert_allclose(one[0], both[0])
        np.testing.assert_allclose(one[1], without[1])
        assert np.abs(both[:2] - without).max(axis=1).min() > 0.1

    def test_people_are_aware_of_each_other_all_the_same(self):
        without = people(self.bodies[:2], self.radius[:2], self.direction[:2], SocialForce())
        np.testing.assert_allclose(self.forces(False, False)[:2], without)


class TestWallsBetween:
    bodies = np.array([[0.0, -0.5, 0.0, 0.0], [0.3, 0.5, 0.0, 0.0]])
    radius = np.array([0.25, 0.25])
    direction = np.zeros((2, 2))

    def test_people_behind_a_wall_are_not_felt(self):
        walls = walls_of([[-2.0, 0.0], [2.0, 0.0]])
        arguments = self.bodies, self.radius, self.direction, SocialForce()
        np.testing.assert_allclose(people(*arguments, walls), 0.0, atol=1e-15)
        assert np.abs(people(*arguments)).max(axis=1).min() > 0.1

    def test_people_on_one_side_of_it_feel_each_other(self):
        walls = walls_of([[-2.0, -1.0], [2.0, -1.0]])
        arguments = self.bodies, self.radius, self.direction, SocialForce()
        np.testing.assert_array_equal(people(*arguments, walls), people(*arguments))

    def test_the_robot_is_not_felt_through_it_either(self):
        present = everybody(self.bodies)
        arguments = self.bodies, present, self.radius, self.direction
        model = SocialForce().record()
        hidden = robot_repulsion(*arguments, *walls_of([[-2.0, 0.0], [2.0, 0.0]]), model)
        np.testing.assert_allclose(hidden, 0.0, atol=1e-15)


@pytest.mark.parametrize("model", [ELLIPTICAL, MOUSSAID_2009])
def test_other_laws_turn_with_the_scene_and_are_opposite_for_the_two(model):
    bodies, radius, direction = crowd(30)
    model = replace(model, anisotropy=1.0, repulsion=3.0)
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    turned = np.concatenate([bodies[:, :2] @ turn.T, bodies[:, 2:] @ turn.T], axis=1)
    force = people(bodies, radius, direction, model)
    assert np.abs(force).max() > 0.5
    np.testing.assert_allclose(people(turned, radius, direction, model), force @ turn.T, atol=1e-9)
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-9)


def test_unknown_interactions_are_refused():
    with pytest.raises(ValueError, match="interaction: expected one of circular, elliptical, mou"):
        SocialForce(interaction="square")
