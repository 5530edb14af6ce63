"""Metrics of several futures, against numbers worked out by hand and against sampling."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hand_made_crowds import walkers

from predictor.calibration import temperature_of, temperatures
from predictor.constant_velocity import constant_velocity
from predictor.modal_forecast import ModalForecast, covariance_in_world, scaled
from predictor.modal_measures import measures_of_modes
from predictor.modal_metrics import (
    min_ade,
    min_fde,
    min_joint_ade,
    min_joint_fde,
    nll,
    region_mass,
)
from predictor.trajectory_errors import trajectory_errors


def mixture(people: int) -> ModalForecast:
    """Three modes in two steps, the same for all; the first two lie close to each other."""
    position = np.array([[0.0, 0.0], [1.0, 0.5], [-6.0, 2.0]])[:, None, None]
    factor = np.array(
        [[[1.0, 0.0], [0.5, 0.4]], [[0.7, 0.0], [0.0, 1.5]], [[2.0, 0.0], [-1.0, 0.3]]]
    )
    covariance = (factor @ factor.swapaxes(1, 2))[:, None, None]
    shape = (3, 2, people)
    return ModalForecast(
        path=np.zeros((2, people, 2)),
        position=np.broadcast_to(position, (*shape, 2)),
        probability=np.repeat(np.array([[0.5], [0.3], [0.2]]), people, axis=1),
        covariance=np.broadcast_to(covariance, (*shape, 2, 2)),
    )


def drawn(forecast: ModalForecast, rng: np.random.Generator) -> np.ndarray:
    """(F, A, 2) positions drawn from the mixture of each step and person."""
    modes, steps, people = forecast.position.shape[:3]
    mode = rng.choice(modes, size=(steps, people), p=forecast.probability[:, 0])
    step, person = np.ogrid[:steps, :people]
    factor = np.linalg.cholesky(forecast.covariance[mode, step, person])
    noise = rng.standard_normal((steps, people, 2))
    return forecast.position[mode, step, person] + np.einsum("faxy,fay->fax", factor, noise)


def test_minima_by_hand() -> None:
    errors = np.array(
        [[[1.0, 4.0], [3.0, 4.0]], [[2.0, 1.0], [2.0, 3.0]], [[9.0, 0.0], [0.0, 0.0]]]
    )
    assert min_ade(errors, 1).tolist() == [2.0, 4.0]
    assert min_ade(errors, 2).tolist() == [2.0, 2.0]
    assert min_fde(errors, 2).tolist() == [2.0, 3.0]
    assert min_fde(errors, 3).tolist() == [0.0, 0.0]
    assert min_joint_ade(errors, 2) == 2.0
    assert min_joint_fde(errors, 2) == 2.5
    assert min_joint_ade(errors, 1) == min_ade(errors, 1).mean()
    assert min_joint_ade(errors, 3) >= min_ade(errors, 3).mean()


def test_nll_of_one_normal_distribution_by_hand() -> None:
    covariance = np.diag([4.0, 0.25])[None, None, None]
    forecast = ModalForecast(
        path=np.zeros((1, 1, 2)),
        position=np.zeros((1, 1, 1, 2)),
        probability=np.ones((1, 1)),
        covariance=covariance,
    )
    future = np.array([[[2.0, 0.5]]])
    assert nll(forecast, future).item() == pytest.approx(math.log(2 * math.pi) + 1.0)
    # the region that reaches there is an ellipse: 1 - exp(-d^2 / 2)
    assert region_mass(forecast, future).item() == pytest.approx(1.0 - math.exp(-1.0), abs=0.02)


def test_truth_drawn_from_the_mixture_lies_in_its_regions_as_often_as_they_say() -> None:
    rng = np.random.default_rng(0)
    forecast = mixture(2000)
    mass = region_mass(forecast, drawn(forecast, rng))
    for level in (0.5, 0.9):
        assert (mass <= level).mean() == pytest.approx(level, abs=0.025)
    narrow = replace(forecast, covariance=0.5 * forecast.covariance)
    assert (region_mass(narrow, drawn(forecast, rng)) <= 0.9).mean() < 0.85


def test_temperatures_undo_what_covariances_were_scaled_by() -> None:
    rng = np.random.default_rng(0)
    honest = mixture(2000)
    future = drawn(honest, rng)
    found = temperatures(scaled(honest, np.array([0.5, 3.0])), future)
    np.testing.assert_allclose(found, [2.0, 1.0 / 3.0], rtol=0.15)


def test_covariances_turn_with_the_agent() -> None:
    rng = np.random.default_rng(0)
    factor = rng.standard_normal((5, 3, 4, 2, 2))
    covariance = factor @ factor.swapaxes(-1, -2)
    angle = rng.uniform(-np.pi, np.pi, 5)
    turn = np.moveaxis(
        np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]), 2, 0
    )
    world_from_agent = np.tile(np.eye(3), (5, 1, 1))
    world_from_agent[:, :2, :2] = turn
    axes = turn[:, None, None]
    np.testing.assert_allclose(
        covariance_in_world(covariance, world_from_agent),
        axes @ covariance @ axes.swapaxes(-1, -2),
        atol=1e-12,
    )


def test_a_table_knows_the_best_of_modes_and_their_density() -> None:
    rng = np.random.default_rng(0)
    forecast = mixture(7)
    future = drawn(forecast, rng)
    errors = np.linalg.norm(forecast.position - future, axis=-1)
    found = measures_of_modes(forecast, future, errors)
    assert set(found) == {
        "nll",
        "region_coverage@0.9",
        "min_ade_1",
        "min_fde_1",
        *(f"min_{kind}_3" for kind in ("ade", "fde", "joint_ade", "joint_fde")),
    }
    assert found["nll"].shape == found["region_coverage@0.9"].shape == (7, 2)
    assert (found["min_ade_3"] <= found["min_ade_1"]).all()
    assert found["min_joint_ade_3"].mean() >= found["min_ade_3"].mean()


class Doubtful:
    """Constant velocity, and to either side of it."""

    name, frame_dt, history_steps, forecast_steps, modes, radius = "doubtful", 0.4, 8, 12, 3, None

    def forecast(self, history, valid, map_images=None, pixel_from_world=None, select=None):
        return constant_velocity(history, valid, self.forecast_steps)

    def forecast_modes(self, history, valid, map_images=None, pixel_from_world=None, select=None):
        path = self.forecast(history, valid)
        position = np.stack([path, path + 0.5, path - 0.5], axis=1)
        return ModalForecast(
            path=path,
            position=position,
            probability=np.full((len(path), 3, path.shape[2]), 1.0 / 3.0),
            covariance=np.broadcast_to(0.1 * np.eye(2), (*position.shape, 2)),
        )


def test_errors_of_a_forecaster_with_modes_are_those_of_its_path() -> None:
    crowd = walkers(np.random.default_rng(0), people=5, frames=24)
    found = trajectory_errors(Doubtful(), [crowd])
    np.testing.assert_allclose(found.errors.mean(axis=1), found.measures["min_ade_1"])
    assert (found.measures["min_ade_3"] <= found.measures["min_ade_1"]).all()
    assert found.measures["nll"].shape == found.errors.shape


def test_temperatures_that_do_not_fit_are_refused() -> None:
    assert temperature_of({}, 3).tolist() == [1.0, 1.0, 1.0]
    assert temperature_of({"calibration": {"temperature": [1.0, 2.0]}}, 2).tolist() == [1.0, 2.0]
    for kept in ([1.0], [1.0, -1.0], "warm"):
        with pytest.raises(ValueError, match="expected a calibration"):
            temperature_of({"calibration": {"temperature": kept}}, 2)
