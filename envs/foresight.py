"""What is forecast for whom the robots observe: freshly, or from when they were last seen."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envs.config import CrowdNavConfig
from envs.forecasters import Situation, WorldForecast, WorldForecaster
from envs.ghosts import Ghosts, Ways, along
from envs.tracker import Observed, Rows

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Outlook:
    """The next F frames of K observed pedestrians of R worlds; zero where a place is empty.

    Attributes:
        position: (R, K, F, 2) [m], world frame.
        radius: (R, K, F) within which 9 in 10 people are expected of their positions [m].
        modes: (R, K, M, F, 2) other ways that they may go, the likeliest first [m]; None where
            nobody asked for them.
        probability: (R, K, M) of the modes; None likewise.
        seconds: Wall-clock time that the forecaster took per world [s].
    """

    position: Floats
    radius: Floats
    modes: Floats | None
    probability: Floats | None
    seconds: float


class Foresight:
    """Asks the forecaster, and holds on to what it said of people who are now out of sight.

    How sure a forecast is depends on how many frames of history it was made from. The forecast of
    somebody unseen is the one made when the robot last saw them, from where it leads by now on;
    after its end they go straight on. Its radii are those of that many seconds ahead, so that they
    grow. Who was not forecast when last seen is forecast as if seen now, with the same wider radii.

    Attributes:
        ghosts: Forecasts of people out of sight; None if tracks end where sight does.
    """

    def __init__(self, config: CrowdNavConfig, worlds: int, forecaster: WorldForecaster):
        self._forecaster = forecaster
        self._steps_per_frame = config.policy_steps_per_frame
        self.ghosts: Ghosts | None = None
        if config.track_memory > 0.0:
            self.ghosts = Ghosts(
                worlds,
                paths=1 + config.modes_observed,
                frames=config.forecast_steps,
                steps_per_frame=config.policy_steps_per_frame,
            )

    def restart(self, rows: NDArray[np.intp]) -> None:
        """Forgets what was forecast in the worlds `rows`."""
        if self.ghosts is not None:
            self.ghosts.restart(rows)

    def outlook(
        self, rows: Rows, situation: Situation, observed: Observed, unseen: NDArray[np.int64]
    ) -> Outlook:
        """Forecasts the observed.

        Args:
            rows: Which worlds.
            situation: Their state.
            observed: Whom to forecast.
            unseen: (W, N) policy steps since people were last seen; looked at only with ghosts.
        """
        began = time.perf_counter()
        made = self._forecaster.forecast(situation)
        seconds = (time.perf_counter() - began) / len(situation.indices)
        ways, late = _chosen(made, situation, observed), None
        if self.ghosts is not None:
            since = observed.take(unseen[rows])
            now = observed.take(situation.history[:, -1])
            self.ghosts.remember(rows, unseen[rows] == 0, observed, now, ways)
            ways = self.ghosts.replace(rows, observed, since, ways)
            late = since / self._steps_per_frame
        radius = made.radius[np.maximum(ways.frames_seen - 1, 0)]  # (R, K, F)
        there = observed.valid[:, :, None]
        paths = ways.paths * there[..., None, None]
        return Outlook(
            position=paths[:, :, 0],
            radius=(radius if late is None else grown(radius, late)) * there,
            modes=None if made.modes is None else paths[:, :, 1:],
            probability=None if made.modes is None else ways.probability * there,
            seconds=seconds,
        )


def grown(radius: Floats, late: Floats) -> Floats:
    """Returns (R, K, F) radii of forecasts that were made `late` (R, K) frames ago.

    Between the radii (R, K, F) and beyond them they grow evenly.
    """
    frames = np.arange(1.0, radius.shape[-1] + 1.0) + late[..., None]
    curve = np.concatenate((np.zeros((*late.shape, 1)), radius), axis=-1)
    return along(curve[..., None], frames)[..., 0]


def _chosen(made: WorldForecast, situation: Situation, observed: Observed) -> Ways:
    """What is forecast freshly for the observed."""
    forecast = np.moveaxis(observed.take(made.position, axis=2), 2, 1)[:, :, None]
    frames_seen = observed.take(situation.valid.sum(axis=1))
    if made.modes is None or made.probability is None:
        nothing = np.zeros((*forecast.shape[:2], 0))
        return Ways(paths=forecast, probability=nothing, frames_seen=frames_seen)
    modes = np.moveaxis(observed.take(made.modes, axis=3), 3, 1)
    return Ways(
        paths=np.concatenate((forecast, modes), axis=2),
        probability=np.moveaxis(observed.take(made.probability, axis=2), 2, 1),
        frames_seen=frames_seen,
    )
