"""What happens in some steps of a world, step by step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Passage(NamedTuple):
    """S steps in a row.

    Attributes:
        states: `(S + 1, M, 4)` x, y, vx, vy of the N pedestrians, then perhaps the robot, before
            the first step and after each.
        clearances: `(S + 1, 2)` gaps between the robot and the nearest pedestrian, and wall [m];
            infinite without.
    """

    states: FloatArray
    clearances: FloatArray

    @classmethod
    def of(cls, steps: int, bodies: int) -> Passage:
        """Make room for so many steps of so many bodies."""
        return cls(np.empty((steps + 1, bodies, 4)), np.empty((steps + 1, 2)))

    @classmethod
    def joined(cls, passages: Sequence[Passage]) -> Passage:
        """Those that follow each other as one."""
        return cls(
            np.concatenate([passages[0].states, *(later.states[1:] for later in passages[1:])]),
            np.concatenate([passages[0].clearances, *(p.clearances[1:] for p in passages[1:])]),
        )

    def note(self, steps: int, bodies: FloatArray, clearances: tuple[float, float]) -> None:
        """Take down how it is after so many steps."""
        self.states[steps] = bodies
        self.clearances[steps] = clearances
