"""Tracks from detections: an alpha-beta filter that also carries on people out of sight."""

import math

import numpy as np
from numpy.typing import NDArray

from envs.ghosts import Ghosts
from envs.sensor import Detections
from envs.tracker import Rows

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

RESTLESSNESS = 1.0
"""Standard deviation of people's acceleration that the filter expects [m/s^2]."""


class TrackFilter:
    """Smooths noisy positions, and carries on who is not detected.

    Who was forecast when last detected goes on by that forecast, everybody else at constant
    velocity.

    The gains of a long track are the steady ones of the Kalman filter for white acceleration
    (Kalata 1984, "The tracking index"), those of a young one the least-squares ones of a straight
    line through its detections. Without noise it hands detections on unchanged.

    Attributes:
        unseen: (W, N) updates since the last detection.
    """

    def __init__(self, worlds: int, *, dt: float, noise: float, memory: float):
        """Prepares tracks of `worlds` worlds.

        Args:
            worlds: W.
            dt: Time between two updates [s].
            noise: Standard deviation of measured coordinates [m].
            memory: How long a track goes on without a detection [s].
        """
        self._dt = dt
        self._alpha, self._beta = steady_gains(RESTLESSNESS * dt**2 / noise if noise else math.inf)
        self._patience = round(memory / dt)
        self._position = np.zeros((worlds, 0, 2))
        self._velocity = np.zeros((worlds, 0, 2))
        self._hits = np.zeros((worlds, 0), dtype=np.int64)
        self.unseen = np.zeros((worlds, 0), dtype=np.int64)
        self._tracks = np.zeros((worlds, 0), dtype=np.int64)

    def restart(self, rows: NDArray[np.intp]) -> None:
        """Forgets all tracks of the worlds `rows`."""
        self._hits[rows] = 0

    def update(self, rows: Rows, found: Detections, ghosts: Ghosts | None = None) -> Detections:
        """Returns the tracks of the worlds `rows` after one more detection.

        `seen` is True for all tracks that go on, detected or not; `ghosts` knows where earlier
        forecasts lead.
        """
        self._grow(found.seen.shape[1])
        hits = np.where(found.tracks == self._tracks[rows], self._hits[rows], 0)
        velocity = self._velocity[rows]
        unseen = np.where(found.seen, 0, self.unseen[rows] + 1)
        predicted = self._position[rows] + velocity * self._dt
        if ghosts is not None:
            led, lead = ghosts.lead(rows, unseen)
            velocity = np.where(led, (lead - self._position[rows]) / self._dt, velocity)
            predicted = np.where(led, lead, predicted)
        residual = np.where(found.seen[..., None], found.position - predicted, 0.0)
        alpha, beta = self._gains(hits)
        fresh = (hits == 0)[..., None]
        position = np.where(fresh, found.position, predicted + alpha * residual)
        alive = found.seen | ((hits > 0) & (unseen <= self._patience))
        self._position[rows] = position
        self._velocity[rows] = np.where(fresh, 0.0, velocity + beta / self._dt * residual)
        self._hits[rows] = np.where(alive, hits + found.seen, 0)
        self.unseen[rows] = unseen
        self._tracks[rows] = found.tracks
        return Detections(position, alive, found.tracks)

    def _gains(self, hits: NDArray[np.int64]) -> tuple[Floats, Floats]:
        """(R, N, 1) alpha and beta for the next detection of tracks with so many."""
        count = np.maximum(hits, 1)[..., None].astype(np.float64)
        spread = (count + 1.0) * (count + 2.0)
        young_alpha, young_beta = 2.0 * (2.0 * count + 1.0) / spread, 6.0 / spread
        return np.maximum(self._alpha, young_alpha), np.maximum(self._beta, young_beta)

    def _grow(self, columns: int) -> None:
        more = ((0, 0), (0, columns - self._hits.shape[1]))
        self._position = np.pad(self._position, (*more, (0, 0)))
        self._velocity = np.pad(self._velocity, (*more, (0, 0)))
        self._hits, self.unseen, self._tracks = (
            np.pad(values, more) for values in (self._hits, self.unseen, self._tracks)
        )


def steady_gains(tracking_index: float) -> tuple[float, float]:
    """Alpha and beta for a tracking index, sigma_acceleration dt^2 / sigma_position.

    Infinite, which is no noise, gives 1 and 1: detections are taken as they are.
    """
    if math.isinf(tracking_index):
        return 1.0, 1.0
    index = tracking_index
    damping = (4.0 + index - math.sqrt(8.0 * index + index**2)) / 4.0
    alpha = 1.0 - damping**2
    return alpha, min(2.0 * (2.0 - alpha) - 4.0 * math.sqrt(1.0 - alpha), 1.0)
