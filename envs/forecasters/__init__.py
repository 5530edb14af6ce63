"""Forecasters as the environment takes them: by tracks, by the ground as well, or by foresight."""

from envs.forecasters.choice import make_world_forecaster
from envs.forecasters.situation import Situation, WorldForecast, WorldForecaster

__all__ = ["Situation", "WorldForecast", "WorldForecaster", "make_world_forecaster"]
