import numpy as np
from numpy.testing import assert_array_equal

from envs.tracker import Tracker, nearest

ALL = slice(None)
IDS = np.array([[7, 8]])


def tracker(**keywords):
    return Tracker(1, 2, **({"history_steps": 3, "steps_per_frame": 2} | keywords))


def at(x, worlds=1):
    """Both columns at x and 10 + x."""
    return np.broadcast_to(np.array([[x, 0.0], [10.0 + x, 0.0]]), (worlds, 2, 2))


def seen(*flags):
    return np.array([flags])


def run(tracks, steps, **keywords):
    """Columns at x = 0, 1, 2, ... on the policy clock."""
    tracks.restart(np.array([0]), at(0.0), seen(True, True), IDS)
    for step in range(1, steps + 1):
        tracks.update(at(float(step)), seen(True, True), keywords.get("ids", IDS))
    return tracks.history(ALL)


def test_frames_are_a_frame_apart_and_end_now():
    position, valid = run(tracker(), 6)
    assert valid.all()
    assert_array_equal(position[0, :, 0, 0], (2.0, 4.0, 6.0))
    position, _ = run(tracker(), 7)
    assert_array_equal(position[0, :, 0, 0], (3.0, 5.0, 7.0))


def test_history_fills_after_a_reset():
    assert_array_equal(run(tracker(), 0)[1][0, :, 0], (False, False, True))
    assert_array_equal(run(tracker(), 1)[1][0, :, 0], (False, False, True))
    assert_array_equal(run(tracker(), 2)[1][0, :, 0], (False, True, True))


def test_a_new_id_starts_anew_and_spares_the_others():
    tracks = tracker()
    run(tracks, 6)
    tracks.update(at(7.0), seen(True, True), np.array([[99, 8]]))
    position, valid = tracks.history(ALL)
    assert_array_equal(valid[0, :, 0], (False, False, True))
    assert_array_equal(position[0, :2, 0], 0.0)
    assert valid[0, :, 1].all()


def test_who_is_out_of_sight_leaves_a_gap_of_zeros():
    tracks = tracker()
    tracks.restart(np.array([0]), at(1.0), seen(True, True), IDS)
    for step in range(2, 6):
        tracks.update(at(float(step)), seen(step != 3, True), IDS)
    position, valid = tracks.history(ALL)
    assert_array_equal(valid[0, :, 0], (True, False, True))
    assert_array_equal(position[0, :, 0, 0], (1.0, 0.0, 5.0))


def test_a_restart_clears_its_world_only():
    tracks = Tracker(2, 2, history_steps=3, steps_per_frame=1)
    ids = np.array([[1, 2], [3, 4]])
    both = np.ones((2, 2), dtype=bool)
    tracks.restart(np.array([0, 1]), at(0.0, 2), both, ids)
    for step in range(1, 4):
        tracks.update(at(float(step), 2), both, ids)
    tracks.restart(np.array([1]), at(50.0), seen(True, False), np.array([[3, 4]]))
    position, valid = tracks.history(ALL)
    assert valid[0].all()
    assert_array_equal(valid[1], [[False, False], [False, False], [True, False]])
    assert_array_equal(position[1, -1], [[50.0, 0.0], [0.0, 0.0]])
    assert_array_equal(tracks.history(np.array([1]))[0], position[1:])


def test_new_columns_have_seen_nothing():
    tracks = tracker()
    before, _ = run(tracks, 6)
    tracks.grow(5)
    position, valid = tracks.history(ALL)
    assert_array_equal(position[:, :, :2], before)
    assert not valid[:, :, 2:].any()


def test_nearest_first_then_by_id():
    distance = np.array([[3.0, 1.0, 2.0, 1.0, 0.5]])
    visible = np.array([[True, True, True, True, False]])
    chosen = nearest(distance, visible, np.array([[10, 12, 13, 11, 14]]), 3)
    assert_array_equal(chosen.slot, [[3, 1, 2]])
    assert_array_equal(chosen.ids, [[11, 12, 13]])
    assert chosen.valid.all()
    assert_array_equal(chosen.mask(5), [[False, True, True, True, False]])


def test_empty_places_are_marked():
    chosen = nearest(np.array([[3.0, 1.0]]), np.array([[True, False]]), IDS, 4)
    assert_array_equal(chosen.valid, [[True, False, False, False]])
    assert_array_equal(chosen.ids, [[7, -1, -1, -1]])
    assert_array_equal(chosen.slot[0, 1:], 0)
    assert_array_equal(chosen.mask(2), [[True, False]])


def test_take_picks_the_observed_columns_of_any_axis():
    chosen = nearest(np.array([[3.0, 1.0, 2.0]]), np.ones((1, 3), bool), np.arange(3)[None], 2)
    values = np.arange(3.0)[None]
    assert_array_equal(chosen.take(values), [[1.0, 2.0]])
    paths = np.broadcast_to(values[:, None, :, None], (1, 4, 3, 2))
    assert_array_equal(chosen.take(paths, axis=2)[0, :, :, 0], [[1.0, 2.0]] * 4)
