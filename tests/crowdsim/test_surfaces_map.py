import numpy as np
import pytest

from crowdsim.map import Map
from crowdsim.recordings.surfaces import Surface

SQUARE = np.array([[2.0, 2.0], [6.0, 2.0], [6.0, 6.0], [2.0, 6.0]])
COURT = np.array([[3.0, 3.0], [5.0, 3.0], [5.0, 5.0], [3.0, 5.0]])


def length(segments):
    return np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1).sum()


def test_mask_classes_of_the_stanford_drone_data_set_keep_their_numbers():
    assert [Surface(code).name for code in range(1, 6)] == [
        "PAVEMENT",
        "ROAD",
        "BUILDING",
        "GRASS",
        "TREE",
    ]


def test_colors_tell_surfaces_apart():
    assert len({surface.color_rgb for surface in Surface}) == len(Surface)


def test_water_stops_walking_but_not_looking():
    assert not Surface.WATER.walkable
    assert Surface.WATER.see_through


def test_a_building_is_not_walkable_and_its_outline_is_what_bodies_meet():
    world_map = Map(bounds=(0, 0, 10, 10), surfaces=((Surface.BUILDING, SQUARE),))
    assert world_map.walkable([[4.0, 4.0], [1.0, 1.0]]).tolist() == [False, True]
    assert length(world_map.segments) == pytest.approx(16.0)


def test_later_surfaces_lie_on_top():
    surfaces = ((Surface.BUILDING, SQUARE), (Surface.PAVEMENT, COURT))
    assert Map(bounds=(0, 0, 10, 10), surfaces=surfaces).walkable([4.0, 4.0])
    assert not Map(bounds=(0, 0, 10, 10), surfaces=surfaces[::-1]).walkable([4.0, 4.0])


def test_walkable_ground_adds_no_segments():
    world_map = Map(bounds=(0, 0, 10, 10), surfaces=((Surface.ROAD, SQUARE),))
    assert world_map.segments.shape == (0, 2, 2)


def test_overlapping_buildings_have_one_outline():
    shifted = SQUARE + np.array([2.0, 0.0])
    surfaces = ((Surface.BUILDING, SQUARE), (Surface.BUILDING, shifted))
    assert length(Map(bounds=(0, 0, 10, 10), surfaces=surfaces).segments) == pytest.approx(20.0)


def test_solid_background_leaves_only_what_is_cut_out():
    world_map = Map(
        bounds=(0, 0, 10, 10),
        background=Surface.BUILDING,
        surfaces=((Surface.PAVEMENT, SQUARE),),
    )
    inside, wall, far_outside = world_map.walkable([[4.0, 4.0], [1.0, 1.0], [50.0, 50.0]])
    assert (inside, wall, far_outside) == (True, False, False)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"bounds": (0, 0, -1, 1)}, "bounds"),
        ({"walls": np.zeros((3, 2))}, r"walls: expected shape \(S, 2, 2\)"),
        ({"walls": np.full((1, 2, 2), np.nan)}, "walls: expected finite"),
        ({"surfaces": ((Surface.GRASS, SQUARE[[0, 2, 1, 3]]),)}, "crosses itself"),
        ({"surfaces": ((Surface.GRASS, SQUARE[:2]),)}, "at least 3 corners"),
    ],
)
def test_malformed_geometry_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        Map(**{"bounds": (0, 0, 10, 10), **change})
