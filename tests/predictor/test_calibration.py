"""Radii that hold the truth as often as they say, measured wherever forecasts are."""

import json
from pathlib import Path

import numpy as np
import pytest
from hand_made_crowds import baseline, walkers

from crowdsim.recordings import write_recordings
from predictor.calibration import calibration, conformal_radius, nll_of_radius, radius_of
from predictor.checkpoint import save_checkpoint
from predictor.constant_velocity import RADIUS, RADIUS_SEEN_ONCE, ConstantVelocityForecaster
from predictor.evaluate import evaluate
from predictor.forecaster import BUNDLED_WEIGHTS, CalibratedForecaster, make_forecaster
from predictor.networks import configuration
from predictor.train import train


def test_radius_by_hand() -> None:
    """Of ten errors the nine smallest are not enough: 0.9 of eleven is ten."""
    errors = np.stack([np.arange(1.0, 11.0), np.arange(10.0, 0.0, -1.0) / 10.0], axis=1)
    assert conformal_radius(errors).tolist() == [10.0, 1.0]
    assert conformal_radius(np.repeat(errors, 10, axis=0)).tolist() == [10.0, 1.0]
    assert conformal_radius(np.repeat(errors, 10, axis=0), level=0.5).tolist() == [6.0, 0.6]


def test_radius_holds_one_more_error_as_often_as_it_says() -> None:
    rng = np.random.default_rng(0)
    kept, new = rng.exponential(size=(2000, 300)), rng.exponential(size=(200, 300))
    assert (new <= conformal_radius(kept)).mean() == pytest.approx(0.9, abs=0.01)


def test_radii_have_the_density_of_a_round_normal_distribution() -> None:
    """90 % of it are within the radius: a truth there is exp(-ln 10) times as dense as the path."""
    radius = np.array([1.0, 3.0, 0.0])
    at_path, at_radius = nll_of_radius(np.zeros(3), radius), nll_of_radius(radius, radius)
    np.testing.assert_allclose((at_radius - at_path)[:2], np.log(10.0))
    np.testing.assert_allclose(at_path[1] - at_path[0], 2.0 * np.log(3.0))
    assert np.isnan(at_path[2])
    steps = np.linspace(-8.0, 8.0, 801)
    grid = np.hypot(*np.meshgrid(steps, steps))
    assert np.exp(-nll_of_radius(grid, radius[1])).sum() * 0.02**2 == pytest.approx(1.0)


def test_a_checkpoint_keeps_it_and_the_table_tells_the_coverage(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    write_recordings(tmp_path / "train", [walkers(rng, 12, 24, f"{i}") for i in range(20)])
    write_recordings(tmp_path / "test", [walkers(rng, 12, 24, f"{i}") for i in range(20)])
    model, training = configuration("history_mlp", "residual", epochs=2)
    data, out = str(tmp_path / "train"), tmp_path / "mlp"
    train(data=data, out=out, model=model, training=training, progress=False)
    forecaster = make_forecaster(str(out))
    assert forecaster is not None
    row = evaluate(forecaster, str(tmp_path / "test"))["folds"]["test"]
    assert row["coverage@0.9"] == pytest.approx(0.9, abs=0.1)
    assert len(row["coverage_per_step"]) == len(row["radius_per_step"]) == 12
    assert row["radius_mean"] == pytest.approx(np.mean(row["radius_per_step"]))
    assert np.all(np.diff(row["radius_per_step"]) > 0.0)
    for horizon, shape in ((2.0, (8, 5)), (9.6, None)):
        other = make_forecaster(str(out), horizon=horizon)
        assert isinstance(other, CalibratedForecaster)
        assert (None if other.radius is None else other.radius.shape) == shape


@pytest.mark.parametrize("kept", [{"radius": [1.0]}, {"coverage": 0.9, "radius": [-1.0] * 12}, 3])
def test_a_calibration_that_does_not_fit_is_refused(kept: object, tmp_path: Path) -> None:
    save_checkpoint(tmp_path / "best.safetensors", baseline("lstm"), {"calibration": kept})
    with pytest.raises(ValueError, match="expected a calibration"):
        make_forecaster(str(tmp_path))


def test_no_calibration_is_none() -> None:
    assert radius_of({}, 8, 12) is None


def test_without_short_histories_all_have_the_radii_of_the_whole() -> None:
    radius = radius_of({"calibration": calibration(np.full((50, 12), 0.5))}, 8, 12)
    assert radius is not None
    assert radius.tolist() == [[0.5] * 12] * 8


@pytest.mark.parametrize("name", ["iterative_attention", "fast"])
def test_bundled_networks_are_surer_the_more_they_have_seen(name: str) -> None:
    """All lengths were measured on the same windows; between neighbors the difference is small."""
    about = json.loads(BUNDLED_WEIGHTS[name].with_suffix(".json").read_text(encoding="utf-8"))
    radius = radius_of(about, 8, 12)
    assert radius is not None
    assert radius[-1, :12].tolist() == about["calibration"]["radius"]
    assert (np.diff(radius[:, :12], axis=0) < 0.02).all()
    assert (radius[0, :12] > 2.0 * radius[-1, :12]).all()
    assert (np.diff(radius, axis=1) >= 0.0).all()


def test_constant_velocity_knows_its_radii_at_any_horizon_and_frame() -> None:
    forecaster = make_forecaster("constant_velocity")
    assert isinstance(forecaster, CalibratedForecaster)
    np.testing.assert_allclose(forecaster.radius, [RADIUS_SEEN_ONCE, *[RADIUS] * 7])
    long = ConstantVelocityForecaster(forecast_steps=48).radius
    fine = ConstantVelocityForecaster(forecast_steps=96, frame_dt=0.2).radius
    np.testing.assert_allclose(fine[:, 1::2], long)
    np.testing.assert_allclose(np.diff(long[1:, 11:]), RADIUS[11] - RADIUS[10])
    assert (np.diff(long) > 0.0).all()
