"""Radii of forecasts from short histories, and beyond what a network was trained for."""

from pathlib import Path

import numpy as np
import pytest
from hand_made_crowds import baseline, walkers

from crowdsim.recordings import write_recordings
from predictor.calibration import LEVEL, calibration, radius_of
from predictor.checkpoint import load_checkpoint, save_checkpoint
from predictor.datasets import read_training
from predictor.forecaster import CalibratedForecaster, make_forecaster
from predictor.recalibration import errors_from, recalibrate
from predictor.trajectory_errors import trajectory_errors


@pytest.fixture
def checkpoint(tmp_path: Path) -> Path:
    errors = np.tile(np.linspace(0.1, 1.2, 12), (20, 1))
    path = tmp_path / "network" / "best.safetensors"
    save_checkpoint(path, baseline("history_mlp"), {"calibration": calibration(errors)})
    return path.parent


def test_rolled_forecasts_know_how_far_off_they_are(checkpoint: Path, tmp_path: Path) -> None:
    rng, data = np.random.default_rng(0), str(tmp_path / "crowds")
    write_recordings(tmp_path / "crowds", [walkers(rng, 9, 40, f"{i}") for i in range(20)])
    before, _ = load_checkpoint(checkpoint)
    found = recalibrate(checkpoint, data, horizon=12.0)
    assert found["rolled"]["windows"] == 2 * 9 * 3
    after, about = load_checkpoint(checkpoint)
    for name, weights in before.state_dict().items():
        assert weights.equal(after.state_dict()[name])
    assert {key: about["calibration"][key] for key in found} == found
    for horizon, steps in ((4.8, 12), (12.0, 30), (12.4, None)):
        forecaster = make_forecaster(str(checkpoint), horizon=horizon)
        assert isinstance(forecaster, CalibratedForecaster)
        assert (None if forecaster.radius is None else forecaster.radius.shape[1]) == steps
    forecaster = make_forecaster(str(checkpoint), horizon=12.0)
    assert forecaster is not None
    errors = trajectory_errors(forecaster, read_training(data)[1]).errors
    assert (errors[:, 12:] <= forecaster.radius[-1, 12:]).mean() == pytest.approx(LEVEL, abs=0.03)
    assert forecaster.radius[-1, :12].tolist() == np.linspace(0.1, 1.2, 12).tolist()


def test_each_length_of_history_has_the_radii_that_hold_of_it(
    checkpoint: Path, tmp_path: Path
) -> None:
    """Measured on some crowds, they hold in others; seen once, nobody knows where people go."""
    rng, data = np.random.default_rng(0), str(tmp_path / "crowds")
    write_recordings(tmp_path / "crowds", [walkers(rng, 30, 40, f"{i}") for i in range(20)])
    recalibrate(checkpoint, data, horizon=4.8)
    forecaster = make_forecaster(str(checkpoint))
    assert isinstance(forecaster, CalibratedForecaster)
    assert forecaster.radius is not None
    assert forecaster.radius.shape == (8, 12)
    assert forecaster.radius[-1].tolist() == np.linspace(0.1, 1.2, 12).tolist()
    others = [walkers(rng, 30, 40, f"{i}") for i in range(10)]
    for frames, radius in enumerate(forecaster.radius[:-1], start=1):
        errors = errors_from(forecaster, others, frames)
        assert (errors <= radius).mean() == pytest.approx(LEVEL, abs=0.04)
    assert (forecaster.radius[0] != forecaster.radius[1]).all()


def test_from_the_whole_history_errors_are_those_of_the_table(checkpoint: Path) -> None:
    forecaster = make_forecaster(str(checkpoint))
    assert forecaster is not None
    crowds = [walkers(np.random.default_rng(0), 6, 24)]
    expected = trajectory_errors(forecaster, crowds).errors
    np.testing.assert_array_equal(errors_from(forecaster, crowds, 8), expected)
    assert (errors_from(forecaster, crowds, 1) != expected).any()


def test_a_later_radius_is_not_smaller() -> None:
    errors = np.full((20, 2), 2.0)
    later = [[0.1, 0.1, 1.0, 3.0, 2.5], [0.1, 0.1, 1.0, 1.0, 4.0]]
    about = {"calibration": {**calibration(errors), "rolled": {"radius": later, "windows": 7}}}
    found = radius_of(about, 2, 2)
    assert found is not None
    assert found.tolist() == [[2.0, 2.0, 2.0, 3.0, 3.0], [2.0, 2.0, 2.0, 2.0, 4.0]]


def test_radii_rolled_from_the_whole_history_only_stand_for_all() -> None:
    rolled = {"radius": [0.1, 0.1, 3.0], "windows": 7}
    about = {"calibration": {**calibration(np.full((20, 2), 2.0)), "rolled": rolled}}
    found = radius_of(about, 3, 2)
    assert found is not None
    assert found.tolist() == [[2.0, 2.0, 3.0]] * 3


@pytest.mark.parametrize("short", [3, {}, {"radius": [[1.0] * 12] * 6}, {"radius": "far"}])
def test_damaged_radii_of_short_histories_are_refused(short: object) -> None:
    about = {"calibration": {**calibration(np.ones((20, 12))), "short": short}}
    with pytest.raises(ValueError, match="short histories"):
        radius_of(about, 8, 12)


@pytest.mark.parametrize(
    "rolled", [3, {}, {"radius": [1.0] * 12 + [-1.0]}, {"radius": "far"}, {"radius": [[1.0] * 13]}]
)
def test_damaged_radii_are_refused(rolled: object) -> None:
    about = {"calibration": {**calibration(np.ones((20, 12))), "rolled": rolled}}
    with pytest.raises(ValueError, match="rolled forecasts, found"):
        radius_of(about, 8, 12)


def test_nobody_who_stays_long_enough_is_said(checkpoint: Path, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    write_recordings(tmp_path / "crowds", [walkers(rng, 3, 20, f"{i}") for i in range(2)])
    with pytest.raises(ValueError, match="found none"):
        recalibrate(checkpoint, str(tmp_path / "crowds"), horizon=9.6)
