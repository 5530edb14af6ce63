"""Regions traced from masks, and maps of the real scenes."""

import cv2
import numpy as np
import pytest
import shapely

from crowdsim.canvas import project
from crowdsim.maps import classified_map, eth_ucy_map, sdd_map, walkable_map
from crowdsim.maps.raster import trace, trace_surfaces
from crowdsim.recordings import Picture, read_scene
from crowdsim.recordings.surfaces import Surface
from crowdsim.render import render_map

RNG = np.random.default_rng(0)
UPRIGHT = np.diag([10.0, -10.0, 1.0])


def painted(regions, shape):
    """Paint outlines one over the other and look at the pixels' centres."""
    classes = np.full(shape, -1)
    v, u = np.mgrid[: shape[0], : shape[1]]
    for code, outline in regions:
        classes[shapely.contains_xy(shapely.Polygon(outline), u, v)] = code
    return classes


@pytest.mark.parametrize("seed", range(5))
def test_traced_regions_paint_the_mask_again(seed):
    classes = np.random.default_rng(seed).integers(0, 3, (12, 17))
    np.testing.assert_array_equal(painted(trace(classes), classes.shape), classes)


def test_specks_go_to_their_surroundings():
    classes = np.ones((20, 20), dtype=int)
    classes[5, 5], classes[10:15, 10:15] = 2, 3
    regions = trace(classes, least_area_px=4)
    assert [code for code, _ in regions] == [1, 3]
    np.testing.assert_allclose(shapely.Polygon(regions[1][1]).area, 25)


def test_simplified_neighbors_leave_no_gap_between_them():
    v, u = np.mgrid[:60, :80]
    classes = 1 + (u > 30 + 8 * np.sin(v / 9)) + (np.hypot(u - 60, v - 30) < 12)
    regions = trace(classes, simplify_px=3.0)
    assert sum(len(outline) for _, outline in regions) < 60
    assert (painted(regions, classes.shape) >= 0).all()
    assert (painted(regions, classes.shape) == classes).mean() > 0.97


def test_background_at_the_border_is_left_out_and_in_a_hole_is_not():
    classes = np.full((9, 9), Surface.BUILDING)
    classes[2:7, 2:7] = Surface.ROAD
    classes[4, 4] = Surface.BUILDING
    surfaces = trace_surfaces(classes, np.eye(3), Surface.BUILDING)
    assert [surface for surface, _ in surfaces] == [Surface.ROAD, Surface.BUILDING]


def picture(shape):
    return Picture(RNG.integers(0, 255, (*shape, 3), dtype=np.uint8), UPRIGHT)


def test_a_mask_of_surfaces_becomes_ground_under_its_picture():
    classes = np.full((60, 80), Surface.PAVEMENT)
    classes[20:50, 10:40], classes[:, 60:] = Surface.TREE, Surface.ROAD
    world_map = classified_map(picture(classes.shape), classes)
    assert world_map.bounds == pytest.approx((-0.05, -5.95, 7.95, 0.05))
    assert [surface for surface, _ in world_map.surfaces] == [Surface.ROAD, Surface.TREE]
    assert world_map.obstacles.bounds == pytest.approx((0.95, -4.95, 3.95, -1.95))
    np.testing.assert_array_equal(render_map(world_map)[0], world_map.picture.image)


def test_masks_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match=r"expected the picture's size \(6, 8\), found \(6, 9\)"):
        classified_map(picture((6, 8)), np.ones((6, 9), dtype=int))
    with pytest.raises(ValueError, match="expected the picture's size"):
        walkable_map(picture((6, 8)), np.ones((6, 9), dtype=bool), (0.0, 0.0, 1.0, 1.0))
    with pytest.raises(ValueError, match=r"expected classes 1 to 7, found \[0, 9\]"):
        classified_map(picture((2, 2)), np.array([[0, 9], [1, 1]]))


@pytest.mark.parametrize("scene", ["biwi_eth", "crowds_zara01", "crowds_zara03", "students003"])
def test_real_people_walk_on_walkable_ground(data_root, scene):
    world_map = eth_ucy_map(data_root, scene)
    recording = read_scene(data_root, scene)
    assert world_map.walkable(recording.positions[recording.valid]).mean() > 0.95
    assert world_map.picture is not None
    assert 10 < len(world_map.segments) < 100


def test_a_scene_without_a_picture_says_so(data_root):
    with pytest.raises(ValueError, match="uni_examples: expected a scene with a picture"):
        eth_ucy_map(data_root, "uni_examples")


@pytest.mark.parametrize("video", ["hyang_4", "little_2"])
def test_drone_maps_agree_with_their_masks(data_root, video):
    world_map = sdd_map(data_root / "sdd", video)
    mask = cv2.imread(str(data_root / "sdd" / "masks" / f"{video}.png"), cv2.IMREAD_UNCHANGED)
    height, width = mask.shape
    u, v = RNG.integers(0, width, 5000), RNG.integers(0, height, 5000)
    world_from_pixel = np.linalg.inv(world_map.picture.pixel_from_world)
    walkable = world_map.walkable(project(world_from_pixel, np.column_stack([u, v])))
    expected = np.isin(mask[v, u], [code for code in Surface if code.walkable])
    assert (walkable == expected).mean() > 0.98
    x_min, y_min, x_max, y_max = world_map.bounds
    assert 30 < x_max - x_min < 100  # a campus square, in metres
    assert (x_max - x_min) / (y_max - y_min) == pytest.approx(width / height)


def test_drone_videos_without_mask_or_scale_are_named(data_root, tmp_path):
    with pytest.raises(ValueError, match="metres per pixel of video 'moon_0', found none"):
        sdd_map(data_root / "sdd", "moon_0")
    with pytest.raises(ValueError, match="metres per pixel of video 'coupa_2', found none"):
        sdd_map(data_root / "sdd", "coupa_2")
    (tmp_path / "scales.csv").write_text("video,metres_per_px_A\nx_0,0.03\n")
    with pytest.raises(FileNotFoundError, match=r"x_0\.jpg"):
        sdd_map(tmp_path, "x_0")
