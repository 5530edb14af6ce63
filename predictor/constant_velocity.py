"""The baseline that stands in every table: everyone keeps the velocity of the last two frames."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from predictor.inputs import check_tracks, last_step


def constant_velocity(
    history: NDArray[np.float64], valid: NDArray[np.bool_], forecast_steps: int
) -> NDArray[np.float64]:
    """Continue the last displacement of everyone.

    Args:
        history: (..., T, N, 2) positions [m]; the last row is now.
        valid: (..., T, N) bool.
        forecast_steps: Number of frames F to forecast.

    Returns:
        (..., F, N, 2) positions in the frame of `history` [m]. Who has been seen only once stands.
    """
    step, _ = last_step(history, valid)
    ahead = np.arange(1, forecast_steps + 1)[:, None, None]
    return np.asarray(history[..., -1, None, :, :] + ahead * step[..., None, :, :])


class ConstantVelocityForecaster:
    """Constant velocity behind the interface of `predictor.forecaster.Forecaster`."""

    name = "constant_velocity"

    def __init__(
        self, *, forecast_steps: int = 12, history_steps: int = 8, frame_dt: float = 0.4
    ) -> None:
        self.forecast_steps = forecast_steps
        self.history_steps = history_steps
        self.frame_dt = frame_dt

    def forecast(
        self,
        history: NDArray[np.float64],
        valid: NDArray[np.bool_],
        map_images: Sequence[NDArray[np.uint8] | None] | NDArray[np.uint8] | None = None,
        pixel_from_world: Sequence[NDArray[np.float64] | None] | NDArray[np.float64] | None = None,
        select: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.float64]:
        """Forecast as `Forecaster.forecast` says; the map is not looked at."""
        check_tracks(history, valid, select)
        asked = valid[..., -1, :] if select is None else select & valid[..., -1, :]
        seen = np.where(valid[..., None], history, 0.0)
        path = constant_velocity(seen, valid, self.forecast_steps)
        return np.where(asked[..., None, :, None], path, seen[..., -1, None, :, :])
