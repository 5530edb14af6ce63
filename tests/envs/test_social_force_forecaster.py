"""The social force model as a forecaster."""

import numpy as np
import pytest

from crowdsim.map import Map
from envs.forecasters.social_force import SocialForceForecaster
from predictor.constant_velocity import constant_velocity

FORECASTER = SocialForceForecaster()


def tracks(*walkers: tuple[float, float, float, float]) -> np.ndarray:
    """(1, 8, N, 2) straight histories of people (x, y now [m], velocity [m/s])."""
    now, velocity = np.array(walkers)[:, :2], np.array(walkers)[:, 2:]
    return (now + velocity * 0.4 * np.arange(-7, 1)[:, None, None])[None]


def seen(history: np.ndarray) -> np.ndarray:
    return np.ones(history.shape[:-1], dtype=np.bool_)


def test_a_lone_walker_goes_straight_on() -> None:
    history = tracks((0.0, 0.0, 1.2, 0.4))
    path = FORECASTER.forecast(history, seen(history))
    np.testing.assert_allclose(path, constant_velocity(history, seen(history), 12), atol=1e-9)


def test_two_who_meet_turn_aside_and_pass() -> None:
    history = tracks((-3.0, 0.05, 1.2, 0.0), (3.0, -0.05, -1.2, 0.0))
    path = FORECASTER.forecast(history, seen(history))[0]
    aside = path[:, 0, 1].max(), path[:, 1, 1].min()
    assert aside[0] > 0.2
    assert aside[1] < -0.2
    np.testing.assert_allclose(path[:, 0], -path[:, 1], atol=1e-9)
    assert path[-1, 0, 0] > path[-1, 1, 0] + 2.0
    assert np.linalg.norm(path[:, 0] - path[:, 1], axis=-1).min() > 0.4


def test_a_wall_stops() -> None:
    wall = np.array([[[3.0, -4.0], [3.0, 4.0]]])
    room = Map(bounds=(-6.0, -6.0, 6.0, 6.0), walls=wall)
    history = tracks((0.0, 0.0, 1.4, 0.0), (-3.0, 2.0, 0.0, 0.0))
    path = FORECASTER.roll_on(history, seen(history), [room], None)[0]
    assert 2.4 < path[-1, 0, 0] < 2.9
    np.testing.assert_allclose(path[:, 1], history[0, -1, None, 1].repeat(12, axis=0), atol=1e-3)


def test_who_is_not_asked_for_stays_and_still_is_avoided() -> None:
    history = tracks((-3.0, 0.05, 1.2, 0.0), (3.0, -0.05, -1.2, 0.0), (50.0, 0.0, 1.0, 0.0))
    valid = seen(history)
    valid[0, -1, 2] = False
    select = np.array([[True, False, True]])
    path = FORECASTER.forecast(history, valid, select=select)[0]
    both = FORECASTER.forecast(history[:, :, :2], valid[:, :, :2])[0]
    np.testing.assert_array_equal(path[:, 0], both[:, 0])
    np.testing.assert_array_equal(path[:, 1], history[0, -1, 1] + np.zeros((12, 2)))
    np.testing.assert_array_equal(path[:, 2], 0.0)


@pytest.mark.parametrize("frames", [1, 2])
def test_who_has_just_appeared_is_forecast(frames: int) -> None:
    history = tracks((0.0, 0.0, 1.0, 0.0), (5.0, 5.0, 0.0, 1.0))
    valid = seen(history)
    valid[0, :-frames, 0] = False
    path = FORECASTER.forecast(np.where(valid[..., None], history, np.nan), valid)[0]
    assert path[-1, 0, 0] == pytest.approx(0.0 if frames == 1 else 4.8, abs=1e-6)


def test_a_single_world_may_come_alone_and_an_empty_one_gives_nothing() -> None:
    history = tracks((0.0, 0.0, 1.0, 0.0))
    alone = FORECASTER.forecast(history[0], seen(history)[0])
    np.testing.assert_array_equal(alone, FORECASTER.forecast(history, seen(history))[0])
    nobody = FORECASTER.forecast(np.zeros((2, 8, 0, 2)), np.zeros((2, 8, 0), dtype=np.bool_))
    assert nobody.shape == (2, 12, 0, 2)
