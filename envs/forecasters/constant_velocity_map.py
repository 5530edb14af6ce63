"""Constant velocity that knows the walls: all walk on as before and stop where one stands."""

from dataclasses import replace

import numpy as np

from crowdsim.lidar import cast_rays
from envs.forecasters.situation import Floats, Situation, WorldForecast
from envs.forecasters.tracks import TrackForecaster
from predictor.constant_velocity import ConstantVelocityForecaster

ROOM = 0.25
"""Distance to the wall at which people stop [m]: the mean radius of a pedestrian."""


class ConstantVelocityMap:
    """The straight paths of constant velocity, cut off before the first wall on them."""

    def __init__(self, forecaster: ConstantVelocityForecaster):
        self._straight = TrackForecaster(forecaster)

    def restart(self, world: int, rng: np.random.Generator) -> None:
        """Has nothing to remember."""

    def forecast(self, situation: Situation) -> WorldForecast:
        """Forecasts as `WorldForecaster.forecast` says, with the radii of constant velocity."""
        straight = self._straight.forecast(situation)
        path = straight.position
        for row, world in enumerate(situation.indices.tolist()):
            segments = situation.worlds.running(world).scenario.map.segments
            chosen = np.flatnonzero(situation.select[row])
            if len(segments) > 0 and len(chosen) > 0:
                start = situation.history[row, -1, chosen]
                path[row][:, chosen] = stop_at_walls(segments, start, path[row][:, chosen])
        return replace(straight, position=path)


def stop_at_walls(segments: Floats, start: Floats, path: Floats) -> Floats:
    """Cuts straight paths off `ROOM` before the first wall.

    Args:
        segments: (S, 2, 2) walls [m].
        start: (P, 2) where the paths begin [m].
        path: (F, P, 2) points on straight lines from there [m].

    Returns:
        (F, P, 2) the points that are reached; the others are where the path was cut off [m].
    """
    offset = path - start
    reach = np.sqrt((offset**2).sum(axis=-1))  # (F, P)
    course = np.arctan2(offset[-1, :, 1], offset[-1, :, 0])
    longest = max(float(reach.max()) + ROOM, ROOM)
    free = np.maximum(cast_rays(segments, start, course, 1, longest)[:, 0] - ROOM, 0.0)
    share = np.divide(free, reach, out=np.ones_like(reach), where=reach > free)
    return np.asarray(start + share[..., None] * offset)
