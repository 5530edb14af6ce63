"""Forecasters of `predictor` in the environment: they see tracks and a picture of the ground."""

import numpy as np

from envs.forecasters.situation import Floats, Situation, WorldForecast
from predictor.forecaster import CalibratedForecaster, Forecaster

UNKNOWN_GROWTH = 0.45
"""Radius per second ahead of forecasts whose error nobody has measured [m/s]."""


class TrackForecaster:
    """Asks a forecaster of `predictor` once for all worlds; the robot is one of the neighbors."""

    def __init__(self, forecaster: Forecaster):
        self._forecaster = forecaster
        self._radius = radius_of(forecaster)

    def restart(self, world: int, rng: np.random.Generator) -> None:
        """Has nothing to remember."""

    def forecast(self, situation: Situation) -> WorldForecast:
        """Forecasts as `WorldForecaster.forecast` says."""
        history = np.concatenate((situation.history, situation.robot_history[:, :, None]), axis=2)
        valid = np.concatenate((situation.valid, situation.robot_valid[:, :, None]), axis=2)
        nobody = np.zeros((len(history), 1), dtype=np.bool_)
        pictures = situation.pictures
        forecast = self._forecaster.forecast(
            history,
            valid,
            [None if picture is None else picture.image for picture in pictures],
            [None if picture is None else picture.pixel_from_world for picture in pictures],
            np.concatenate((situation.select, nobody), axis=1),
        )  # (R, F, N + 1, 2)
        return WorldForecast(position=forecast[:, :, :-1], radius=self._radius)


def radius_of(forecaster: Forecaster) -> Floats:
    """Returns the calibrated radii (F,) of a forecaster [m], or a guess if it has none."""
    if isinstance(forecaster, CalibratedForecaster) and forecaster.radius is not None:
        return forecaster.radius
    return UNKNOWN_GROWTH * forecaster.frame_dt * np.arange(1.0, forecaster.forecast_steps + 1.0)
