"""What the robot knows of people whom it sees badly, late, or no longer."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from envs.config import make_config
from envs.episodes import Episodes
from envs.evaluation.runs import run_episode
from envs.sensor import Detections
from envs.track_filter import TrackFilter, steady_gains

GO = (0.2, 0.1)
IMPERFECT = {
    "occlusion": True,
    "field_of_view": 2.0,
    "missed_detections": 0.2,
    "position_noise": 0.1,
    "track_loss_rate": 0.5,
    "track_memory": 1.0,
}


def run(seeds, steps, **keywords):
    """Episodes after so many steps, and the observations on the way."""
    episodes = Episodes(make_config(**keywords), len(seeds))
    observations = [episodes.reset([np.random.default_rng(seed) for seed in seeds])]
    for _ in range(steps):
        observations.append(episodes.step(np.tile(GO, (len(seeds), 1))).observation)
    return episodes, observations


def observed(observations, key):
    return np.array([each[key][0] for each in observations])


def test_no_world_depends_on_the_others():
    _, together = run((3, 4, 5), 12, **IMPERFECT)
    for world, seed in enumerate((3, 4, 5)):
        _, alone = run((seed,), 12, **IMPERFECT)
        for key in alone[0]:
            for step in range(13):
                assert_array_equal(together[step][key][world], alone[step][key][0], key)


def test_a_restart_in_one_world_spares_the_others():
    keywords = {**IMPERFECT, "scenario": "narrow_doorway"}
    undisturbed, _ = run((3, 4), 6, **keywords)
    disturbed, _ = run((3, 4), 6, **keywords)
    disturbed.reset([np.random.default_rng(9)], [1])
    first = undisturbed.step([GO, GO]).observation
    second = disturbed.step([GO, GO]).observation
    for key in first:
        assert_array_equal(first[key][0], second[key][0], key)


def test_nobody_behind_the_robot_is_seen_with_half_a_view():
    _, observations = run((3,), 10, field_of_view=math.pi)
    valid = observed(observations, "neighbors_valid") > 0
    here = observed(observations, "history")[:, :, -1]
    assert valid.any()
    assert (here[valid][:, 0] >= -1e-6).all()


def test_walls_hide_people():
    keywords = {"scenario": "narrow_doorway", "sensor_range": 50.0}
    through, _ = run((3,), 0, **keywords)
    episodes, _ = run((3,), 0, occlusion=True, **keywords)
    robot, people = episodes.worlds.robots.position[0], episodes.worlds.crowd.position[0]
    hidden = (people[:, 0] * robot[0] < 0) & (np.abs(people[:, 1]) > 1.6)
    assert hidden.any()
    percept, _ = through.percept(0)
    assert percept.observed.mask(len(hidden))[0][hidden].all()
    percept, _ = episodes.percept(0)
    assert not percept.observed.mask(len(hidden))[0][hidden].any()


def test_the_share_of_misses_is_as_asked_for():
    _, all_of_them = run((3,), 60, sensor_range=50.0, pedestrians_observed=20)
    _, some = run((3,), 60, sensor_range=50.0, pedestrians_observed=20, missed_detections=0.3)
    whole, part = (observed(each, "neighbors_valid").sum() for each in (all_of_them, some))
    assert part / whole == pytest.approx(0.7, abs=0.04)


def test_memory_carries_on_whom_the_sensor_misses():
    keywords = {"sensor_range": 50.0, "pedestrians_observed": 20}
    _, all_of_them = run((3,), 60, **keywords)
    _, some = run((3,), 60, missed_detections=0.3, track_memory=2.0, **keywords)
    whole, part = (observed(each, "neighbors_valid")[10:].sum() for each in (all_of_them, some))
    assert part / whole > 0.99


def test_a_lost_track_begins_anew():
    _, observations = run((3,), 40, track_loss_rate=1.0, sensor_range=50.0)
    valid = observed(observations, "history_valid")[20:]
    present = observed(observations, "neighbors_valid")[20:] > 0
    assert valid[present][:, -1].all()
    # A track is at least 2.8 s old, 7 frames, with probability 0.8^14 = 4 %.
    assert valid[present][:, 0].mean() == pytest.approx(0.04, abs=0.04)


def test_a_long_history_is_kept_unless_told_otherwise():
    _, observations = run((3,), 30, history_steps=12, forecaster="none")
    assert observed(observations, "history_valid")[-1].all(axis=-1).any()


def tracked(detections, **keywords):
    """Tracks (T, 2), and whether they go on (T,), of one person after each detection or None."""
    tracks = TrackFilter(1, **({"dt": 0.2, "noise": 0.0, "memory": 0.6} | keywords))
    tracks.restart(np.array([0]))
    positions, alive = [], []
    for place in detections:
        seen = np.array([[place is not None]])
        where = np.array([[(np.nan, np.nan) if place is None else place]])
        found = tracks.update(slice(None), Detections(where, seen, np.array([[7]])))
        positions.append(found.position[0, 0])
        alive.append(found.seen[0, 0])
    return np.array(positions), np.array(alive)


def test_without_noise_detections_pass_unchanged():
    path = [(0.3 * step, 0.1 * step**2) for step in range(10)]
    positions, alive = tracked(path)
    assert_allclose(positions, path, atol=1e-12)
    assert alive.all()


def test_a_ghost_walks_on_and_is_forgotten():
    positions, alive = tracked([(0.0, 0.0), (0.2, 0.0), None, None, None, None, (3.0, 0.0)])
    assert_array_equal(alive, [True, True, True, True, True, False, True])
    assert_allclose(positions[:5, 0], [0.0, 0.2, 0.4, 0.6, 0.8], atol=1e-12)
    assert_allclose(positions[6], (3.0, 0.0))


def test_the_filter_halves_the_noise_of_a_straight_walk():
    rng = np.random.default_rng(0)
    truth = np.stack((0.24 * np.arange(400), np.zeros(400)), axis=1)
    measured = truth + 0.1 * rng.standard_normal(truth.shape)
    positions, _ = tracked(list(map(tuple, measured)), noise=0.1)
    error = (positions - truth)[20:].std()
    assert error < 0.75 * 0.1


def test_steady_gains_are_those_of_the_kalman_filter():
    dt, acceleration, noise = 0.2, 1.0, 0.1
    transition = np.array([[1.0, dt], [0.0, 1.0]])
    entry = np.array([[dt**2 / 2], [dt]])
    process = acceleration**2 * entry @ entry.T
    covariance = np.eye(2)
    for _ in range(2000):
        prior = transition @ covariance @ transition.T + process
        gain = prior[:, :1] / (prior[0, 0] + noise**2)
        covariance = (np.eye(2) - gain @ np.array([[1.0, 0.0]])) @ prior
    alpha, beta = steady_gains(acceleration * dt**2 / noise)
    assert_allclose((alpha, beta / dt), gain[:, 0], rtol=1e-6)


WALKERS = {"people": [(-4.0, 3.0), (-4.0, -3.0), (4.0, 4.0)], "goals": [(40, 3), (40, -3), (4, 4)]}


def lags(scene, jitter, steps=30, **keywords):
    """(steps, 3) how far behind two who walk along x and one who stands are measured [m]."""
    name = scene(**WALKERS)
    keywords = {"scenario": name, "forecaster": "none", "sensor_range": 50.0, **keywords}
    episodes, _ = run((3,), 10, frame_jitter=jitter, **keywords)
    behind = []
    for _ in range(steps):
        episodes.step([GO])
        percept, _ = episodes.percept(0)
        slot = percept.observed.slot[0, :3]
        measured = np.empty((3, 2))
        measured[slot] = percept.history[0, :3, -1]
        behind.append((episodes.worlds.crowd.position[0] - measured)[:, 0])
    return np.array(behind)


def test_late_frames_show_walkers_behind_and_standers_where_they_are(scene):
    behind = lags(scene, 0.2)
    assert np.abs(behind[:, 2]).max() < 0.02  # nobody stands quite still
    assert (behind[:, :2] > 0.0).all()
    assert behind[:, :2].max() < 0.2 * 1.0 + 0.02  # they walk at 1 m/s
    assert behind[:, 0].mean() == pytest.approx(0.1, abs=0.03)
    assert np.corrcoef(behind[:, 0], behind[:, 1])[0, 1] > 0.95  # one frame, one delay
    assert_allclose(lags(scene, 0.0), 0.0, atol=1e-9)


def test_a_frame_lies_between_the_states_of_the_physics():
    episodes, _ = run((3,), 5, forecaster="none")
    before = episodes.worlds.crowd.position[0].copy()
    episodes.step([GO])
    now = episodes.worlds.crowd.position[0]
    assert_array_equal(episodes.worlds.people_before(0, 0.0), now)
    assert_allclose(episodes.worlds.people_before(0, 0.2), before, atol=1e-12)
    states = [episodes.worlds.people_before(0, age) for age in (0.05, 0.075, 0.1)]
    assert_allclose(states[1], (states[0] + states[2]) / 2, atol=1e-12)


def test_jitter_changes_neither_noise_nor_misses(scene):
    keywords = {"scenario": scene(**WALKERS), "forecaster": "none", "missed_detections": 0.4}
    punctual, late = (
        run_episode(make_config(frame_jitter=jitter, **keywords), "straight", 3)
        for jitter in (0.0, 0.2)
    )
    assert not punctual.visible.all()
    assert_array_equal(punctual.visible, late.visible)


def test_who_has_just_entered_is_not_in_a_late_frame():
    config = make_config(
        scenario="perpendicular_traffic",
        forecaster="none",
        sensor_range=50.0,
        frame_jitter=0.1,
        time_limit=8.0,
    )
    trace = run_episode(config, "social_force", 10000)
    entered = trace.valid[1:] & (
        (trace.ids[1:] != trace.ids[:-1]) | (trace.valid[1:] & ~trace.valid[:-1])
    )
    assert entered.any()
    assert not trace.visible[1:][entered].any()
    assert trace.visible[1:][trace.valid[1:] & ~entered].all()
