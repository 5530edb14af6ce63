"""Forecasters as the environment takes them: by tracks, by the ground as well, or by foresight."""

from envs.forecasters.choice import make_world_forecaster
from envs.forecasters.situation import Situation, WorldForecaster

__all__ = ["Situation", "WorldForecaster", "make_world_forecaster"]
