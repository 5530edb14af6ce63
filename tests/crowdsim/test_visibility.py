"""Sight by hand: range, field of view, walls, bodies."""

import math

import numpy as np
import pytest

from crowdsim.lidar import cast_rays
from crowdsim.map import Map
from crowdsim.recordings.surfaces import Surface
from crowdsim.visibility import visible

NOTHING = np.empty((0, 2, 2))
WALL = np.array([[[2.0, -1.0], [2.0, 1.0]]])
POND = np.array([[2.0, -1.0], [3.0, -1.0], [3.0, 1.0], [2.0, 1.0]])


def sees(points, *, occluders=NOTHING, heading=0.0, **options):
    options = {"max_range": 10.0, **options}
    return visible(occluders, [[0.0, 0.0]], [heading], points, **options)[0].tolist()


def test_range_ends_where_it_says():
    assert sees([[10.0, 0.0], [10.001, 0.0], [6.0, 8.0]]) == [True, False, True]


def test_field_of_view_is_the_full_angle_around_the_heading():
    ahead, left, behind = [1.0, 0.1], [0.1, 1.0], [-1.0, 0.0]
    half_turn = math.radians(90)
    assert sees([ahead, left, behind], field_of_view=half_turn) == [True, False, False]
    turned = sees([ahead, left, behind], field_of_view=half_turn, heading=math.radians(90))
    assert turned == [False, True, False]
    assert sees([ahead, left, behind]) == [True, True, True]


def test_field_of_view_reaches_over_the_half_turn():
    assert sees([[-1.0, 0.1], [-1.0, -0.1]], heading=math.pi, field_of_view=0.5) == [True, True]
    assert sees([[-1.0, 0.1], [-1.0, -0.1]], heading=-math.pi, field_of_view=0.5) == [True, True]


def test_a_wall_hides_what_is_behind_it_and_nothing_else():
    behind, beside, before, edge = [4.0, 0.0], [4.0, 2.5], [1.9, 0.0], [4.0, 2.0]
    assert sees([behind, beside, before, edge], occluders=WALL) == [False, True, True, False]


def test_water_hides_nothing_but_a_building_does():
    for surface, seen in ((Surface.WATER, True), (Surface.BUILDING, False), (Surface.TREE, False)):
        world_map = Map(bounds=(-1, -5, 9, 5), surfaces=((surface, POND),))
        assert len(world_map.segments) == 4
        assert sees([[4.0, 0.0]], occluders=world_map.occluders) == [seen]


def test_water_on_a_roof_opens_no_view_through_the_rest_of_the_house():
    house = np.array([[1.0, -2.0], [4.0, -2.0], [4.0, 2.0], [1.0, 2.0]])
    world_map = Map(
        bounds=(-1, -5, 9, 5), surfaces=((Surface.BUILDING, house), (Surface.WATER, POND))
    )
    assert sees([[6.0, 0.0]], occluders=world_map.occluders) == [False]


def test_a_body_hides_the_middle_of_the_one_behind_only():
    points, radius = [[2.0, 0.2], [4.0, 0.0], [4.0, 2.0]], [0.3, 0.3, 0.3]
    assert sees(points, radius=radius) == [True, False, True]
    assert sees(points) == [True, True, True]


def test_nobody_hides_the_view_of_somebody_inside():
    """An observer's own body, which is among the points, hides nobody."""
    assert sees([[0.0, 0.0], [3.0, 0.0]], radius=[0.3, 0.3]) == [True, True]


def test_sight_is_mutual_without_field_of_view():
    rng = np.random.default_rng(5)
    walls, people = rng.uniform(-5, 5, (8, 2, 2)), rng.uniform(-5, 5, (30, 2))
    seen = visible(walls, people, np.zeros(30), people, max_range=7.0)
    assert (seen == seen.T).all()
    assert 0.1 < seen.mean() < 0.9


def test_sight_agrees_with_the_range_scanner():
    """A point is behind a wall exactly where a ray towards it is stopped before it."""
    rng = np.random.default_rng(6)
    walls, points = rng.uniform(-5, 5, (10, 2, 2)), rng.uniform(-5, 5, (200, 2))
    seen = visible(walls, [[0.0, 0.0]], [0.0], points, max_range=20.0)[0]
    headings = np.arctan2(points[:, 1], points[:, 0])
    ranges = cast_rays(walls, np.zeros((200, 2)), headings, 1, 20.0)[:, 0]
    np.testing.assert_array_equal(seen, ranges > np.linalg.norm(points, axis=1))
    assert 20 < seen.sum() < 180


def test_turning_the_world_changes_nothing():
    rng = np.random.default_rng(7)
    walls, points = rng.uniform(-5, 5, (6, 2, 2)), rng.uniform(-5, 5, (50, 2))
    angle, options = 1.1, {"max_range": 6.0, "field_of_view": 2.0, "radius": np.full(50, 0.25)}
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    seen = visible(walls, points[:4], np.zeros(4), points, **options)
    turned = visible(walls @ turn, points[:4] @ turn, np.full(4, angle), points @ turn, **options)
    np.testing.assert_array_equal(seen, turned)


def test_bad_arguments_are_refused():
    with pytest.raises(ValueError, match="max_range > 0"):
        sees([[1.0, 0.0]], max_range=0.0)
    with pytest.raises(ValueError, match="field_of_view"):
        sees([[1.0, 0.0]], field_of_view=7.0)
    with pytest.raises(ValueError, match=r"radius \(N,\)"):
        sees([[1.0, 0.0]], radius=[0.3, 0.3])
