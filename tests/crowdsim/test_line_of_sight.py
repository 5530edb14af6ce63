import numpy as np
import pytest
import shapely

from crowdsim.distance_field import MARGIN, DistanceField
from crowdsim.line_of_sight import is_hidden

BOUNDS = (-6.0, -6.0, 6.0, 6.0)


def field_of(walls):
    field = DistanceField(np.array(walls, dtype=float).reshape(-1, 2, 2), BOUNDS)
    return field.grid, field.origin, field.cell


@pytest.mark.parametrize("seed", range(4))
def test_hidden_is_who_stands_behind_a_wall(seed):
    rng = np.random.default_rng(seed)
    walls = rng.uniform(-6, 6, (6, 2, 2))
    field = field_of(walls)
    lines = shapely.multilinestrings(shapely.linestrings(walls))
    hidden = 0
    places = shapely.points(rng.uniform(-6, 6, (1500, 2)))
    places = shapely.get_coordinates(places[shapely.distance(places, lines) > 0.2])
    for ends in places[:1000].reshape(-1, 2, 2):  # where bodies fit
        gap = shapely.distance(shapely.linestrings(ends), lines)
        if gap == 0:
            assert is_hidden(*field, *ends.ravel())
            hidden += 1
        elif gap > 0.1:
            assert not is_hidden(*field, *ends.ravel())
    assert 50 < hidden < 450


def test_a_way_along_a_wall_is_free_as_long_as_bodies_fit():
    field = field_of([[[-5.0, 0.0], [5.0, 0.0]]])
    assert not is_hidden(*field, -4.0, 0.25, 4.0, 0.25)


def test_nobody_is_hidden_without_walls():
    assert not is_hidden(*field_of([]), -4.0, 0.0, 4.0, 0.0)


def test_walls_hide_who_left_the_map_too():
    field = field_of([[[6.0, -1.0], [6.0, 1.0]]])
    assert is_hidden(*field, 5.0, 0.0, 6.0 + 2 * MARGIN, 0.0)
    assert is_hidden(*field, 6.0 + 2 * MARGIN, 0.0, 5.0, 0.0)
