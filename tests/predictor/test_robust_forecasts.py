"""The bundled network where little is known: few frames, gaps, people who stand, long horizons."""

import numpy as np
import pytest
from hand_made_crowds import walkers

from crowdsim.recordings import Recording
from predictor.forecaster import Forecaster, make_forecaster
from predictor.scenes import Scene, scenes
from predictor.trajectory_errors import forecast_scenes


@pytest.fixture(scope="module", params=[4.8, 19.2])
def forecaster(request: pytest.FixtureRequest) -> Forecaster:
    made = make_forecaster("iterative_attention", horizon=request.param)
    assert made is not None
    return made


def walker(speed: float, observed: int) -> tuple[np.ndarray, np.ndarray]:
    """Eight frames of one person who walks along +x, of whom the last ones were observed."""
    history = np.zeros((8, 1, 2))
    history[:, 0, 0] = 0.4 * speed * np.arange(-7.0, 1.0)
    return history, np.arange(8)[:, None] >= 8 - observed


@pytest.mark.parametrize("observed", [2, 3, 8])
@pytest.mark.parametrize("speed", [0.5, 1.3, 2.0])
def test_who_walks_goes_on_after_two_frames(
    forecaster: Forecaster, speed: float, observed: int
) -> None:
    path = forecaster.forecast(*walker(speed, observed))[:, 0]
    straight = 0.4 * speed * forecaster.forecast_steps
    assert (np.diff(path[:, 0], prepend=0.0) > 0.0).all()
    assert 0.4 * straight < path[-1, 0] < 1.5 * straight
    assert np.abs(path[:, 1]).max() < 0.2 * straight


@pytest.mark.parametrize("observed", [1, 2, 8])
def test_who_stands_stays(forecaster: Forecaster, observed: int) -> None:
    path = forecaster.forecast(*walker(0.0, observed))[:, 0]
    assert np.linalg.norm(path, axis=-1).max() < 0.6


def test_who_was_seen_once_is_not_sent_away(forecaster: Forecaster) -> None:
    path = forecaster.forecast(*walker(1.3, observed=1))[:, 0]
    assert np.linalg.norm(path, axis=-1).max() < 0.6


def crowd() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    recording = walkers(np.random.default_rng(3), people=5)
    scene = next(scenes(recording, history_steps=8, forecast_steps=12))
    assert recording.map_image is not None
    assert recording.pixel_from_world is not None
    return scene.history, scene.valid, recording.map_image, recording.pixel_from_world


def test_gaps_of_neighbors_are_masked_and_not_filled(forecaster: Forecaster) -> None:
    """What stands in a gap is not read, a gap is not the same as no gap, and nothing is written."""
    history, valid, *picture = crowd()
    whole = forecaster.forecast(history, valid, *picture)
    gaps = valid.copy()
    gaps[2:5, 1], gaps[:6, 2] = False, False
    kept = history.copy()
    forecast = forecaster.forecast(history, gaps, *picture)
    assert np.array_equal(history, kept)
    for filling in (0.0, 1e6, np.nan):
        filled = np.where(gaps[..., None], history, filling)
        assert np.array_equal(forecaster.forecast(filled, gaps, *picture), forecast)
    assert np.abs(forecast[:, 0] - whole[:, 0]).max() > 1e-4


def test_nobody_at_all_is_an_empty_forecast(forecaster: Forecaster) -> None:
    steps = forecaster.forecast_steps
    nobody = forecaster.forecast(np.zeros((3, 8, 0, 2)), np.zeros((3, 8, 0), dtype=np.bool_))
    assert nobody.shape == (3, steps, 0, 2)


def test_editing_the_future_changes_no_forecast_at_any_horizon(forecaster: Forecaster) -> None:
    """Through the windows that evaluations are cut from; somebody else appears in the future."""
    recording = walkers(np.random.default_rng(3), people=6, frames=60)
    recording.valid[:8, 5] = False
    before = forecast_scenes(forecaster, [first_scene(recording, forecaster)])[0]
    recording.positions[8:, :5] += np.random.default_rng(4).normal(size=(52, 5, 2))
    recording.positions[8:, 5] = recording.positions[8:, 0]
    after = forecast_scenes(forecaster, [first_scene(recording, forecaster)])[0]
    assert np.array_equal(before, after)


def first_scene(recording: Recording, forecaster: Forecaster) -> Scene:
    return next(scenes(recording, history_steps=8, forecast_steps=forecaster.forecast_steps))
