"""What the robot makes of its surroundings: whom it sees, their tracks, and their forecasts."""

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings import Picture
from envs.config import CrowdNavConfig
from envs.tracker import Observed, Rows, Tracker, nearest
from envs.worlds import Worlds
from predictor.forecaster import Forecaster

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Percept:
    """What R robots perceive at one moment, world frame; K observed pedestrians, nearest first.

    Attributes:
        observed: Whom they observe.
        radius: (R, K) [m], 0 where the place is empty.
        history: (R, K, T, 2) a frame apart, the last one now; 0 where not valid.
        history_valid: (R, K, T).
        forecast: (R, K, F, 2), 0 where the place is empty; None without a forecaster.
        forecast_seconds: Wall-clock time that the forecaster took per world [s].
    """

    observed: Observed
    radius: Floats
    history: Floats
    history_valid: NDArray[np.bool_]
    forecast: Floats | None
    forecast_seconds: float


class Perception:
    """Sees, remembers and forecasts for W robots.

    Attributes:
        visible: (W, N), which pedestrians are there and within the sensor's range.
    """

    def __init__(self, config: CrowdNavConfig, worlds: int, forecaster: Forecaster | None):
        self._config = config
        self._forecaster = forecaster
        self.visible = np.zeros((worlds, 1), dtype=np.bool_)
        self._distance = np.zeros((worlds, 1))
        self._people = self._make_tracker(worlds)
        self._robots = self._make_tracker(worlds)

    def restart(self, rows: NDArray[np.intp], worlds: Worlds) -> None:
        """Forgets the worlds `rows` and sees what is there now."""
        crowd, robots = worlds.crowd, worlds.robots
        if crowd.columns > self.visible.shape[1]:
            self._people.grow(crowd.columns)
        self._see(worlds)
        self._people.restart(rows, crowd.position[rows], self.visible[rows], crowd.ids[rows])
        self._robots.restart(rows, robots.position[rows, None], *_one_column(len(rows)))

    def update(self, worlds: Worlds) -> None:
        """Sees what is there one policy step later."""
        self._see(worlds)
        self._people.update(worlds.crowd.position, self.visible, worlds.crowd.ids)
        self._robots.update(worlds.robots.position[:, None], *_one_column(len(self.visible)))

    def look(self, rows: Rows, worlds: Worlds, pictures: Mapping[int, Picture]) -> Percept:
        """Returns what the robots of `rows` perceive now, with fresh forecasts.

        Args:
            rows: Which worlds.
            worlds: Where they are; as it was when last seen.
            pictures: Of the ground, by world; none where the forecaster needs none.
        """
        config, crowd = self._config, worlds.crowd
        observed = nearest(
            self._distance[rows], self.visible[rows], crowd.ids[rows], config.pedestrians_observed
        )
        history, valid = self._people.history(rows)
        own = observed.take(history, axis=2)
        own_valid = observed.take(valid, axis=2) & observed.valid[:, None]
        forecast, seconds = self._forecast(rows, observed, history, valid, pictures)
        return Percept(
            observed=observed,
            radius=observed.take(crowd.radius[rows]) * observed.valid,
            history=np.moveaxis(own * own_valid[..., None], 1, 2),
            history_valid=np.moveaxis(own_valid, 1, 2),
            forecast=forecast,
            forecast_seconds=seconds,
        )

    def _forecast(
        self,
        rows: Rows,
        observed: Observed,
        history: Floats,
        valid: NDArray[np.bool_],
        pictures: Mapping[int, Picture],
    ) -> tuple[Floats | None, float]:
        """Forecasts (R, K, F, 2) for the observed, and the seconds that it took per world."""
        if self._forecaster is None:
            return None, 0.0
        select = observed.mask(history.shape[2])
        if self._config.robot_visible:
            history, valid, select = self._with_robot(rows, history, valid, select)
        shown = [pictures.get(int(world)) for world in np.arange(len(self.visible))[rows]]
        began = time.perf_counter()
        forecast = self._forecaster.forecast(
            history,
            valid,
            [None if picture is None else picture.image for picture in shown],
            [None if picture is None else picture.pixel_from_world for picture in shown],
            select,
        )  # (R, F, N, 2)
        seconds = (time.perf_counter() - began) / len(shown)
        chosen = np.moveaxis(observed.take(forecast, axis=2), 1, 2)
        return chosen * observed.valid[:, :, None, None], seconds

    def _with_robot(
        self, rows: Rows, history: Floats, valid: NDArray[np.bool_], select: NDArray[np.bool_]
    ) -> tuple[Floats, NDArray[np.bool_], NDArray[np.bool_]]:
        """Appends the robot as one more column: a neighbor, but nobody to forecast."""
        robot, robot_valid = self._robots.history(rows)
        nobody = np.zeros((len(select), 1), dtype=np.bool_)
        return (
            np.concatenate((history, robot), axis=2),
            np.concatenate((valid, robot_valid), axis=2),
            np.concatenate((select, nobody), axis=1),
        )

    def _see(self, worlds: Worlds) -> None:
        gap = worlds.crowd.position - worlds.robots.position[:, None]
        self._distance = np.sqrt(gap[..., 0] ** 2 + gap[..., 1] ** 2)
        self.visible = worlds.crowd.valid & (self._distance <= self._config.sensor_range)

    def _make_tracker(self, worlds: int) -> Tracker:
        return Tracker(
            worlds,
            1,
            history_steps=self._config.history_steps,
            steps_per_frame=self._config.policy_steps_per_frame,
        )


def _one_column(rows: int) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Seen and ids of robots, which never are out of their own sight and never change."""
    return np.ones((rows, 1), dtype=np.bool_), np.zeros((rows, 1), dtype=np.int64)
