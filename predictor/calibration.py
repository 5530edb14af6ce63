"""How far a forecast may be off: split-conformal radii and scaled covariances, for each step.

The radius of a step is the quantile of the validation errors that holds the error of one more
window with probability `LEVEL`, if that window is drawn like those (J. Lei et al.,
"Distribution-Free Predictive Inference for Regression", 2018). Windows overlap and other places
differ, so how often it does hold is measured wherever forecasts are evaluated (`coverage@0.9`).

Covariances of modes are scaled by one factor for each step, the temperature with which the smallest
regions that hold `LEVEL` of the mixture held `LEVEL` of the truths on validation.
"""

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from predictor.modal_forecast import ModalForecast, scaled
from predictor.modal_metrics import region_mass

LEVEL: Final = 0.9
SIGMAS: Final = math.sqrt(-2.0 * math.log(1.0 - LEVEL))
"""Radius that holds `LEVEL` of a round normal distribution, in its standard deviations: 2.146."""
TEMPERED_WINDOWS: Final = 4000
"""At most so many windows tell the temperatures: regions are dear."""
TEMPERATURE_RANGE: Final = (1.0 / 16.0, 16.0)
BISECTIONS: Final = 9
"""Halve this range, on a logarithmic scale, down to one per cent."""


def conformal_radius(errors: NDArray[np.float64], level: float = LEVEL) -> NDArray[np.float64]:
    """(F,) radii [m] from (M, F) errors [m]; the largest error where M is too small for `level`."""
    rank = min(math.ceil((len(errors) + 1) * level), len(errors))
    return np.asarray(np.sort(errors, axis=0)[rank - 1])


def calibration(errors: NDArray[np.float64]) -> dict[str, Any]:
    """What a checkpoint keeps of (M, F) validation errors [m], JSON-able."""
    radius = conformal_radius(errors)
    return {"coverage": LEVEL, "radius": radius.tolist(), "windows": len(errors)}


def nll_of_radius(errors: NDArray[np.float64], radius: NDArray[np.float64]) -> NDArray[np.float64]:
    """Negative log density [nat] at the truth of forecasts that are sure of nothing but radii.

    Their density, per square metre, is that of the round normal distribution that has `LEVEL`
    within the radius.

    Args:
        errors: (...) distances of the truth from the forecast positions [m].
        radius: (...) of `LEVEL` [m]; one of 0 is no distribution, and gives NaN.
    """
    variance = np.where(radius > 0.0, radius / SIGMAS, np.nan) ** 2
    return np.asarray(np.log(2.0 * np.pi * variance) + errors**2 / (2.0 * variance))


def temperatures(forecast: ModalForecast, future: NDArray[np.float64]) -> NDArray[np.float64]:
    """(F,) factors on the covariances of each step with which regions of `LEVEL` hold that much.

    Args:
        forecast: Of M validation windows, as if they were the people of one world.
        future: (F, M, 2) true positions in the same frame [m].
    """
    steps, windows = future.shape[:2]
    rows = np.linspace(0, windows - 1, min(windows, TEMPERED_WINDOWS)).astype(np.int64)
    few, true = forecast.of_people(rows), future[:, rows]
    low, high = (np.full(steps, end) for end in TEMPERATURE_RANGE)
    for _ in range(BISECTIONS):
        middle = np.sqrt(low * high)
        held = (region_mass(scaled(few, middle), true) <= LEVEL).mean(axis=1)
        low, high = np.where(held < LEVEL, middle, low), np.where(held < LEVEL, high, middle)
    return np.asarray(np.sqrt(low * high))


def radius_of(
    about: dict[str, Any], history_steps: int, forecast_steps: int
) -> NDArray[np.float64] | None:
    """The radii [m] that the description of a checkpoint holds; None without calibration.

    Returns:
        (T, F), in row k of people seen in k + 1 frames, for the frames that the network was
        trained for; all rows alike where short histories were not measured
        (`predictor.recalibration`). Where rolled forecasts were measured too, (T, R) with those of
        the frames beyond. These come from people who stayed longer, and are not let fall below
        those of earlier frames.

    Raises:
        ValueError: They are not F positive numbers for `LEVEL`, or not positive beyond or of the
            T - 1 shorter histories.
    """
    kept = about.get("calibration")
    if kept is None:
        return None
    try:
        radius, level = np.array(kept["radius"], dtype=np.float64), kept["coverage"]
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(
            f"expected a calibration with coverage and radius, found {kept}"
        ) from error
    if level != LEVEL or radius.shape != (forecast_steps,) or not (radius >= 0.0).all():
        raise ValueError(
            f"expected a calibration of {forecast_steps} radii for coverage {LEVEL}, found {kept}"
        )
    table = np.tile(radius, (history_steps, 1))
    if "short" in kept:
        table[:-1] = _of_short(kept["short"], (history_steps - 1, forecast_steps))
    return table if "rolled" not in kept else _with_rolled(table, kept["rolled"])


def _of_short(short: Any, shape: tuple[int, int]) -> NDArray[np.float64]:
    """(T - 1, F) radii of histories shorter than T."""
    try:
        radius = np.array(short["radius"], dtype=np.float64)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"expected the radii of short histories, found {short}") from error
    if radius.shape != shape or not (radius >= 0.0).all():
        raise ValueError(
            f"expected positive radii of short histories shaped {shape}, found {short}"
        )
    return radius


def _with_rolled(table: NDArray[np.float64], rolled: Any) -> NDArray[np.float64]:
    """(T, R) radii of which the first F are those of a single pass."""
    steps = table.shape[1]
    try:
        measured = np.array(rolled["radius"], dtype=np.float64)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"expected the radii of rolled forecasts, found {rolled}") from error
    if measured.ndim == 1:  # older checkpoints: from the whole history only
        measured = np.tile(measured, (len(table), 1))
    if measured.ndim != 2 or len(measured) != len(table) or not (measured >= 0.0).all():
        raise ValueError(f"expected positive radii of rolled forecasts, found {rolled}")
    longer = np.concatenate([table, measured[:, steps:]], axis=1)
    longer[:, steps - 1 :] = np.maximum.accumulate(longer[:, steps - 1 :], axis=1)
    return longer


def temperature_of(about: dict[str, Any], forecast_steps: int) -> NDArray[np.float64]:
    """The (F,) factors on covariances that the description of a checkpoint holds; 1 without.

    Raises:
        ValueError: They are not F positive numbers.
    """
    kept = about.get("calibration")
    if not isinstance(kept, dict) or "temperature" not in kept:
        return np.ones(forecast_steps)
    try:
        temperature = np.array(kept["temperature"], dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"expected a calibration with temperatures, found {kept}") from error
    if temperature.shape != (forecast_steps,) or not (temperature > 0.0).all():
        raise ValueError(
            f"expected a calibration of {forecast_steps} temperatures, found {temperature.tolist()}"
        )
    return temperature
