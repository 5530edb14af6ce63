"""GeoJSON, WKT and ROS map files: what was written is what is walked on, and errors say where."""

import json
import math

import cv2
import numpy as np
import pytest
import shapely

from crowdsim.distance_field import DistanceField
from crowdsim.lidar import cast_rays
from crowdsim.map import Map
from crowdsim.maps import (
    make_place,
    read_geojson,
    read_map,
    read_map_server,
    read_wkt,
    write_geojson,
)
from crowdsim.recordings.surfaces import Surface
from crowdsim.render import render_map

HOUSE = np.array([[2.0, 2.0], [6.0, 2.0], [6.0, 6.0], [2.0, 6.0]])
LAWN = np.array([[3.0, 3.0], [9.0, 3.0], [9.0, 5.0], [3.0, 5.0]])
COURT = """
# a house around a court, and a fence
background pavement
bounds -1 -1 11 9
building POLYGON ((2 2, 8 2, 8 6, 2 6, 2 2), (4 3, 6 3, 6 5, 4 5, 4 3))
wall LINESTRING (0 7, 9 7, 9 8)
"""


def length(segments):
    return np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1).sum()


def collection(*features, **members):
    return {"type": "FeatureCollection", "features": list(features), **members}


def feature(kind, coordinates, **properties):
    geometry = {"type": kind, "coordinates": coordinates}
    return {"type": "Feature", "properties": properties, "geometry": geometry}


def save(path, content):
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


def test_geojson_round_trip_keeps_every_polygon_and_wall(tmp_path):
    world_map = Map(
        bounds=(-1.5, 0.0, 10.0, 8.25),
        surfaces=((Surface.BUILDING, HOUSE), (Surface.GRASS, LAWN)),
        walls=np.array([[[0.1, 0.2], [0.3, 7.0]]]),
        background=Surface.ROAD,
    )
    write_geojson(tmp_path / "map.geojson", world_map)
    read = read_map(tmp_path / "map.geojson")
    assert (read.bounds, read.background) == (world_map.bounds, world_map.background)
    assert [surface for surface, _ in read.surfaces] == [Surface.BUILDING, Surface.GRASS]
    for (_, first), (_, second) in zip(read.surfaces, world_map.surfaces, strict=True):
        np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(read.walls, world_map.walls)


@pytest.mark.parametrize("kind", ["square", "station"])
def test_generated_places_survive_the_file(tmp_path, kind):
    place = make_place(kind, 1)
    write_geojson(tmp_path / "map.geojson", place.map)
    read = read_geojson(tmp_path / "map.geojson")
    np.testing.assert_array_equal(read.segments, place.map.segments)
    np.testing.assert_array_equal(render_map(read)[0], render_map(place.map)[0])


def test_one_geometry_gives_physics_distance_lidar_and_picture(tmp_path):
    world_map = read_wkt(save(tmp_path / "map.wkt", COURT))
    assert world_map.walkable([[5.0, 4.0], [3.0, 4.0], [1.0, 4.0]]).tolist() == [True, False, True]
    field = DistanceField(world_map.segments, world_map.bounds)
    assert field.distance([1.0, 4.0]) == pytest.approx(1.0)
    scan = cast_rays(world_map.segments, [[5.0, 4.0]], [0.0], 4, 10.0)[0]
    np.testing.assert_allclose(scan, 1.0)  # to all sides of the court
    image, pixel_from_world = render_map(world_map)
    for point, surface in (((3.0, 4.0), Surface.BUILDING), ((5.0, 4.0), Surface.PAVEMENT)):
        u, v = np.rint(pixel_from_world @ [*point, 1.0]).astype(int)[:2]
        assert tuple(image[v, u]) == surface.color_rgb


def test_holes_are_cut_without_a_trace(tmp_path):
    world_map = read_wkt(save(tmp_path / "map.wkt", COURT))
    assert world_map.obstacles.area == pytest.approx(6 * 4 - 2 * 2)
    assert length(world_map.segments) == pytest.approx(20 + 8 + 9 + 1)
    assert world_map.bounds == (-1.0, -1.0, 11.0, 9.0)


def test_geojson_takes_multi_geometries_holes_and_no_bounds(tmp_path):
    ring, hole = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]], [[1, 1], [2, 1], [2, 2], [1, 2], [1, 1]]
    far = [[[6, 0], [8, 0], [8, 2], [6, 0]]]
    path = save(
        tmp_path / "map.json",
        collection(
            feature("MultiPolygon", [[ring, hole], far], surface="water"),
            feature("MultiLineString", [[[0, 5], [1, 5]], [[2, 5], [3, 5], [3, 6]]]),
        ),
    )
    world_map = read_map(path)
    assert world_map.obstacles.area == pytest.approx(16 - 1 + 2)
    assert len(world_map.walls) == 3
    assert world_map.bounds == (0.0, 0.0, 8.0, 6.0)
    assert len(world_map.occluders) == 3  # water hides nothing


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("{", "expected JSON"),
        ({"type": "Feature"}, "expected an object of type FeatureCollection"),
        (
            collection(feature("Polygon", [[[0, 0], [1, 0], [1, 1], [0, 0]]])),
            r"features\[0\].*None",
        ),
        (
            collection(feature("Polygon", [[[0, 0], [1, 0], [1, 1], [0, 0]]], surface="lava")),
            r"features\[0\]: surface: expected one of pavement.*found 'lava'",
        ),
        (
            collection(
                feature("LineString", [[0, 0], [1, 1]]),
                feature("Polygon", [[[0, 0], [1, 1], [1, 0], [0, 1], [0, 0]]], surface="road"),
            ),
            r"features\[1\]: expected a simple polygon, found Self-intersection",
        ),
        (
            collection(feature("Point", [0, 0], surface="road")),
            r"features\[0\]: road: expected Pol",
        ),
        (
            collection(feature("Polygon", [[[0, 0]]], surface="road")),
            r"features\[0\]: expected a G",
        ),
        (collection(feature("LineString", [])), r"features\[0\]"),
        (collection({"type": "Feature", "geometry": None}), r"features\[0\]"),
        (collection(), "expected bounds or at least one geometry"),
        (collection(bbox=[0, 1]), "bounds: expected four numbers"),
        (collection(bbox=[0, 0, 1, 1], background="sky"), "background: expected one of"),
    ],
)
def test_geojson_errors_name_the_feature(tmp_path, content, message):
    with pytest.raises(ValueError, match=message):
        read_geojson(save(tmp_path / "map.geojson", content))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("\nlava POLYGON ((0 0, 1 0, 1 1, 0 0))", "line 2: surface: expected one of"),
        ("road POLYGON ((0 0, 1 0", "line 1: expected a WKT geometry"),
        ("road LINESTRING (0 0, 1 0)", "line 1: road: expected Polygon"),
        ("wall POLYGON ((0 0, 1 0, 1 1, 0 0))", "line 1: wall: expected LineString"),
        ("wall LINESTRING (0 0, 1 nan)", "line 1: expected finite coordinates"),
        ("bounds 0 0 1", "bounds: expected four numbers"),
    ],
)
def test_wkt_errors_name_the_line(tmp_path, content, message):
    with pytest.raises(ValueError, match=message):
        read_wkt(save(tmp_path / "map.wkt", content))


def test_other_endings_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"\.geojson, \.json, \.wkt"):
        read_map(tmp_path / "map.dxf")


# A grid of 6 x 4 cells: a border of walls, a post, one unknown cell.
CELLS = np.full((4, 6), 254, dtype=np.uint8)
CELLS[[0, -1]] = 0
CELLS[:, [0, -1]] = 0
CELLS[1, 2] = 0  # second row from above
CELLS[2, 4] = 205
FIELDS = "image: cells.pgm\nresolution: 0.5\noccupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 0\n"


def save_grid(folder, cells=CELLS, fields=FIELDS, origin="[0.0, 0.0, 0.0]"):
    cv2.imwrite(str(folder / "cells.pgm"), cells)
    return save(folder / "map.yaml", f"{fields}origin: {origin}\n")


def test_cells_of_a_ros_map_lie_where_ros_puts_them(tmp_path):
    world_map = read_map(save_grid(tmp_path, origin="[10.0, 20.0, 0.0]"))
    assert world_map.bounds == pytest.approx((10.0, 20.0, 13.0, 22.0))
    row, column = np.mgrid[:4, :6]
    centres = np.stack([10.25 + 0.5 * column, 20.25 + 0.5 * (3 - row)], axis=-1)
    np.testing.assert_array_equal(world_map.walkable(centres), CELLS == 254)
    assert not world_map.walkable([9.0, 21.0])
    assert world_map.obstacles.area == pytest.approx(0.25 * (CELLS != 254).sum())


def test_a_wall_of_one_cell_is_one_cell_thick(tmp_path):
    cells = np.full((5, 9), 254, dtype=np.uint8)
    cells[:, 4] = 0
    world_map = read_map_server(save_grid(tmp_path, cells))
    scan = cast_rays(world_map.segments, [[1.0, 1.25], [3.5, 1.25]], [0.0, math.pi], 1, 9.0)
    np.testing.assert_allclose(scan, [[1.0], [1.0]])


def test_the_yaw_of_a_ros_map_turns_it_about_its_corner(tmp_path):
    plain = read_map_server(save_grid(tmp_path, origin="[1.0, 2.0, 0.0]"))
    turned = read_map_server(save_grid(tmp_path, origin="[1.0, 2.0, 0.6]"))
    points = np.random.default_rng(0).uniform([1.0, 2.0], [4.0, 4.0], (200, 2))
    turn = np.array([[math.cos(0.6), -math.sin(0.6)], [math.sin(0.6), math.cos(0.6)]])
    moved = (points - [1.0, 2.0]) @ turn.T + [1.0, 2.0]
    np.testing.assert_array_equal(turned.walkable(moved), plain.walkable(points))
    assert 0 < plain.walkable(points).sum() < 200


def test_unknown_cells_stop_people_unless_told_otherwise(tmp_path):
    path, unknown = save_grid(tmp_path), [2.25, 0.75]
    assert not read_map_server(path).walkable(unknown)
    assert read_map_server(path, unknown_is_free=True).walkable(unknown)


def test_negated_and_colored_pictures_mean_the_same(tmp_path):
    expected = read_map_server(save_grid(tmp_path)).segments
    negated = save_grid(tmp_path, 255 - CELLS, FIELDS.replace("negate: 0", "negate: 1"))
    np.testing.assert_array_equal(read_map_server(negated).segments, expected)
    cv2.imwrite(str(tmp_path / "cells.png"), np.repeat(CELLS[..., None], 3, axis=-1))
    colored = save(tmp_path / "c.yaml", FIELDS.replace("pgm", "png") + "origin: [0, 0, 0]\n")
    np.testing.assert_array_equal(read_map_server(colored).segments, expected)


def test_stairs_of_a_slanted_wall_can_be_made_straight(tmp_path):
    cells = np.where(np.add.outer(np.arange(60), np.arange(60)) < 60, 0, 254).astype(np.uint8)
    path = save_grid(tmp_path, cells)
    exact, simple = read_map_server(path), read_map_server(path, simplify_px=1.0)
    assert len(simple.segments) < 10 < len(exact.segments)
    difference = shapely.symmetric_difference(simple.obstacles, exact.obstacles)
    assert difference.area < 0.02 * exact.obstacles.area


@pytest.mark.parametrize(
    ("fields", "origin", "message"),
    [
        (FIELDS + "mode: scale\n", "[0, 0, 0]", "mode: expected 'trinary', found 'scale'"),
        (FIELDS.replace("0.5", "-1"), "[0, 0, 0]", "resolution: expected > 0"),
        (FIELDS.replace("0.5", "x"), "[0, 0, 0]", "resolution: expected a finite number"),
        (FIELDS, "[0, 0]", r"origin: expected \[x, y, yaw\]"),
        (FIELDS, "[0, 0, .nan]", "origin: expected finite"),
        (FIELDS.replace("0.196", "0.9"), "[0, 0, 0]", "free_thresh <= occupied_thresh"),
        (FIELDS.replace("image: cells.pgm", ""), "[0, 0, 0]", "'image' among them"),
        ("image: [\n", "[0, 0, 0]", "expected YAML"),
    ],
)
def test_ros_descriptions_are_checked(tmp_path, fields, origin, message):
    with pytest.raises(ValueError, match=message):
        read_map_server(save_grid(tmp_path, fields=fields, origin=origin))


def test_missing_and_damaged_grids_are_named(tmp_path):
    path = save_grid(tmp_path)
    picture = tmp_path / "cells.pgm"
    picture.write_bytes(picture.read_bytes()[:-5])
    with pytest.raises(ValueError, match=r"cells\.pgm: expected a whole picture"):
        read_map_server(path)
    picture.unlink()
    with pytest.raises(FileNotFoundError, match=r"cells\.pgm"):
        read_map_server(path)
