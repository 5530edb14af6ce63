"""Forecasts beyond what a network was trained for: they go on, and never explode."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hand_made_crowds import BASELINES, baseline, network, walkers
from hypothesis import given, settings
from hypothesis import strategies as st

from predictor.checkpoint import save_checkpoint
from predictor.config import ModelName
from predictor.horizon import ANYBODYS_SPEED, TOP_SPEED, bounded, speed_limit
from predictor.initial_weights import continued_network
from predictor.network_forecaster import NetworkForecaster
from predictor.scenes import scenes

FRAME_DT = 0.4


def speeds(path: np.ndarray, now: np.ndarray) -> np.ndarray:
    """(F, N) speeds [m/s] along a path (F, N, 2) that begins at `now` (N, 2)."""
    steps = np.diff(path, axis=0, prepend=now[None])
    return np.asarray(np.linalg.norm(steps, axis=-1)) / FRAME_DT


@st.composite
def histories(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """People who walk, run, stand, tremble and jump, seen in some of the frames."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    people = draw(st.integers(1, 5))
    step = rng.normal(size=(people, 2)) * draw(st.sampled_from([0.0, 0.3, 1.0, 5.0]))
    history = np.arange(8)[:, None, None] * step + rng.normal(size=(people, 2)) * 10.0
    history = history + rng.normal(size=history.shape) * draw(st.sampled_from([0.0, 0.01, 0.5]))
    if draw(st.booleans()):
        history[draw(st.integers(0, 7)) :, 0] += draw(st.sampled_from([3.0, 100.0, -1e4]))
    valid = rng.random((8, people)) < draw(st.sampled_from([0.3, 0.8, 1.0]))
    return history, valid


@pytest.mark.parametrize("name", ["iterative_attention", *BASELINES])
@settings(max_examples=15, deadline=None)
@given(crowd=histories(), steps=st.sampled_from([12, 30, 48, 100]))
def test_nobody_is_forecast_to_be_faster_than_the_limit(
    name: ModelName, crowd: tuple[np.ndarray, np.ndarray], steps: int
) -> None:
    history, valid = crowd
    shouting = baseline(name) if name in BASELINES else network("none")
    path = NetworkForecaster(shouting, forecast_steps=steps).forecast(history, valid)
    limit = np.where(valid[-1], speed_limit(history, valid, FRAME_DT), 0.0)
    now = np.where(valid[-1, :, None], history[-1], 0.0)
    assert np.isfinite(path).all()
    assert (speeds(path, now) <= limit * (1.0 + 1e-6) + 1e-6).all()
    assert limit.max() <= TOP_SPEED


def test_limit_by_hand() -> None:
    """Who stands, walks, runs, jumps, was seen once, and ran before a gap."""
    steps = np.array([0.0, 0.5, 1.6, 40.0, 9.0, 1.6])
    history = np.arange(3.0)[:, None, None] * np.stack([steps, 0.0 * steps], axis=-1)
    valid = np.ones((3, 6), dtype=np.bool_)
    valid[:2, 4], valid[1, 5] = False, False
    expected = [ANYBODYS_SPEED, ANYBODYS_SPEED, 6.0, TOP_SPEED, ANYBODYS_SPEED, 6.0]
    np.testing.assert_allclose(speed_limit(history, valid, FRAME_DT), expected)


def test_only_steps_that_are_too_long_are_shortened() -> None:
    path = np.array([[[1.0, 0.0], [0.1, 0.3]], [[4.0, 4.0], [0.3, 0.7]], [[4.0, 5.0], [0.2, 1.1]]])
    found = bounded(path[None], np.zeros((1, 2, 2)), np.array([[2.5, 2.5]]))[0]
    np.testing.assert_allclose(found[:, 0], [[1.0, 0.0], [2.5, 2.0], [2.5, 3.0]])
    assert np.array_equal(found[:, 1], path[:, 1])


def test_a_horizon_need_be_no_multiple_of_what_was_trained() -> None:
    recording = walkers(np.random.default_rng(1))
    scene = next(scenes(recording, history_steps=8, forecast_steps=12))
    given_ = scene.history, scene.valid, recording.map_image, recording.pixel_from_world
    far = NetworkForecaster(network("patch"), forecast_steps=48).forecast(*given_)
    for steps in (1, 5, 13, 24, 47):
        path = NetworkForecaster(network("patch"), forecast_steps=steps).forecast(*given_)
        assert np.array_equal(path, far[:steps]), steps


def test_the_map_and_the_neighbors_move_along() -> None:
    """After one pass the forecast still depends on what is around the place that was reached."""
    recording = walkers(np.random.default_rng(1))
    scene = next(scenes(recording, history_steps=8, forecast_steps=12))
    picture = recording.map_image, recording.pixel_from_world
    calm = NetworkForecaster(network("patch", loudness=0.5), forecast_steps=24)
    plain = calm.forecast(scene.history, scene.valid, *picture)
    assert recording.map_image is not None
    agent = scene.history[-1, 0]
    distance = np.linalg.norm(plain[11, 0] - agent)
    assert distance > 1.0
    alone = calm.forecast(scene.history, scene.valid & (np.arange(6) == 0), *picture)
    assert np.abs(alone[12:, 0] - plain[12:, 0]).max() > 1e-4


def test_a_network_for_another_horizon_begins_with_what_it_can_use(tmp_path: Path) -> None:
    """All but the layers that give the paths: the first forecasts then look at the same."""
    trained = network("patch", seed=3)
    save_checkpoint(tmp_path / "point" / "best.safetensors", trained, {})
    modal, _ = continued_network(replace(trained.config, modes=3), 0, tmp_path / "point")
    save_checkpoint(tmp_path / "modes" / "best.safetensors", modal, {})
    learned = trained.state_dict()
    for init in ("point", "modes"):
        longer, _ = continued_network(
            replace(trained.config, forecast_steps=24), 0, tmp_path / init
        )
        begun = longer.state_dict()
        kept = {name for name in begun if begun[name].equal(learned[name])}
        anew = {"trajectory_decoder.4.weight", "trajectory_decoder.4.bias"}
        assert begun.keys() - kept == anew
