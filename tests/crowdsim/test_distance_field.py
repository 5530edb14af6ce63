import numpy as np
import pytest

from crowdsim.distance_field import DistanceField, distance_to_segments

WALL = np.array([[[-2.0, 0.0], [2.0, 0.0]]])
BOUNDS = (-5.0, -5.0, 5.0, 5.0)


def random_walls(count):
    return np.random.default_rng(1).uniform(-5, 5, (count, 2, 2))


def test_distance_beside_a_wall_is_exact_between_grid_points():
    field = DistanceField(WALL, BOUNDS)
    y = np.array([0.137, 1.23, -2.468])
    points = np.stack([np.array([0.31, -1.7, 0.0]), y], axis=1)
    np.testing.assert_allclose(field.distance(points), np.abs(y), atol=1e-12)
    np.testing.assert_allclose(field.direction(points)[:, 1], np.sign(y), atol=1e-12)


def test_distance_beyond_the_end_of_a_wall_is_to_its_end():
    field = DistanceField(WALL, BOUNDS)
    assert field.distance([4.0, 1.5]) == pytest.approx(2.5, abs=1e-3)
    np.testing.assert_allclose(field.direction([4.0, 1.5]), [0.8, 0.6], atol=1e-3)


def test_grid_points_hold_the_exact_distance():
    walls = random_walls(40)
    field = DistanceField(walls, BOUNDS, cell=0.25)
    rows, columns, _ = field.grid.shape
    x, y = field.origin[:, None] + field.cell * np.arange(max(rows, columns))
    exact = [[distance_to_segments(x[j], y[i], walls) for j in range(columns)] for i in range(rows)]
    np.testing.assert_allclose(field.grid[..., 0], exact, atol=1e-12)


def test_interpolation_error_is_bounded_by_the_cell():
    walls = random_walls(7)
    field = DistanceField(walls, BOUNDS)
    points = np.random.default_rng(2).uniform(-5, 5, (500, 2))
    exact = np.array([distance_to_segments(x, y, walls) for x, y in points])
    error = np.abs(field.distance(points) - exact)
    assert error.max() < 0.1
    assert np.median(error) < 1e-3


def test_nothing_is_felt_off_the_grid_or_without_walls():
    assert DistanceField(WALL, BOUNDS).distance([50.0, 0.0]) == np.inf
    empty = DistanceField(np.empty((0, 2, 2)), BOUNDS)
    assert empty.distance([0.0, 0.0]) == np.inf
    np.testing.assert_array_equal(empty.direction([0.0, 0.0]), [0.0, 0.0])
