"""Pictures agree with the geometry they are drawn from."""

import cv2
import numpy as np
import pytest

from crowdsim.canvas import project
from crowdsim.map import Map
from crowdsim.recordings import Picture
from crowdsim.recordings.surfaces import Surface
from crowdsim.render import render_frame, render_map, write_video
from crowdsim.scenarios import make_scenario

SQUARE = np.array([(1.0, 2.0), (3.0, 2.0), (3.0, 3.0), (1.0, 3.0)])


def is_color(pixels: np.ndarray, surface: Surface) -> np.ndarray:
    return (pixels == surface.color_rgb).all(axis=-1)


def test_world_corners_land_on_picture_corners():
    image, pixel_from_world = render_map(Map(bounds=(-2.0, -1.0, 4.0, 3.0)), 10.0)
    assert image.shape == (40, 60, 3)
    corners = project(pixel_from_world, [(-2.0, 3.0), (4.0, -1.0)])
    np.testing.assert_allclose(corners, [(-0.5, -0.5), (59.5, 39.5)], atol=1e-12)


def test_row_zero_is_plus_y():
    map_ = Map(bounds=(0.0, 0.0, 4.0, 4.0), surfaces=((Surface.GRASS, SQUARE),))
    image, _ = render_map(map_, 10.0)
    rows, columns = np.nonzero(is_color(image, Surface.GRASS))
    assert (rows.min(), rows.max()) == (10, 19)  # y from 3 down to 2
    assert (columns.min(), columns.max()) == (10, 29)  # x from 1 to 3


@pytest.mark.parametrize("layout", range(4))
def test_what_is_drawn_is_what_can_be_walked_on(layout):
    map_ = make_scenario("urban_crossing", np.random.default_rng(0), layout=layout).map
    image, pixel_from_world = render_map(map_, 10.0)
    v, u = np.mgrid[: image.shape[0], : image.shape[1]]
    centres = project(np.linalg.inv(pixel_from_world), np.stack([u, v], axis=-1))
    drawn = ~sum(is_color(image, s) for s in Surface if not s.walkable).astype(bool)
    assert (drawn == map_.walkable(centres)).mean() > 0.9995  # centres exactly on an edge


def test_walls_are_drawn():
    wall = np.array([[(0.5, 1.0), (1.5, 1.0)]])
    image, pixel_from_world = render_map(Map(bounds=(0.0, 0.0, 2.0, 2.0), walls=wall), 10.0)
    u, v = np.rint(project(pixel_from_world, (1.0, 1.0))).astype(int)
    assert not is_color(image[v, u], Surface.PAVEMENT)
    assert is_color(image[v + 4, u], Surface.PAVEMENT)


def test_a_photograph_is_its_own_map():
    picture = Picture(np.zeros((8, 9, 3), dtype=np.uint8), np.eye(3))
    image, pixel_from_world = render_map(Map(bounds=(0.0, 0.0, 1.0, 1.0), picture=picture))
    assert image is picture.image
    assert pixel_from_world is picture.pixel_from_world


def frame(map_image, pixel_from_world, **changes):
    arguments = {
        "positions": np.array([(1.0, 1.0), (3.0, 3.0)]),
        "radius": np.array([0.3, 0.3]),
        "valid": np.array([True, False]),
        "scale": 4.0,
        **changes,
    }
    return render_frame(map_image, pixel_from_world, **arguments)


def changed(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(R, 2) mean pixel (u, v) where two frames differ."""
    v, u = np.nonzero((first != second).any(axis=-1))
    return np.array([u.mean(), v.mean()])


@pytest.mark.parametrize("tilt", [0.0, 0.05])
def test_people_stand_where_the_homography_says(tilt):
    image = np.full((50, 50, 3), 120, dtype=np.uint8)
    pixel_from_world = np.array([[10.0, 1.0, 2.0], [0.0, -10.0, 45.0], [0.0, tilt, 1.0]])
    nobody = frame(image, pixel_from_world, valid=np.array([False, False]))
    somebody = frame(image, pixel_from_world)
    expected = 4.0 * (project(pixel_from_world, (1.0, 1.0)) + 0.5) - 0.5
    np.testing.assert_allclose(changed(nobody, somebody), expected, atol=1.0)
    assert image.max() == image.min() == 120  # the map itself is left as it is


def test_a_heading_of_a_quarter_turn_points_up():
    image, pixel_from_world = render_map(Map(bounds=(0.0, 0.0, 4.0, 4.0)))
    plain = frame(image, pixel_from_world)
    up = frame(image, pixel_from_world, headings=np.full(2, np.pi / 2.0))
    at = 4.0 * (project(pixel_from_world, (1.0, 1.0)) + 0.5) - 0.5
    nose = changed(plain, up)
    assert abs(nose[0] - at[0]) < 1.0
    assert nose[1] < at[1] - 10.0


def test_every_layer_leaves_its_mark():
    image, pixel_from_world = render_map(Map(bounds=(0.0, 0.0, 4.0, 4.0)))
    plain = frame(image, pixel_from_world)
    path = np.array([(1.0, 1.0), (2.0, 1.0), (3.0, 1.5)])
    for layer in (
        {"histories": [path, path]},
        {"forecasts": [path, path]},
        {"robot": (2.0, 2.0, 0.5)},
        {"robot_goal": (3.0, 3.0)},
        {"robot_history": path},
        {"text": "t = 1.0 s"},
    ):
        assert (frame(image, pixel_from_world, **layer) != plain).any(), layer
    everything = frame(image, pixel_from_world, scale=4.03)
    assert everything.shape[0] % 2 == everything.shape[1] % 2 == 0


def test_a_forecast_is_as_uncertain_as_its_radius():
    image, pixel_from_world = render_map(Map(bounds=(0.0, 0.0, 10.0, 6.0)))
    layers = {"forecasts": [np.array([(3.0, 3.0), (6.0, 3.0)])], "scale": 1.0}
    certain = frame(image, pixel_from_world, **layers)
    radii = [np.array([0.4, 1.5])]
    uncertain = frame(image, pixel_from_world, **layers, forecast_radii=radii)
    # Up from the second point: nothing else is drawn there.
    for up, marked in ((0.5, True), (1.3, True), (1.8, False), (2.5, False)):
        u, v = np.rint(project(pixel_from_world, (6.0, 3.0 + up))).astype(int)
        assert (certain[v, u] != uncertain[v, u]).any() == marked


def test_video_is_whole_and_quiet(tmp_path, capfd):
    frames = [np.full((64, 96, 3), 12 * index, dtype=np.uint8) for index in range(20)]
    write_video(tmp_path / "clip.webm", frames, fps=10)
    assert capfd.readouterr().err == ""
    capture = cv2.VideoCapture(str(tmp_path / "clip.webm"))
    decoded = []
    while (answer := capture.read())[0]:
        decoded.append(answer[1].mean())
    assert decoded == pytest.approx([12 * index for index in range(20)], abs=4)


def test_a_video_that_fails_leaves_nothing(tmp_path):
    def broken():
        yield np.zeros((64, 96, 3), dtype=np.uint8)
        raise RuntimeError("the simulation stopped")

    with pytest.raises(RuntimeError, match="the simulation stopped"):
        write_video(tmp_path / "clip.webm", broken(), fps=10)
    with pytest.raises(ValueError, match="at least one frame"):
        write_video(tmp_path / "clip.webm", [], fps=10)
    with pytest.raises(ValueError, match="even sides"):
        write_video(tmp_path / "clip.webm", [np.zeros((63, 96, 3), dtype=np.uint8)], fps=10)
    with pytest.raises(ValueError, match=r"\.webm"):
        write_video(tmp_path / "clip.mp4", [], fps=10)
    assert list(tmp_path.iterdir()) == []
