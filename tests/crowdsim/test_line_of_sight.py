import numpy as np
import pytest
import shapely

from crowdsim.line_of_sight import is_hidden, list_walls

REACH = 4.0


@pytest.mark.parametrize("seed", range(4))
def test_hidden_is_who_stands_behind_a_wall(seed):
    rng = np.random.default_rng(seed)
    walls = rng.uniform(-6, 6, (6, 2, 2))
    screens = list_walls(walls, REACH)
    start = rng.uniform(-8, 8, (1000, 2))
    angle, length = rng.uniform(0, 2 * np.pi, 1000), rng.uniform(0, REACH, 1000)
    end = start + length[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ways = shapely.linestrings(np.stack([start, end], axis=1))
    crossing = shapely.intersects(ways, shapely.multilinestrings(shapely.linestrings(walls)))
    hidden = [is_hidden(screens, *a, *b) for a, b in zip(start, end, strict=True)]
    np.testing.assert_array_equal(hidden, crossing)
    assert 50 < crossing.sum() < 500


def test_a_way_along_a_wall_is_free():
    screens = list_walls(np.array([[[-5.0, 0.0], [5.0, 0.0]]]), REACH)
    assert not is_hidden(screens, -2.0, 0.01, 2.0, 0.01)
    assert is_hidden(screens, -2.0, 0.01, 2.0, -0.01)


def test_nobody_is_hidden_without_walls():
    assert not is_hidden(list_walls(np.empty((0, 2, 2)), REACH), -2.0, 0.0, 2.0, 0.0)
