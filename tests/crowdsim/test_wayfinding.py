import numpy as np
import pytest

from crowdsim.distance_field import distance_field
from crowdsim.map import Map
from crowdsim.recordings.surfaces import Surface
from crowdsim.wayfinding import geodesic_field

OPEN = Map(bounds=(-8.0, -8.0, 8.0, 8.0))
BLOCK = Map(
    bounds=(-8.0, -8.0, 8.0, 8.0),
    surfaces=((Surface.BUILDING, np.array([[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]])),),
)
SPLIT = Map(bounds=(-8.0, -8.0, 8.0, 8.0), walls=np.array([[[0.0, -8.0], [0.0, 8.0]]]))
DOOR = Map(
    bounds=(-8.0, -8.0, 8.0, 8.0),
    walls=np.array([[[0.0, -8.0], [0.0, -0.5]], [[0.0, 0.5], [0.0, 8.0]]]),
)


def test_open_ground_is_crossed_straight():
    field = geodesic_field(OPEN, (3.0, 4.0))
    assert field.length((0.0, 0.0)) == 5.0
    np.testing.assert_allclose(field.direction([[0.0, 0.0], [3.0, 4.0]]), [[0.6, 0.8], [0.0, 0.0]])
    np.testing.assert_allclose(field.path((0.0, 0.0), 2.5), [[0, 0], [1.5, 2.0], [3.0, 4.0]])


def test_walk_around_a_block_has_the_length_of_a_string_around_it():
    field = geodesic_field(BLOCK, (5.0, 0.5), clearance=0.3)
    string = np.hypot(3.0, 2.3 - 0.5) + 4.0 + np.hypot(3.0, 2.3)
    assert field.length((-5.0, 0.0)) == pytest.approx(string, rel=0.02)


def test_walk_keeps_its_distance_from_the_walls():
    path = geodesic_field(BLOCK, (5.0, 0.5), clearance=0.3).path((-5.0, 0.0), 0.05)
    assert distance_field(BLOCK).distance(path).min() > 0.25
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() <= 0.05 + 1e-9


def test_path_and_length_agree():
    field = geodesic_field(BLOCK, (5.0, 0.5))
    steps = np.diff(field.path((-4.0, 1.0), 0.2), axis=0)
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(field.length((-4.0, 1.0)))


def test_directions_are_free_of_grid_angles_where_the_goal_is_in_sight():
    field = geodesic_field(BLOCK, (6.0, 7.0))
    points = np.array([[-7.0, 5.0], [3.0, -6.0], [-3.3, 3.1]])
    ahead = np.array([6.0, 7.0]) - points
    expected = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    np.testing.assert_allclose(field.direction(points), expected)


def test_following_the_direction_leads_through_the_door_to_the_goal():
    field = geodesic_field(DOOR, (5.0, 5.0))
    point, walked = np.array([-5.0, 6.0]), 0.0
    expected = field.length(point)
    while np.linalg.norm(point - field.goal) > 0.1:
        point = point + 0.05 * field.direction(point)
        walked += 0.05
    assert walked == pytest.approx(expected, rel=0.03)


def test_distance_is_walked_off_one_for_one():
    field = geodesic_field(DOOR, (5.0, 5.0))
    before = np.array([-5.0, 6.0])
    after = before + field.direction(before)
    assert field.distance(before) - field.distance(after) == pytest.approx(1.0, abs=0.05)


def test_point_ahead_lies_on_the_path_and_stops_at_the_goal():
    field = geodesic_field(DOOR, (5.0, 5.0))
    ahead = field.point_ahead((-5.0, 6.0), 2.0)
    np.testing.assert_allclose(ahead, [-5.0, 6.0] + 2.0 * field.direction([-5.0, 6.0]))
    np.testing.assert_array_equal(field.point_ahead((4.5, 5.0), 2.0), [5.0, 5.0])


def test_no_way_through_a_closed_wall():
    field = geodesic_field(SPLIT, (5.0, 0.0))
    assert field.length((-5.0, 0.0)) == np.inf
    assert field.length((2.0, 0.0)) == pytest.approx(3.0)
    np.testing.assert_allclose(field.direction((-5.0, 0.0)), [1.0, 0.0])


def test_goal_too_near_a_wall_is_still_reached():
    field = geodesic_field(BLOCK, (2.1, 0.0))
    path = field.path((-5.0, 0.0), 0.1)
    np.testing.assert_array_equal(path[-1], [2.1, 0.0])
    assert BLOCK.walkable(path).all()


def test_the_same_map_and_goal_share_one_field():
    assert geodesic_field(BLOCK, (5.0, 0.5)) is geodesic_field(BLOCK, np.array([5.0, 0.5]))


def test_goal_must_be_finite():
    with pytest.raises(ValueError, match="goal: expected finite"):
        geodesic_field(BLOCK, (np.nan, 0.0))
