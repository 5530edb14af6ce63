"""What a table of errors shows of forecasters that say how sure they are."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from predictor.calibration import LEVEL
from predictor.modal_forecast import ModalForecast
from predictor.modal_metrics import (
    min_ade,
    min_fde,
    min_joint_ade,
    min_joint_fde,
    nll,
    region_mass,
)

MODES_COUNTED: Final = (1, 6, 20)
"""Numbers of most probable modes of which the best is taken, besides all that there are."""


def measures_of_modes(
    forecast: ModalForecast, future: NDArray[np.float64], errors: NDArray[np.float64]
) -> dict[str, NDArray[np.float64]]:
    """Metrics of a scene, (A,) or (A, F) each, by the names they have in a table.

    What is measured of the scene as a whole, `min_joint_...`, is repeated for each agent.

    Args:
        forecast: Of one world, without the W axis.
        future: (F, A, 2) true positions [m].
        errors: (M, F, A) distances of the modes from the truth, in the unit of the table.
    """
    modes, _, agents = errors.shape
    found = {
        "nll": nll(forecast, future).T,
        f"region_coverage@{LEVEL}": (region_mass(forecast, future).T <= LEVEL).astype(np.float64),
    }
    for k in sorted({min(k, modes) for k in (*MODES_COUNTED, modes)}):
        found[f"min_ade_{k}"], found[f"min_fde_{k}"] = min_ade(errors, k), min_fde(errors, k)
        if k == 1:
            continue  # then there is one future, joint or not
        found[f"min_joint_ade_{k}"] = np.full(agents, min_joint_ade(errors, k))
        found[f"min_joint_fde_{k}"] = np.full(agents, min_joint_fde(errors, k))
    return found
