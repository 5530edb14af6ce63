import numpy as np
import pytest

from crowdsim.lidar import cast_rays

CORNERS = np.array([[-2.0, -1.0], [2.0, -1.0], [2.0, 1.0], [-2.0, 1.0]])
ROOM = np.stack([CORNERS, np.roll(CORNERS, -1, axis=0)], axis=1)


def test_ranges_in_a_room_are_those_of_plane_geometry():
    ranges = cast_rays(ROOM, [[0.5, 0.0]], [0.0], 8, 10.0)[0]
    np.testing.assert_allclose(
        ranges, [1.5, 2**0.5, 1.0, 2**0.5, 2.5, 2**0.5, 1.0, 2**0.5], atol=1e-12
    )


def test_ray_zero_points_along_the_heading_and_the_rest_follow_counter_clockwise():
    ahead, left, behind, right = cast_rays(ROOM, [[0.5, 0.2]], [np.pi / 2], 4, 10.0)[0]
    np.testing.assert_allclose([ahead, left, behind, right], [0.8, 2.5, 1.2, 1.5], atol=1e-12)


def test_a_closed_room_lets_no_ray_through_its_corners():
    headings = np.arctan2(CORNERS[:, 1], CORNERS[:, 0])
    ranges = cast_rays(ROOM, np.zeros((4, 2)), headings, 64, 10.0)
    assert ranges.max() == pytest.approx(5**0.5)
    np.testing.assert_allclose(ranges[:, 0], 5**0.5)


def test_nothing_in_range_reads_the_full_range():
    np.testing.assert_array_equal(cast_rays(ROOM, [[50.0, 0.0]], [0.0], 16, 3.0), 3.0)
    np.testing.assert_array_equal(cast_rays(ROOM[:0], [[0.0, 0.0]], [0.0], 16, 3.0), 3.0)


def test_a_wall_seen_edge_on_is_hit_at_its_end():
    wall = np.array([[[3.0, 0.0], [5.0, 0.0]]])
    ranges = cast_rays(wall, [[1.0, 0.0], [6.5, 0.0]], [0.0, np.pi], 4, 10.0)
    np.testing.assert_allclose(ranges[:, 0], [2.0, 1.5], atol=1e-9)
    np.testing.assert_array_equal(ranges[:, 1:], 10.0)


def test_fast_scan_equals_every_ray_against_every_wall():
    rng = np.random.default_rng(3)
    walls = rng.uniform(-5, 5, (12, 2, 2))
    origin, heading, rays = rng.uniform(-2, 2, 2), 0.7, 90
    angles = heading + np.arange(rays) * 2 * np.pi / rays
    ray = np.stack([np.cos(angles), np.sin(angles)], axis=-1)[:, None]  # (R, 1, 2)
    start, along = walls[:, 0] - origin, walls[:, 1] - walls[:, 0]  # (S, 2)
    cross = ray[..., 0] * along[:, 1] - ray[..., 1] * along[:, 0]
    t = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / cross
    w = (start[:, 0] * ray[..., 1] - start[:, 1] * ray[..., 0]) / cross
    plain = np.where((t >= 0) & (w >= 0) & (w <= 1), t, np.inf).min(axis=1).clip(max=6.0)
    np.testing.assert_allclose(cast_rays(walls, [origin], [heading], rays, 6.0)[0], plain)


def test_bad_arguments_are_refused():
    with pytest.raises(ValueError, match="rays >= 1"):
        cast_rays(ROOM, [[0.0, 0.0]], [0.0], 0, 3.0)


def test_people_are_targets_when_asked_for():
    people = [[3.0, 0.0, 0.3], [0.0, 4.0, 0.5]]
    scan = cast_rays(ROOM[:0], [[0.0, 0.0]], [0.0], 4, 10.0, discs=people)[0]
    np.testing.assert_allclose(scan, [2.7, 3.5, 10.0, 10.0])


def test_a_person_behind_a_wall_is_not_hit_and_one_before_it_is():
    wall = np.array([[[2.0, -1.0], [2.0, 1.0]]])
    for x, distance in ((4.0, 2.0), (1.5, 1.2)):
        scan = cast_rays(wall, [[0.0, 0.0]], [0.0], 4, 10.0, discs=[[x, 0.0, 0.3]])
        assert scan[0, 0] == pytest.approx(distance)


def test_rays_beside_the_middle_meet_the_round_side_of_a_person():
    angle = 2 * np.pi / 100
    scan = cast_rays(ROOM[:0], [[0.0, 0.0]], [0.0], 100, 10.0, discs=[[3.0, 0.0, 0.5]])[0]
    expected = 3 * np.cos(angle) - np.sqrt(0.25 - 9 * np.sin(angle) ** 2)
    np.testing.assert_allclose(scan[[0, 1, -1]], [2.5, expected, expected])
    hit = np.arcsin(0.5 / 3) // angle
    assert (scan < 10).sum() == 2 * hit + 1


def test_the_scanners_own_body_is_no_target():
    scan = cast_rays(ROOM[:0], [[0.1, 0.0]], [0.0], 8, 5.0, discs=[[0.0, 0.0, 0.3]])
    np.testing.assert_array_equal(scan, 5.0)


@pytest.mark.parametrize("discs", [[[1.0, 2.0]], [[1.0, 2.0, 0.0]], [[np.nan, 2.0, 0.3]]])
def test_malformed_people_are_refused(discs):
    with pytest.raises(ValueError, match="discs: expected"):
        cast_rays(ROOM, [[0.0, 0.0]], [0.0], 8, 3.0, discs=discs)
