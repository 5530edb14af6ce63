"""People out of sight go on as they were forecast when they were last seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envs.tracker import Observed, Rows

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Steps = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Ways:
    """Where K observed people of R worlds go, as far as somebody can tell.

    Attributes:
        paths: (R, K, P, F, 2) the forecast, and after it its modes [m].
        probability: (R, K, P - 1) of the modes.
        frames_seen: (R, K) frames of history that they were forecast from.
    """

    paths: Floats
    probability: Floats
    frames_seen: Steps


class Ghosts:
    """Remembers, for everybody seen, the forecast made then, and tells where it leads.

    P paths for each person, the forecast first and its modes after it. Who was seen but not
    observed then, because others were nearer, has none.
    """

    def __init__(self, worlds: int, *, paths: int, frames: int, steps_per_frame: int):
        """Prepares for P paths of F frames in each of W worlds; time is counted in steps."""
        self._steps_per_frame = steps_per_frame
        self._knots = np.zeros((worlds, 0, paths, frames + 1, 2))
        self._probability = np.zeros((worlds, 0, paths - 1))
        self._frames_seen = np.zeros((worlds, 0), dtype=np.int64)
        self._led = np.zeros((worlds, 0), dtype=np.bool_)

    def restart(self, rows: NDArray[np.intp]) -> None:
        """Forgets the worlds `rows`."""
        self._led[rows] = False

    def remember(
        self, rows: Rows, seen: Flags, observed: Observed, now: Floats, ways: Ways
    ) -> None:
        """Keeps the forecasts of who is seen now, and forgets older ones of theirs.

        Args:
            rows: Which worlds.
            seen: (R, N), who is seen.
            observed: Who is observed, and so was forecast.
            now: (R, K, 2) where they are [m].
            ways: Where they will be.
        """
        indices = np.arange(len(self._led))[rows]
        self._led[rows] = np.where(seen, False, self._led[rows])
        place, slot = np.nonzero(observed.valid & observed.take(seen))
        world, column = indices[place], observed.slot[place, slot]
        self._knots[world, column, :, 0] = now[place, slot, None]
        self._knots[world, column, :, 1:] = ways.paths[place, slot]
        self._probability[world, column] = ways.probability[place, slot]
        self._frames_seen[world, column] = ways.frames_seen[place, slot]
        self._led[world, column] = True

    def lead(self, rows: Rows, unseen: Steps) -> tuple[Flags, Floats]:
        """Returns who goes on by a forecast (R, N, 1), and where they are by now (R, N, 2).

        Args:
            rows: Which worlds.
            unseen: (R, N) steps since people were last seen.
        """
        self._grow(unseen.shape[1])
        led = self._led[rows] & (unseen > 0)
        since = unseen[..., None] / self._steps_per_frame
        return led[..., None], along(self._knots[rows][:, :, 0], since)[:, :, 0]

    def replace(self, rows: Rows, observed: Observed, unseen: Steps, ways: Ways) -> Ways:
        """Returns the ways of the observed with the ghosts' own in place of fresh ones.

        Args:
            rows: Which worlds.
            observed: Whose they are.
            unseen: (R, K) steps since they were last seen.
            ways: Fresh ones.
        """
        led = observed.take(self._led[rows]) & (unseen > 0)
        frames = np.arange(1.0, ways.paths.shape[3] + 1.0)
        later = frames + unseen[..., None] / self._steps_per_frame
        held = along(observed.take(self._knots[rows]), later[:, :, None])
        probability = observed.take(self._probability[rows])
        frames_seen = observed.take(self._frames_seen[rows])
        return Ways(
            paths=np.where(led[..., None, None, None], held, ways.paths),
            probability=np.where(led[..., None], probability, ways.probability),
            frames_seen=np.where(led, frames_seen, ways.frames_seen),
        )

    def _grow(self, columns: int) -> None:
        more = ((0, 0), (0, columns - self._led.shape[1]))
        self._knots = np.pad(self._knots, (*more, (0, 0), (0, 0), (0, 0)))
        self._probability = np.pad(self._probability, (*more, (0, 0)))
        self._frames_seen = np.pad(self._frames_seen, more)
        self._led = np.pad(self._led, more)


def along(knots: Floats, at: Floats) -> Floats:
    """Returns (..., T, C), where paths are at times counted in frames; after their end straight on.

    Args:
        knots: (..., S, C) of a path, a frame apart.
        at: (..., T) times since the first of them.
    """
    before = np.minimum(at.astype(np.intp), knots.shape[-2] - 2)
    first = np.take_along_axis(knots, before[..., None], axis=-2)
    after = np.take_along_axis(knots, before[..., None] + 1, axis=-2)
    return np.asarray(first + (at - before)[..., None] * (after - first))
