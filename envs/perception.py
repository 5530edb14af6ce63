"""What the robot makes of its surroundings: whom it sees, their tracks, and their forecasts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings import Picture
from envs.config import CrowdNavConfig
from envs.forecasters import Situation, WorldForecaster
from envs.foresight import Foresight, Outlook
from envs.robots import Robot
from envs.sensor import Detections, Sensor
from envs.track_filter import TrackFilter
from envs.tracker import Observed, Rows, Tracker, nearest
from envs.worlds import Worlds

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Percept:
    """What R robots perceive at one moment, world frame; K observed pedestrians, nearest first.

    Attributes:
        observed: Whom they observe.
        radius: (R, K) [m], 0 where the place is empty.
        history: (R, K, T, 2) a frame apart, the last one now; 0 where not valid.
        history_valid: (R, K, T).
        outlook: What is forecast for them; None without a forecaster.
    """

    observed: Observed
    radius: Floats
    history: Floats
    history_valid: NDArray[np.bool_]
    outlook: Outlook | None

    @property
    def forecast(self) -> Floats | None:
        """Positions (R, K, F, 2), 0 where the place is empty; None without a forecaster."""
        return None if self.outlook is None else self.outlook.position

    @property
    def forecast_seconds(self) -> float:
        """Wall-clock time that the forecaster took per world [s]."""
        return 0.0 if self.outlook is None else self.outlook.seconds


class Perception:
    """Sees, remembers and forecasts for W robots.

    Attributes:
        visible: (W, N), whom the robots see or, out of sight, still reckon with.
    """

    def __init__(
        self,
        config: CrowdNavConfig,
        worlds: int,
        robot: Robot,
        forecaster: WorldForecaster | None,
    ):
        self._config = config
        self._robot = robot
        self._foresight = None if forecaster is None else Foresight(config, worlds, forecaster)
        self.visible = np.zeros((worlds, 1), dtype=np.bool_)
        self._distance = np.zeros((worlds, 1))
        self._sensor = Sensor(config, worlds)
        self._filters = config.position_noise > 0.0 or config.track_memory > 0.0
        self._filter = TrackFilter(
            worlds, dt=config.policy_dt, noise=config.position_noise, memory=config.track_memory
        )
        self._people = self._make_tracker(worlds)
        self._robots = self._make_tracker(worlds)

    def restart(
        self, rows: NDArray[np.intp], worlds: Worlds, generators: Sequence[np.random.Generator]
    ) -> None:
        """Forgets the worlds `rows` and sees what is there now.

        Args:
            rows: (R,) which worlds.
            worlds: Where they are.
            generators: R sources of what the sensors get wrong.
        """
        crowd, robots = worlds.crowd, worlds.robots
        self._people.grow(crowd.columns)
        for world, generator in zip(rows.tolist(), generators, strict=True):
            self._sensor.restart(world, generator, worlds)
        self._filter.restart(rows)
        if self._foresight is not None:
            self._foresight.restart(rows)
        found = self._see(rows, worlds)
        self._people.restart(rows, found.position, found.seen, found.tracks)
        self._robots.restart(rows, robots.position[rows, None], *_one_column(len(rows)))

    def update(self, worlds: Worlds) -> None:
        """Sees what is there one policy step later."""
        found = self._see(slice(None), worlds)
        self._people.update(found.position, found.seen, found.tracks)
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
        if config.history_kept is not None:
            valid[:, : -config.history_kept] = False
        own = observed.take(history, axis=2)
        own_valid = observed.take(valid, axis=2) & observed.valid[:, None]
        return Percept(
            observed=observed,
            radius=observed.take(crowd.radius[rows]) * observed.valid,
            history=np.moveaxis(own * own_valid[..., None], 1, 2),
            history_valid=np.moveaxis(own_valid, 1, 2),
            outlook=self._outlook(rows, worlds, observed, history, valid, pictures),
        )

    def _outlook(
        self,
        rows: Rows,
        worlds: Worlds,
        observed: Observed,
        history: Floats,
        valid: NDArray[np.bool_],
        pictures: Mapping[int, Picture],
    ) -> Outlook | None:
        """Forecasts the observed."""
        if self._foresight is None:
            return None
        indices = np.arange(len(self.visible))[rows]
        robot_history, robot_valid = self._robots.history(rows)
        situation = Situation(
            indices=indices,
            worlds=worlds,
            robot=self._robot,
            history=history,
            valid=valid,
            robot_history=robot_history[:, :, 0],
            robot_valid=robot_valid[:, :, 0] & self._config.robot_visible,
            select=observed.mask(history.shape[2]),
            pictures=[pictures.get(world) for world in indices.tolist()],
        )
        return self._foresight.outlook(rows, situation, observed, self._filter.unseen)

    def _see(self, rows: Rows, worlds: Worlds) -> Detections:
        """Detects and tracks the people of the worlds `rows`."""
        found = self._sensor.detect(rows, worlds)
        if self._filters:
            ghosts = None if self._foresight is None else self._foresight.ghosts
            found = self._filter.update(rows, found, ghosts)
        if found.seen.shape[1] > self.visible.shape[1]:
            more = ((0, 0), (0, found.seen.shape[1] - self.visible.shape[1]))
            self.visible, self._distance = np.pad(self.visible, more), np.pad(self._distance, more)
        gap = found.position - worlds.robots.position[rows, None]
        self._distance[rows] = np.sqrt(gap[..., 0] ** 2 + gap[..., 1] ** 2)
        self.visible[rows] = found.seen
        return found

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
