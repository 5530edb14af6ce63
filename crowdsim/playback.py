"""Recorded people as bodies that go exactly where they once went."""

from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.recordings.recording import Recording
from crowdsim.routes import park

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


class Playback:
    """Tracks of a recording, interpolated between its frames and exact at them.

    Attributes:
        goals: `(N, 2)` where each person was seen last [m].
    """

    STATE: ClassVar[tuple[str, ...]] = ()

    def __init__(self, recording: Recording, first_row: int, physics_dt: float) -> None:
        """Begin at a row of the recording.

        Raises:
            ValueError: if the recording's time step is no whole multiple of `physics_dt`.
        """
        self._steps_per_frame = round(recording.dt / physics_dt)
        if not np.isclose(self._steps_per_frame * physics_dt, recording.dt):
            raise ValueError(
                f"physics_dt: expected a whole part of the recording's {recording.dt} s, "
                f"found {physics_dt} s"
            )
        self._positions = np.ascontiguousarray(recording.positions[first_row:], dtype=np.float64)
        self._valid = np.ascontiguousarray(recording.valid[first_row:])
        self._dt = recording.dt
        last = len(recording.valid) - 1 - recording.valid[::-1].argmax(axis=0)  # (N,)
        self.goals: FloatArray = recording.positions[last, np.arange(len(last))]

    def place(self, step: int, bodies: FloatArray, present: BoolArray) -> None:
        """Put everybody where they were after so many physics steps.

        Who is missing in the next frame leaves after the last one in which they were seen.

        Args:
            step: physics steps since the first row.
            bodies: `(M, 4)`, the first N rows are changed in place.
            present: `(M,)`, likewise.
        """
        row, part = divmod(step, self._steps_per_frame)
        fraction = part / self._steps_per_frame
        _place(self._positions, self._valid, row, fraction, self._dt, bodies, present)


@njit(cache=True)
def _place(
    positions: FloatArray,
    valid: BoolArray,
    row: int,
    fraction: float,
    dt: float,
    bodies: FloatArray,
    present: BoolArray,
) -> None:
    for i in range(positions.shape[1]):
        seen = row < len(valid) and valid[row, i]
        seen_next = row + 1 < len(valid) and valid[row + 1, i]
        present[i] = seen and (seen_next or fraction == 0)
        if not present[i]:
            park(bodies, i)
            continue
        start = positions[row, i]
        end = positions[row + 1, i] if seen_next else start
        before = positions[row - 1, i] if row > 0 and valid[row - 1, i] else start
        stride = end - start if seen_next else start - before
        bodies[i, :2] = start + fraction * (end - start)
        bodies[i, 2:] = stride / dt
