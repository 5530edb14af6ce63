"""Which forecaster an environment uses, by name."""

from envs.config import CrowdNavConfig
from envs.forecasters.constant_velocity_map import ConstantVelocityMap
from envs.forecasters.oracle import NOISY_ORACLE, Blur, NoisyOracle, Oracle
from envs.forecasters.situation import WorldForecaster
from envs.forecasters.social_force import (
    PARAMETERS,
    SocialForceBetweenWalls,
    SocialForceForecaster,
)
from envs.forecasters.tracks import TrackForecaster
from predictor.constant_velocity import ConstantVelocityForecaster
from predictor.forecaster import Forecaster, make_forecaster, steps_of


def make_world_forecaster(config: CrowdNavConfig) -> WorldForecaster | None:
    """Returns the forecaster that `config.forecaster` names, None for `none`.

    Raises:
        ValueError: An unknown name, a bad value, or a forecaster with other frames than `config`.
        FileNotFoundError: A checkpoint that is not there.
    """
    forecaster = _named(config)
    if config.modes_observed > 0 and not isinstance(forecaster, TrackForecaster):
        raise ValueError(
            f"modes_observed needs a forecaster with modes, got forecaster {config.forecaster!r}"
        )
    return forecaster


def _named(config: CrowdNavConfig) -> WorldForecaster | None:
    spec = config.forecaster
    if not isinstance(spec, str):
        return TrackForecaster(_checked(spec, config), modes=config.modes_observed)
    if spec == "oracle":
        return Oracle(config)
    if spec.startswith(f"{NOISY_ORACLE}@"):
        return NoisyOracle(Oracle(config), Blur.parse(spec), config.frame_dt)
    if spec in PARAMETERS:
        return SocialForceBetweenWalls(
            SocialForceForecaster(
                spec,
                forecast_steps=config.forecast_steps,
                history_steps=config.history_steps,
                frame_dt=config.frame_dt,
            )
        )
    if spec == "constant_velocity_map":
        return ConstantVelocityMap(
            ConstantVelocityForecaster(
                forecast_steps=config.forecast_steps,
                history_steps=config.history_steps,
                frame_dt=config.frame_dt,
            )
        )
    forecaster = make_forecaster(spec, horizon=config.horizon)
    if forecaster is None:
        return None
    return TrackForecaster(_checked(forecaster, config), modes=config.modes_observed)


def make_track_forecaster(spec: str, *, horizon: float = 4.8) -> Forecaster | None:
    """Returns what `predictor.forecaster.make_forecaster` does, or one by the social force.

    Raises:
        ValueError: An unknown name, a bad value, or a damaged checkpoint.
        FileNotFoundError: A checkpoint that is not there.
    """
    if spec in PARAMETERS:
        return SocialForceForecaster(spec, forecast_steps=steps_of(horizon))
    return make_forecaster(spec, horizon=horizon)


def _checked(forecaster: Forecaster, config: CrowdNavConfig) -> Forecaster:
    if not isinstance(forecaster, Forecaster):
        raise ValueError(
            f"forecaster must be a name, the path of a checkpoint or a Forecaster, got {forecaster}"
        )
    for name in ("frame_dt", "history_steps", "forecast_steps"):
        expected, found = getattr(forecaster, name), getattr(config, name)
        if found != expected:
            raise ValueError(
                f"{name} must be {expected} for the forecaster {forecaster.name}, got {found}"
            )
    return forecaster
