"""How sure forecasts are, and what becomes of them once people are out of sight."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from envs.config import make_config
from envs.episodes import Episodes
from envs.forecasters.tracks import TrackForecaster
from envs.foresight import grown
from envs.ghosts import along
from predictor.calibration import SIGMAS
from predictor.constant_velocity import ConstantVelocityForecaster
from predictor.modal_forecast import ModalForecast

FRAMES = 12
GO = (0.2, 0.1)


class Turning(ConstantVelocityForecaster):
    """Forecasts that everybody walks on and drifts to the left; two modes, either side of that."""

    modes = 2
    drift = np.linspace(0.0, 3.0, FRAMES + 1)[1:, None] ** 2

    def forecast(self, history, valid, *rest):
        path = super().forecast(history, valid, *rest)
        path[..., 1] += self.drift
        return path

    def forecast_modes(self, *question):
        path = self.forecast(*question)
        left, right = path.copy(), path.copy()
        left[..., 1] += 0.5
        right[..., 1] -= 0.5
        position = np.stack((left, right), axis=1)
        return ModalForecast(
            path=path,
            position=position,
            probability=np.broadcast_to([[0.7], [0.3]], (len(path), 2, path.shape[2])),
            covariance=np.zeros((*position.shape, 2)),
        )


@pytest.fixture
def turning():
    return Turning()


def started(seeds=(3,), steps=0, **keywords):
    episodes = Episodes(make_config(**keywords), len(seeds))
    episodes.reset([np.random.default_rng(seed) for seed in seeds])
    walk(episodes, steps)
    return episodes


def walk(episodes, steps):
    observation = None
    for _ in range(steps):
        observation = episodes.step(np.tile(GO, (len(episodes), 1))).observation
    return observation


def blind(episodes):
    """From now on the sensors see nobody."""
    config = replace(episodes.config, missed_detections=1.0)
    episodes._perception._sensor._config = config


def test_each_forecaster_says_how_far_off_it_may_be():
    ahead = np.arange(1.0, 13.0)
    once, several = ConstantVelocityForecaster().radius[:2]
    blurred = SIGMAS * 0.5 * ahead / 12
    expected = {
        "constant_velocity": (once, several),
        "constant_velocity_map": (once, several),
        "oracle": (np.zeros(FRAMES),) * 2,
        "oracle_noisy@sigma=0.5": (blurred, blurred),
    }
    for (name, radii), frames in product(expected.items(), (1, 2)):
        observation = walk(started(forecaster=name, steps=2 * (frames - 1)), 1)
        valid = observation["neighbors_valid"][0] > 0
        assert_allclose(observation["forecast_radius"][0, valid][0], radii[frames - 1], rtol=1e-6)
        assert not observation["forecast_radius"][0, ~valid].any()


def test_each_person_has_the_radius_of_the_frames_they_were_seen_in():
    """Some have just come into the range of the sensors, others were there for long."""
    episodes, found = started(forecaster="constant_velocity", sensor_range=4.0), set()
    table = ConstantVelocityForecaster().radius
    for _ in range(20):
        observation = walk(episodes, 1)
        percept, row = episodes.percept(0)
        for place in np.flatnonzero(percept.observed.valid[row]):
            frames = int(percept.history_valid[row, place].sum())
            found.add(frames)
            radius = observation["forecast_radius"][0, place]
            assert_allclose(radius, table[frames - 1], rtol=1e-6)
    assert {1, 2} <= found


def test_radii_without_a_row_for_each_number_of_frames_are_refused():
    forecaster = ConstantVelocityForecaster()
    forecaster.radius = forecaster.radius[-1]
    with pytest.raises(ValueError, match=r"radius must be shaped \(8, 12\)"):
        TrackForecaster(forecaster)


def test_who_sees_one_frame_only_is_never_surer():
    keywords = {"forecaster": "constant_velocity", "history_kept": 1}
    observation = walk(started(steps=12, **keywords), 1)
    there = observation["neighbors_valid"][0] > 0
    expected = ConstantVelocityForecaster().radius[:1]
    radius = observation["forecast_radius"][0, there]
    assert_allclose(radius, np.repeat(expected, there.sum(), axis=0), rtol=1e-6)


def test_a_ghost_is_no_surer_for_being_remembered():
    """What leads it on was forecast from one frame, however long it has been a ghost."""
    everybody = {"sensor_range": 50.0, "forecaster": "constant_velocity", "track_memory": 3.0}
    episodes = started(**everybody)
    once = ConstantVelocityForecaster().radius[:1, None]
    blind(episodes)
    for step in range(1, 10):
        observation = walk(episodes, 1)
        there = observation["neighbors_valid"][0] > 0
        expected = grown(once, np.array([[step / 2]]))[0, 0]
        assert_allclose(observation["forecast_radius"][0, there][0], expected, rtol=1e-6)


def test_the_radius_of_the_noisy_oracle_holds_nine_in_ten():
    offset = 0.5 * np.random.default_rng(0).standard_normal((100_000, 2))
    share = (np.hypot(*offset.T) < SIGMAS * 0.5).mean()
    assert share == pytest.approx(0.9, abs=0.005)


def test_ghosts_follow_the_forecast_of_when_they_were_last_seen(turning):
    everybody = {"sensor_range": 50.0, "pedestrians_observed": 20}
    episodes = started(forecaster=turning, steps=8, track_memory=3.0, **everybody)
    seen, row = episodes.percept(0)
    path = np.concatenate((seen.history[row, :, -1:], seen.forecast[row]), axis=1)
    blind(episodes)
    for step in range(1, 7):
        walk(episodes, 1)
        percept, row = episodes.percept(0)
        for place in np.flatnonzero(percept.observed.valid[row]):
            before = np.flatnonzero(seen.observed.ids[row] == percept.observed.ids[row, place])[0]
            frames = step / 2 + np.arange(FRAMES + 1.0)
            expected = along(path[before], frames)
            assert_allclose(percept.history[row, place, -1], expected[0], atol=1e-9)
            assert_allclose(percept.forecast[row, place], expected[1:], atol=1e-9)


def test_doubt_about_ghosts_grows_and_ends_when_they_are_seen_again():
    episodes = started(steps=8, track_memory=2.0, sensor_range=50.0, forecaster="constant_velocity")
    fresh = ConstantVelocityForecaster().radius[-1]
    config = episodes._perception._sensor._config
    blind(episodes)
    for step in range(1, 5):
        observation = walk(episodes, 1)
        there = observation["neighbors_valid"][0] > 0
        assert there.any()
        expected = grown(fresh[None, None], np.array([[step / 2]]))[0, 0]
        assert (expected > fresh).all()
        assert_allclose(observation["forecast_radius"][0, there][0], expected, rtol=1e-6)
    episodes._perception._sensor._config = config
    assert_allclose(walk(episodes, 1)["forecast_radius"][0, 0], fresh, rtol=1e-6)


def test_after_its_end_a_path_goes_straight_on():
    knots = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]])
    at = np.array([0.5, 1.0, 2.0, 3.5])
    assert_allclose(along(knots, at), [[0.5, 0.0], [1.0, 0.0], [1.0, 2.0], [1.0, 5.0]])


def test_a_new_episode_knows_nothing_of_the_ghosts_of_the_last(turning):
    keywords = {"forecaster": turning, "track_memory": 3.0, "missed_detections": 0.5}
    used, fresh = started(steps=9, **keywords), started((7,), 0, **keywords)
    used.reset([np.random.default_rng(7)])
    for _ in range(8):
        first, second = walk(used, 1), walk(fresh, 1)
        for key, values in first.items():
            assert_array_equal(values, second[key], key)


def test_ghosts_of_one_world_are_none_of_the_others(turning):
    keywords = {
        "forecaster": turning,
        "track_memory": 3.0,
        "missed_detections": 0.5,
        "modes_observed": 2,
    }
    together = walk(started((3, 4, 5), 9, **keywords), 1)
    for world, seed in enumerate((3, 4, 5)):
        alone = walk(started((seed,), 9, **keywords), 1)
        for key, values in alone.items():
            assert_array_equal(values[0], together[key][world], key)


@pytest.mark.parametrize("memory", [0.0, 2.0])
def test_modes_are_in_the_robots_frame_the_likeliest_first(turning, memory):
    episodes = started(forecaster=turning, modes_observed=2, track_memory=memory, steps=3)
    observation = walk(episodes, 1)
    there = observation["neighbors_valid"][0] > 0
    modes, forecast = observation["forecast_modes"][0], observation["forecast"][0]
    assert modes.shape == (8, 2, FRAMES, 2)
    heading = episodes.worlds.robots.heading[0]
    left = 0.5 * np.array([np.sin(heading), np.cos(heading)])  # +y of the world
    assert_allclose(modes[there, 0] - forecast[there], left + 0.0 * forecast[there], atol=1e-5)
    assert_allclose(modes[there, 1] - forecast[there], -left + 0.0 * forecast[there], atol=1e-5)
    assert_allclose(observation["forecast_probabilities"][0, there][0], (0.7, 0.3), rtol=1e-6)
    assert not modes[~there].any()


def test_fewer_modes_are_the_likeliest_ones(turning):
    one = walk(started(forecaster=turning, modes_observed=1), 1)
    two = walk(started(forecaster=turning, modes_observed=2), 1)
    assert_array_equal(one["forecast_modes"], two["forecast_modes"][:, :, :1])
    assert_array_equal(one["forecast"], two["forecast"])


@pytest.mark.parametrize("forecaster", ["constant_velocity", "oracle", "constant_velocity_map"])
def test_modes_of_who_has_none_are_refused(forecaster):
    with pytest.raises(ValueError, match="modes_observed"):
        started(forecaster=forecaster, modes_observed=3)
    with pytest.raises(ValueError, match="modes_observed needs a forecaster"):
        make_config(forecaster="none", modes_observed=3)
