"""Forecasters of `predictor` in the environment: they see tracks and a picture of the ground."""

from typing import Any

import numpy as np

from envs.forecasters.situation import Floats, Situation, WorldForecast
from predictor.constant_velocity import calibrated_radius
from predictor.forecaster import CalibratedForecaster, Forecaster, ModalForecaster


class TrackForecaster:
    """Asks a forecaster of `predictor` once for all worlds; the robot is one of the neighbors.

    A forecaster whose errors nobody has measured gets the radii of constant velocity.
    """

    def __init__(self, forecaster: Forecaster, *, modes: int = 0):
        """Prepares to ask for the likeliest `modes` of everybody, too.

        Raises:
            ValueError: The forecaster does not know so many, or its radii are shaped wrongly.
        """
        self._forecaster = forecaster
        self._radius = radius_of(forecaster)
        self._modes = modes
        self._modal = forecaster if isinstance(forecaster, ModalForecaster) else None
        known = 0 if self._modal is None else self._modal.modes
        if modes > known:
            raise ValueError(
                f"modes_observed must be at most {known} for the forecaster {forecaster.name} "
                f"over {forecaster.forecast_steps} frames, got {modes}"
            )

    def restart(self, world: int, rng: np.random.Generator) -> None:
        """Has nothing to remember."""

    def forecast(self, situation: Situation) -> WorldForecast:
        """Forecasts as `WorldForecaster.forecast` says."""
        asked = _question(situation)
        if self._modes == 0 or self._modal is None:
            path = self._forecaster.forecast(*asked)  # (R, F, N + 1, 2)
            return WorldForecast(position=path[:, :, :-1], radius=self._radius)
        found = self._modal.forecast_modes(*asked)
        return WorldForecast(
            position=found.path[:, :, :-1],
            radius=self._radius,
            modes=found.position[:, : self._modes, :, :-1],
            probability=found.probability[:, : self._modes, :-1],
        )


def radius_of(forecaster: Forecaster) -> Floats:
    """Returns the calibrated radii (T, F) of a forecaster [m], or those of constant velocity.

    Raises:
        ValueError: Its radii are not shaped so.
    """
    if isinstance(forecaster, CalibratedForecaster) and forecaster.radius is not None:
        found = forecaster.radius.shape
        expected = (forecaster.history_steps, forecaster.forecast_steps)
        if found != expected:
            raise ValueError(
                f"radius must be shaped {expected} for the forecaster {forecaster.name}, a row for "
                f"each number of frames seen, got {found}"
            )
        return forecaster.radius
    times = forecaster.frame_dt * np.arange(1.0, forecaster.forecast_steps + 1.0)
    return calibrated_radius(times, forecaster.history_steps)


def _question(situation: Situation) -> tuple[Any, ...]:
    """The arguments of `Forecaster.forecast`, with the robot as the last column."""
    history = np.concatenate((situation.history, situation.robot_history[:, :, None]), axis=2)
    valid = np.concatenate((situation.valid, situation.robot_valid[:, :, None]), axis=2)
    nobody = np.zeros((len(history), 1), dtype=np.bool_)
    pictures = situation.pictures
    return (
        history,
        valid,
        [None if picture is None else picture.image for picture in pictures],
        [None if picture is None else picture.pixel_from_world for picture in pictures],
        np.concatenate((situation.select, nobody), axis=1),
    )
