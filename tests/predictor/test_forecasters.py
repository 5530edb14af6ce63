"""What every forecaster promises: causality, invariance, finite answers, one batch for all."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hand_made_crowds import BASELINES, baseline, network, walkers

from crowdsim.recordings import Recording
from predictor.config import Variant
from predictor.constant_velocity import ConstantVelocityForecaster
from predictor.forecaster import Forecaster, make_forecaster
from predictor.network_forecaster import NetworkForecaster
from predictor.scenes import Scene, scenes
from predictor.trajectory_errors import forecast_scenes


def scene_of(recording: Recording) -> Scene:
    return next(scenes(recording, history_steps=8, forecast_steps=12))


@pytest.fixture(params=["none", "patch", "fast", *BASELINES])
def forecaster(request: pytest.FixtureRequest) -> NetworkForecaster:
    name = request.param
    if name in BASELINES:
        return NetworkForecaster(baseline(name))
    return NetworkForecaster(network("patch", "fast") if name == "fast" else network(name))


def forecast(forecaster: Forecaster, recording: Recording, **changes: np.ndarray) -> np.ndarray:
    scene = replace(scene_of(recording), **changes)
    picture = recording.map_image, recording.pixel_from_world
    return forecaster.forecast(scene.history, scene.valid, *picture)


def test_editing_the_future_changes_no_forecast(forecaster: Forecaster) -> None:
    rng = np.random.default_rng(0)
    recording = walkers(rng, people=8, frames=24)
    recording.valid[10:, 7] = False
    recording.positions[10:, 7] = 0.0
    before = forecast_scenes(forecaster, [scene_of(recording)])[0]
    edited = replace(recording, positions=recording.positions.copy(), valid=recording.valid.copy())
    edited.positions[8:, :7] += rng.normal(size=(16, 7, 2))
    edited.valid[8:, 7] = False
    edited.positions[8:, 7] = 0.0
    assert np.array_equal(before, forecast_scenes(forecaster, [scene_of(edited)])[0])


def test_the_history_does_change_the_forecast(forecaster: Forecaster) -> None:
    recording = walkers(np.random.default_rng(0))
    history = scene_of(recording).history.copy()
    history[0, 0] += 0.5
    change = forecast(forecaster, recording, history=history) - forecast(forecaster, recording)
    assert np.abs(change[:, 0]).max() > 1e-3


def test_turning_and_shifting_the_scene_moves_the_forecast_with_it(forecaster: Forecaster) -> None:
    recording = walkers(np.random.default_rng(1), people=10)
    scene, angle, shift = scene_of(recording), 0.7, np.array([11.0, -3.0])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    moved_from_world = np.eye(3)
    moved_from_world[:2, :2], moved_from_world[:2, 2] = turn, shift
    assert recording.pixel_from_world is not None
    moved = forecaster.forecast(
        scene.history @ turn.T + shift,
        scene.valid,
        recording.map_image,
        recording.pixel_from_world @ np.linalg.inv(moved_from_world),
    )
    expected = forecast(forecaster, recording) @ turn.T + shift
    np.testing.assert_allclose(moved, expected, atol=2e-3)


def test_order_of_neighbors_and_absent_people_change_nothing(forecaster: Forecaster) -> None:
    rng = np.random.default_rng(2)
    recording = walkers(rng, people=7)
    scene, plain = scene_of(recording), forecast(forecaster, recording)
    order = rng.permutation(7)
    ghosts = rng.normal(size=(8, 3, 2))
    history = np.concatenate([scene.history[:, order], ghosts], axis=1)
    seen = np.concatenate([scene.valid[:, order], np.zeros((8, 3), dtype=np.bool_)], axis=1)
    shuffled = forecast(forecaster, recording, history=history, valid=seen)
    assert np.array_equal(shuffled[:, :7], plain[:, order])
    assert np.array_equal(shuffled[:, 7:], np.zeros((12, 3, 2)))


def test_batch_of_one_is_batch_of_many_bit_for_bit(forecaster: Forecaster) -> None:
    rng = np.random.default_rng(3)
    crowds = [walkers(rng, people=n) for n in (1, 2, 9, 37)]
    batch = forecast_scenes(forecaster, [scene_of(crowd) for crowd in crowds])
    for crowd, together in zip(crowds, batch, strict=True):
        alone = forecast(forecaster, crowd)
        assert np.array_equal(alone, together)
        select = np.zeros(len(crowd.ids), dtype=np.bool_)
        select[-1] = True
        scene = scene_of(crowd)
        one = forecaster.forecast(
            scene.history, scene.valid, crowd.map_image, crowd.pixel_from_world, select
        )
        assert np.array_equal(one[:, -1], alone[:, -1])
        assert np.array_equal(one[:, :-1], np.repeat(scene.history[-1:, :-1], 12, axis=0))


@pytest.mark.parametrize("observed", [1, 2, 3])
def test_few_observed_frames_give_finite_forecasts(forecaster: Forecaster, observed: int) -> None:
    recording = walkers(np.random.default_rng(4))
    history, valid = scene_of(recording).history.copy(), scene_of(recording).valid.copy()
    valid[:-observed], history[:-observed] = False, np.nan
    path = forecast(forecaster, recording, history=history, valid=valid)
    assert np.isfinite(path).all()
    assert np.abs(path - history[-1]).max() < 30.0


def test_standing_people_get_finite_forecasts(forecaster: Forecaster) -> None:
    history = np.repeat(np.random.default_rng(5).normal(size=(1, 4, 2)), 8, axis=0)
    path = forecaster.forecast(history, np.ones((8, 4), dtype=np.bool_))
    assert np.isfinite(path).all()


def test_a_lone_person_without_map_gets_a_forecast(forecaster: Forecaster) -> None:
    history = np.arange(8.0)[:, None, None] * np.array([0.5, 0.0])
    assert np.isfinite(forecaster.forecast(history, np.ones((8, 1), dtype=np.bool_))).all()


@pytest.mark.parametrize("horizon", [4.8, 9.6])
def test_empty_scene_gives_an_empty_forecast(variant: Variant, horizon: float) -> None:
    steps = round(horizon / 0.4)
    for forecaster in (
        NetworkForecaster(network(variant), forecast_steps=steps),
        ConstantVelocityForecaster(forecast_steps=steps),
    ):
        nobody = forecaster.forecast(np.zeros((2, 8, 0, 2)), np.zeros((2, 8, 0), dtype=np.bool_))
        assert nobody.shape == (2, steps, 0, 2)
        gone = forecaster.forecast(np.ones((8, 3, 2)), np.zeros((8, 3), dtype=np.bool_))
        assert np.array_equal(gone, np.zeros((steps, 3, 2)))


def test_longer_horizon_continues_the_shorter_one(variant: Variant) -> None:
    """At walking pace: what may be too fast depends on what was observed, not on forecasts."""
    recording, calm = walkers(np.random.default_rng(6)), network(variant, loudness=0.5)
    short, one, long = (
        forecast(NetworkForecaster(calm, forecast_steps=n), recording) for n in (12, 1, 30)
    )
    assert np.array_equal(one, short[:1])
    assert np.array_equal(long[:12], short)
    assert np.isfinite(long).all()
    again = NetworkForecaster(calm).forecast(
        short[-8:], np.ones((8, 6), dtype=np.bool_), recording.map_image, recording.pixel_from_world
    )
    assert np.array_equal(long[12:24], again)


def test_neighbors_who_are_not_asked_for_are_rolled_on_too(variant: Variant) -> None:
    recording = walkers(np.random.default_rng(6))
    forecaster = NetworkForecaster(network(variant), forecast_steps=24)
    scene, everyone = scene_of(recording), forecast(forecaster, recording)
    one = forecaster.forecast(
        scene.history,
        scene.valid,
        recording.map_image,
        recording.pixel_from_world,
        np.arange(6) == 2,
    )
    assert np.array_equal(one[:, 2], everyone[:, 2])


def test_constant_velocity_by_hand() -> None:
    history = np.zeros((8, 3, 2))
    history[-2:, 0] = [[1.0, 1.0], [1.5, 0.0]]
    valid = np.ones((8, 3), dtype=np.bool_)
    valid[:-1, 1] = False
    history[-1, 1], history[-2, 1] = [4.0, 4.0], [-50.0, 0.0]
    path = ConstantVelocityForecaster(forecast_steps=2).forecast(history, valid)
    np.testing.assert_allclose(path[:, 0], [[2.0, -1.0], [2.5, -2.0]])
    np.testing.assert_allclose(path[:, 1], [[4.0, 4.0], [4.0, 4.0]])


def test_position_that_is_not_finite_is_refused(forecaster: Forecaster) -> None:
    history = np.zeros((8, 2, 2))
    history[3, 1] = np.nan
    with pytest.raises(ValueError, match="finite"):
        forecaster.forecast(history, np.ones((8, 2), dtype=np.bool_))


def test_shapes_are_checked(forecaster: Forecaster) -> None:
    with pytest.raises(ValueError, match=r"valid must be bool \(8, 2\)"):
        forecaster.forecast(np.zeros((8, 2, 2)), np.ones((8, 3), dtype=np.bool_))


def test_make_forecaster() -> None:
    assert make_forecaster("none") is None
    forecaster = make_forecaster("constant_velocity", horizon=0.4)
    assert forecaster is not None
    assert forecaster.forecast_steps == 1
    with pytest.raises(ValueError, match=r"multiple of 0\.4"):
        make_forecaster("constant_velocity", horizon=1.0)
    with pytest.raises(ValueError, match=r"constant_velocity.*got 'oracle'"):
        make_forecaster("oracle")


def test_constant_velocity_needs_no_torch() -> None:
    code = (
        "import sys; from predictor.forecaster import make_forecaster; "
        "make_forecaster('constant_velocity'); sys.exit('torch' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
