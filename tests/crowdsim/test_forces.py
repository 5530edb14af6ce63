import math

import numpy as np
import pytest

from crowdsim.distance_field import DistanceField
from crowdsim.forces import (
    SocialForce,
    accelerations,
    goal_drive,
    people_repulsion,
    repulsion,
    repulsion_ahead,
    robot_repulsion,
    sight,
    time_to_closest,
)

ISOTROPIC = SocialForce(anisotropy=1.0, anticipation=0.0)


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


def people(bodies, radius, direction, model):
    return people_repulsion(bodies, everybody(bodies), radius, direction, model.record())


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


def test_repulsion_is_minus_the_gradient_of_its_potential():
    strength, reach, gap, small = 2.5, 0.25, 0.4, 1e-6

    def potential(gap):
        return strength * reach * math.exp(-gap / reach)

    slope = (potential(gap + small) - potential(gap - small)) / (2 * small)
    assert repulsion(strength, reach, gap) == pytest.approx(-slope, rel=1e-8)


def test_those_behind_count_for_the_anisotropy_alone():
    assert sight(0.3, 1.0) == 1.0
    assert sight(0.3, -1.0) == pytest.approx(0.3)


def test_time_to_closest_of_two_who_walk_towards_each_other():
    assert time_to_closest(4.0, 0.3, -2.0, 0.0) == 2.0
    assert time_to_closest(4.0, 0.3, 2.0, 0.0) == 0.0
    assert time_to_closest(4.0, 0.3, 0.0, 0.0) == 0.0


def test_two_standing_people_by_hand():
    bodies = np.array([[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]])
    model = SocialForce(repulsion=2.0, repulsion_range=0.5, anisotropy=0.4)
    facing_right = np.array([[1.0, 0.0], [1.0, 0.0]])
    force = people(bodies, np.array([0.2, 0.3]), facing_right, model)
    strength = 2.0 * math.exp((0.5 - 1.0) / 0.5)
    np.testing.assert_allclose(force, [[-strength, 0.0], [0.4 * strength, 0.0]])


def test_people_on_collision_course_turn_aside_rather_than_brake():
    strength, nx, ny = repulsion_ahead(-3.0, 0.1, 2.0, 0.0, 0.5, 2.0, 0.5, 2.0)
    assert (nx, ny) == (0.0, 1.0)
    assert strength == pytest.approx((1 - 1.5 / 2.0) * 2.0 * math.exp((0.5 - 0.1) / 0.5))


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
    walls = np.random.default_rng(5).uniform(-6, 6, (4, 2, 2))
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])  # a quarter, so that the wall grid turns too

    def total(bodies, direction, walls):
        field = DistanceField(walls, (-8.0, -8.0, 8.0, 8.0))
        still = np.zeros((25, 2))
        speed, time = np.full(25, 1.3), np.full(25, 0.5)
        arguments = (field.grid, field.origin, field.cell, SocialForce().record())
        return accelerations(
            bodies, everybody(bodies), radius, direction, speed, time, still, 0.05, *arguments
        )

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
    force = people_repulsion(bodies, present, radius, direction, model.record())
    rest = np.delete(np.arange(10), 3)
    np.testing.assert_allclose(
        force[rest], people(bodies[rest], radius[rest], direction[rest], model), atol=1e-12
    )
    np.testing.assert_array_equal(force[3], 0.0)


def test_a_wall_pushes_straight_away_and_by_its_own_parameters():
    field = DistanceField(np.array([[[-5.0, 0.0], [5.0, 0.0]]]), (-5.0, -5.0, 5.0, 5.0))
    model = SocialForce(wall_repulsion=3.0, wall_range=0.2)
    force = accelerations(
        np.array([[0.0, 0.4, 0.0, 0.0]]),
        np.ones(1, dtype=bool),
        np.array([0.25]),
        np.zeros((1, 2)),
        np.array([1.3]),
        np.array([0.5]),
        np.zeros((1, 2)),
        0.05,
        field.grid,
        field.origin,
        field.cell,
        model.record(),
    )
    np.testing.assert_allclose(force, [[0.0, 3.0 * math.exp(-0.15 / 0.2)]], atol=1e-12)


def test_robot_repulsion_is_its_share_of_everybody_against_everybody():
    bodies, radius, direction = crowd(9)
    model = SocialForce()
    shares = robot_repulsion(bodies, everybody(bodies), radius, direction, model.record())
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
