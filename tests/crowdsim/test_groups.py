import math

import numpy as np
import pytest

from crowdsim.groups import abreast, add_group_forces, draw_groups, head_turn
from crowdsim.map import Map
from crowdsim.pedestrians import Pedestrians
from crowdsim.scenario import Scenario
from crowdsim.world import World


def forces(bodies, group, direction=(1.0, 0.0), present=None):
    bodies = np.array(bodies)
    present = np.ones(len(bodies), dtype=bool) if present is None else np.array(present)
    total = np.zeros((len(bodies), 2))
    ahead = np.tile(np.array(direction), (len(bodies), 1))
    add_group_forces(bodies, present, ahead, np.array(group), total)
    return total


def test_two_who_are_far_apart_are_drawn_to_their_centre():
    total = forces([[0.0, 0.0, 1.0, 0.0], [0.0, 1.2, 1.0, 0.0]], [0, 0])
    np.testing.assert_allclose(total, [[0.0, 3.0], [0.0, -3.0]])


def test_two_who_are_too_near_part():
    total = forces([[0.0, 0.0, 1.0, 0.0], [0.0, 0.6, 1.0, 0.0]], [0, 0])
    np.testing.assert_allclose(total, [[0.0, -1.0], [0.0, 1.0]])


def test_who_is_ahead_slows_down_to_see_the_other():
    total = forces([[0.0, 0.0, 1.3, 0.0], [0.6, -0.6, 1.3, 0.0]], [0, 0])
    np.testing.assert_allclose(total, [[0.0, 0.0], [-4.0 * math.pi / 4 * 1.3, 0.0]], atol=1e-12)


def test_heads_turn_only_for_what_is_out_of_view():
    assert head_turn(1.0, 1.0, 1.0, 0.0) == 0.0
    assert head_turn(-1.0, -1.0, 1.0, 0.0) == pytest.approx(math.pi / 4)


@pytest.mark.parametrize(
    ("group", "present"),
    [([-1, -1], [True, True]), ([0, 1], [True, True]), ([0, 0], [True, False])],
)
def test_people_of_no_group_feel_none(group, present):
    bodies = [[0.0, 0.0, 1.0, 0.0], [-2.0, 0.0, 1.0, 0.0]]
    np.testing.assert_array_equal(forces(bodies, group, present=present), 0.0)


def test_who_has_lost_the_group_walks_alone():
    total = forces([[0.0, 0.0, 1.0, 0.0], [-5.5, 0.0, 1.0, 0.0]], [0, 0])
    np.testing.assert_array_equal(total, 0.0)


def walkers(group):
    start = abreast(np.array([-15.0, 0.0]), 0.0, 3)
    crowd = Pedestrians.draw(
        np.random.default_rng(2),
        position=start,
        waypoints=start + np.array([60.0, 0.0]),
        desired_speed=[1.1, 1.3, 1.5],
        group=group,
    )
    bounds = (-20.0, -10.0, 20.0, 10.0)
    at = (0.0, -9.0)
    start = Scenario(
        name="walk", map=Map(bounds=bounds), pedestrians=crowd, robot_start=(*at, 0), robot_goal=at
    )
    running = World(start, rng=np.random.default_rng(1))
    widest = 0.0
    for _ in range(400):
        running.step()
        apart = running.positions[:, None] - running.positions[None]
        widest = max(widest, np.linalg.norm(apart, axis=-1).max())
    return widest, running


def test_three_walking_abreast_keep_together_and_strangers_do_not():
    together, running = walkers([0, 0, 0])
    strangers, _ = walkers([-1, -1, -1])
    assert together < 2.5
    assert strangers > 5.0
    assert running.positions[:, 0].min() > 4.0


@pytest.mark.parametrize("count", [1, 2, 3, 40])
@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_groups_hold_the_share_asked_for_and_nobody_is_a_group(count, share):
    group = draw_groups(np.random.default_rng(3), count, share)
    assert abs((group >= 0).sum() - share * count) <= 1
    sizes = np.unique(group[group >= 0], return_counts=True)[1]
    assert ((sizes >= 2) & (sizes <= 4)).all()


def test_shares_out_of_range_are_refused():
    with pytest.raises(ValueError, match=r"expected 0 to 1, found 1\.2"):
        draw_groups(np.random.default_rng(0), 4, 1.2)


def test_places_abreast_lie_across_the_heading():
    np.testing.assert_allclose(
        abreast(np.array([1.0, 2.0]), math.pi / 2, 2, 1.0), [[1.5, 2.0], [0.5, 2.0]]
    )


def test_rows_of_a_group_must_be_consecutive():
    place = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    with pytest.raises(ValueError, match="group: expected consecutive rows"):
        Pedestrians.draw(
            np.random.default_rng(0), position=place, waypoints=place + 1.0, group=[0, -1, 0]
        )
