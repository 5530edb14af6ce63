"""Forecasters of `predictor` in the environment: they see tracks and a picture of the ground."""

import numpy as np

from envs.forecasters.situation import Floats, Situation
from predictor.forecaster import Forecaster


class TrackForecaster:
    """Asks a forecaster of `predictor` once for all worlds; the robot is one of the neighbors."""

    def __init__(self, forecaster: Forecaster):
        self._forecaster = forecaster

    def restart(self, world: int, rng: np.random.Generator) -> None:
        """Has nothing to remember."""

    def forecast(self, situation: Situation) -> Floats:
        """Returns (R, F, N, 2) positions [m], as `WorldForecaster.forecast` says."""
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
        return forecast[:, :, :-1]
