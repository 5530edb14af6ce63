"""The baseline that stands in every table: everyone keeps the velocity of the last two frames."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from predictor.inputs import check_tracks, last_step

RADIUS: Final = (0.107, 0.262, 0.443, 0.646, 0.866, 1.097, 1.334, 1.583, 1.84, 2.111, 2.391, 2.679)
"""Split-conformal radii (`predictor.calibration`) after 0.4, 0.8 ... 4.8 s [m]. Measured on 91,805
windows of simulated crowds: `crowdnav generate --scenario mixed --hours 8 --seconds 24 --seed 1
--out runs/crowds8` and `python tests/validation/constant_velocity_radius.py runs/crowds8`."""
RADIUS_SEEN_ONCE: Final = (
    *(0.527, 1.048, 1.561, 2.071, 2.575, 3.073),
    *(3.567, 4.061, 4.549, 5.038, 5.526, 6.015),
)
"""The same of who was seen once and so is taken to stand: how far people get. The same windows."""
RADIUS_DT: Final = 0.4
"""Time between two of them [s]."""


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
    return _straight_on(history[..., -1, :, :], step, forecast_steps)


def calibrated_radius(times: NDArray[np.floating], history_steps: int) -> NDArray[np.float64]:
    """Radii that hold the truth in 9 of 10 cases, after so many frames of history.

    Between the times of `RADIUS` they are interpolated. After them they go on to grow as fast as
    they last did.

    Args:
        times: (F,) how far ahead [s].
        history_steps: Frames of history that a person may have been seen in (T).

    Returns:
        (T, F) radii [m], in row k of who was seen in k + 1 frames: only the first row differs, as
        more than two frames tell constant velocity nothing.
    """
    several = np.tile(_at_times(RADIUS, times), (history_steps - 1, 1))
    return np.concatenate([_at_times(RADIUS_SEEN_ONCE, times)[None], several])


def _at_times(radius: Sequence[float], times: NDArray[np.floating]) -> NDArray[np.float64]:
    """(F,) radii between those measured `RADIUS_DT` apart, and beyond them."""
    measured = np.array([0.0, *radius])
    growth = (measured[-1] - measured[-2]) / RADIUS_DT
    known = RADIUS_DT * np.arange(len(measured))
    within = np.interp(times, known, measured)
    return np.asarray(within + growth * np.maximum(times - known[-1], 0.0))


class ConstantVelocityForecaster:
    """Constant velocity behind the interface of `predictor.forecaster.CalibratedForecaster`."""

    name = "constant_velocity"

    def __init__(
        self, *, forecast_steps: int = 12, history_steps: int = 8, frame_dt: float = 0.4
    ) -> None:
        self.forecast_steps = forecast_steps
        self.history_steps = history_steps
        self.frame_dt = frame_dt
        self.radius: NDArray[np.float64] | None = calibrated_radius(
            frame_dt * np.arange(1.0, forecast_steps + 1.0), history_steps
        )

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
        step, _ = last_step(seen, valid)
        step = np.where(asked[..., None], step, 0.0)
        return _straight_on(seen[..., -1, :, :], step, self.forecast_steps)


def _straight_on(
    now: NDArray[np.float64], step: NDArray[np.float64], forecast_steps: int
) -> NDArray[np.float64]:
    """Paths (..., F, N, 2) from `now` (..., N, 2) with the displacement `step` per frame."""
    ahead = np.arange(1, forecast_steps + 1)[:, None, None]
    return np.asarray(now[..., None, :, :] + ahead * step[..., None, :, :])
