"""How much of the error of closed-loop forecasts is the robot's own doing.

A forecast errs for two reasons: people would not have gone there anyway, and the robot made them go
elsewhere. The same crowd from the same moment on, with the robot taken out, tells them apart: with
the forecast f, the truth t and the twin's position a, |f - t| <= |f - a| + |a - t|, the model's own
error and the displacement that the robot has caused.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envs.evaluation.forecast_scores import ScoredForecasts, rows_ahead
from envs.trace import Trace, TwinTrace

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class RobotPart:
    """The parts of the errors of E forecasts over F steps; 0 where not `known`.

    Attributes:
        known: (E,), whether there are twins from that moment on, in which the person stays.
        model_error: (E, F) from the forecast to the person of the twin without a robot [m].
        displacement: (E, F) from that person to where they truly were [m].
        standing_displacement: (E, F) likewise, had the robot braked and stood [m].
    """

    known: NDArray[np.bool_]
    model_error: Floats
    displacement: Floats
    standing_displacement: Floats


def robot_part(trace: Trace, scored: ScoredForecasts) -> RobotPart:
    """Splits the errors of those forecasts that were made where the trace has branches."""
    known = np.zeros(len(scored.row), dtype=np.bool_)
    model_error, displacement, standing = np.zeros((3, *scored.error.shape))
    truth = trace.position[rows_ahead(trace, scored.row), scored.column[:, None]]
    for branch in trace.branches:
        chosen = np.flatnonzero(scored.row == branch.row)
        column = scored.column[chosen]
        who = trace.ids[branch.row, column]
        stays = _stays(branch.absent, column, who) & _stays(branch.standing, column, who)
        chosen, column = chosen[stays], column[stays]
        absent = branch.absent.position[:, column].swapaxes(0, 1)  # (C, F, 2)
        stood = branch.standing.position[:, column].swapaxes(0, 1)
        known[chosen] = True
        model_error[chosen] = np.linalg.norm(scored.position[chosen] - absent, axis=-1)
        displacement[chosen] = np.linalg.norm(truth[chosen] - absent, axis=-1)
        standing[chosen] = np.linalg.norm(stood - absent, axis=-1)
    return RobotPart(
        known=known,
        model_error=model_error,
        displacement=displacement,
        standing_displacement=standing,
    )


def _stays(twin: TwinTrace, column: NDArray[np.int64], who: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(C,), whether those people `who` (C,) are in their columns all the time."""
    there = twin.valid[:, column] & (twin.ids[:, column] == who)
    stays: NDArray[np.bool_] = there.all(axis=0)
    return stays
