"""Radii of forecasts that go on beyond what a network was trained for."""

from pathlib import Path

import numpy as np
import pytest
from hand_made_crowds import baseline, walkers

from crowdsim.recordings import write_recordings
from predictor.calibration import LEVEL, calibration, radius_of
from predictor.checkpoint import load_checkpoint, save_checkpoint
from predictor.datasets import read_training
from predictor.forecaster import CalibratedForecaster, make_forecaster
from predictor.rolled_calibration import calibrate_rolled
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
    found = calibrate_rolled(checkpoint, data, horizon=12.0)
    assert found["windows"] == 2 * 9 * 3
    after, about = load_checkpoint(checkpoint)
    for name, weights in before.state_dict().items():
        assert weights.equal(after.state_dict()[name])
    assert about["calibration"]["rolled"] == found
    for horizon, steps in ((4.8, 12), (12.0, 30), (12.4, None)):
        forecaster = make_forecaster(str(checkpoint), horizon=horizon)
        assert isinstance(forecaster, CalibratedForecaster)
        assert (None if forecaster.radius is None else forecaster.radius.shape[1]) == steps
    forecaster = make_forecaster(str(checkpoint), horizon=12.0)
    assert forecaster is not None
    errors = trajectory_errors(forecaster, read_training(data)[1]).errors
    assert (errors[:, 12:] <= forecaster.radius[-1, 12:]).mean() == pytest.approx(LEVEL, abs=0.03)
    assert forecaster.radius[-1, :12].tolist() == np.linspace(0.1, 1.2, 12).tolist()


def test_a_later_radius_is_not_smaller() -> None:
    errors = np.full((20, 2), 2.0)
    rolled = {"radius": [0.1, 0.1, 1.0, 3.0, 2.5], "windows": 7}
    about = {"calibration": {**calibration(errors), "rolled": rolled}}
    found = radius_of(about, 3, 2)
    assert found is not None
    assert found.tolist() == [[2.0, 2.0, 2.0, 3.0, 3.0]] * 3


@pytest.mark.parametrize("rolled", [3, {}, {"radius": [1.0] * 12 + [-1.0]}, {"radius": "far"}])
def test_damaged_radii_are_refused(rolled: object) -> None:
    about = {"calibration": {**calibration(np.ones((20, 12))), "rolled": rolled}}
    with pytest.raises(ValueError, match="rolled forecasts, found"):
        radius_of(about, 8, 12)


def test_nobody_who_stays_long_enough_is_said(checkpoint: Path, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    write_recordings(tmp_path / "crowds", [walkers(rng, 3, 20, f"{i}") for i in range(2)])
    with pytest.raises(ValueError, match="found none"):
        calibrate_rolled(checkpoint, str(tmp_path / "crowds"), horizon=9.6)
