"""What the robot remembers of whom it saw: positions by slot, cleared when the person changes."""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Scalar = TypeVar("Scalar", bound=np.generic)
Rows = slice | NDArray[np.intp]
"""Which of the W worlds: all of them as a slice (no copy), or some by index."""


class Tracker:
    """Keeps what was seen at the policy clock and hands it out at the frame clock.

    One column per slot of the world (a pedestrian, or the robot). A column whose id changes
    starts anew, so that no history ever jumps from one person to another.
    """

    def __init__(self, worlds: int, columns: int, *, history_steps: int, steps_per_frame: int):
        self._history_steps = history_steps
        self._steps_per_frame = steps_per_frame
        self._length = (history_steps - 1) * steps_per_frame + 1
        self._now = 0
        # Row `_now` of the ring is the present; all worlds share the pointer.
        self._position = np.zeros((self._length, worlds, columns, 2))
        self._seen = np.zeros((self._length, worlds, columns), dtype=np.bool_)
        self._ids = np.full((worlds, columns), -1, dtype=np.int64)

    def grow(self, columns: int) -> None:
        """Makes room for so many columns altogether; the new ones have seen nothing."""
        more = columns - self._ids.shape[1]
        self._position = np.pad(self._position, ((0, 0), (0, 0), (0, more), (0, 0)))
        self._seen = np.pad(self._seen, ((0, 0), (0, 0), (0, more)))
        self._ids = np.pad(self._ids, ((0, 0), (0, more)), constant_values=-1)

    def restart(
        self,
        rows: NDArray[np.intp],
        position: NDArray[np.float64],
        seen: NDArray[np.bool_],
        ids: NDArray[np.int64],
    ) -> None:
        """Forgets the worlds `rows` and takes (R, N) columns as their first frame."""
        self._seen[:, rows] = False
        self._position[self._now, rows] = np.where(seen[..., None], position, 0.0)
        self._seen[self._now, rows] = seen
        self._ids[rows] = ids

    def update(
        self, position: NDArray[np.float64], seen: NDArray[np.bool_], ids: NDArray[np.int64]
    ) -> None:
        """Takes the (W, N, 2) positions of the next policy step, `seen` and `ids` (W, N)."""
        changed = ids != self._ids
        if changed.any():
            self._seen[:, changed] = False
            np.copyto(self._ids, ids)
        self._now = (self._now + 1) % self._length
        np.multiply(position, seen[..., None], out=self._position[self._now])
        self._seen[self._now] = seen

    def history(self, rows: Rows) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Returns positions (R, T, N, 2) and valid (R, T, N), a frame apart, the last one now.

        Positions are 0 where not valid.
        """
        back = np.arange(self._history_steps - 1, -1, -1) * self._steps_per_frame
        ring = (self._now - back) % self._length
        seen = np.moveaxis(self._seen[ring][:, rows], 0, 1)
        position = np.moveaxis(self._position[ring][:, rows], 0, 1)
        return position * seen[..., None], seen


@dataclass(frozen=True, eq=False)
class Observed:
    """Whom each robot observes: K slots of its world, nearest first.

    Attributes:
        slot: (W, K) column of the pedestrian; 0 where the place is empty.
        valid: (W, K), whether the place holds a pedestrian.
        ids: (W, K) the pedestrian's id; -1 where the place is empty.
    """

    slot: NDArray[np.intp]
    valid: NDArray[np.bool_]
    ids: NDArray[np.int64]

    def take(self, values: NDArray[Scalar], axis: int = 1) -> NDArray[Scalar]:
        """Picks the observed columns of `values`, which has W first and slots at `axis`."""
        shape = [1] * values.ndim
        shape[0], shape[axis] = self.slot.shape
        return np.take_along_axis(values, self.slot.reshape(shape), axis=axis)

    def mask(self, columns: int) -> NDArray[np.bool_]:
        """Returns (W, `columns`), True for the observed pedestrians."""
        chosen = np.zeros((len(self.slot), columns), dtype=np.bool_)
        world, place = np.nonzero(self.valid)
        chosen[world, self.slot[world, place]] = True
        return chosen


def nearest(
    distance: NDArray[np.float64], seen: NDArray[np.bool_], ids: NDArray[np.int64], count: int
) -> Observed:
    """Chooses the `count` nearest columns that are seen; equal distances in order of the ids.

    Args:
        distance: (W, N) to the robot [m].
        seen: (W, N), whether the column may be chosen.
        ids: (W, N).
        count: K.
    """
    worlds = len(distance)
    order = np.lexsort((ids, np.where(seen, distance, np.inf)), axis=-1)[:, :count]
    slot = np.zeros((worlds, count), dtype=np.intp)
    valid = np.zeros((worlds, count), dtype=np.bool_)
    chosen_ids = np.full((worlds, count), -1, dtype=np.int64)
    width = order.shape[1]
    valid[:, :width] = np.take_along_axis(seen, order, axis=1)
    slot[:, :width] = np.where(valid[:, :width], order, 0)
    chosen_ids[:, :width] = np.take_along_axis(ids, order, axis=1)
    return Observed(slot=slot, valid=valid, ids=np.where(valid, chosen_ids, -1))
