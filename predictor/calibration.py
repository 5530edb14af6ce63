"""How far a forecast may be off: split-conformal radii, one for each step.

The radius of a step is the quantile of the validation errors that holds the error of one more
window with probability `LEVEL`, if that window is drawn like those (J. Lei et al.,
"Distribution-Free Predictive Inference for Regression", 2018). Windows overlap and other places
differ, so how often it does hold is measured wherever forecasts are evaluated (`coverage@0.9`).
"""

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

LEVEL: Final = 0.9


def conformal_radius(errors: NDArray[np.float64], level: float = LEVEL) -> NDArray[np.float64]:
    """(F,) radii [m] from (M, F) errors [m]; the largest error where M is too small for `level`."""
    rank = min(math.ceil((len(errors) + 1) * level), len(errors))
    return np.asarray(np.sort(errors, axis=0)[rank - 1])


def calibration(errors: NDArray[np.float64]) -> dict[str, Any]:
    """What a checkpoint keeps of (M, F) validation errors [m], JSON-able."""
    radius = conformal_radius(errors)
    return {"coverage": LEVEL, "radius": radius.tolist(), "windows": len(errors)}


def radius_of(about: dict[str, Any], forecast_steps: int) -> NDArray[np.float64] | None:
    """The (F,) radii [m] that the description of a checkpoint holds; None without calibration.

    Raises:
        ValueError: They are not F positive numbers for `LEVEL`.
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
    return radius
