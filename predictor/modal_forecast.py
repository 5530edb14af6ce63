"""Several futures of each person, as a forecaster hands them out: arrays only, free of torch.

In the shapes: W worlds, M modes, F forecast steps, N people, B agents.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True, eq=False)
class ModalForecast:
    """A mixture of M paths for each person, the most probable one first.

    At each step the position is distributed as the mixture of normal distributions about the
    positions of the modes. In the frames of the worlds. A single world may stand without the W
    axis. A mode belongs to one person: mode 0 of one and mode 0 of another are the most probable of
    each, and no more than that goes together. Who was not asked for stays, and who is not seen now
    is at 0: without doubt, with a covariance of 0 and modes that are equally probable.

    Attributes:
        path: (W, F, N, 2) the one forecast that a forecaster makes without modes [m].
        position: (W, M, F, N, 2) positions of the modes [m].
        probability: (W, M, N), 1 in the sum over modes.
        covariance: (W, M, F, N, 2, 2) of the position about that of the mode [m^2].
    """

    path: NDArray[np.float64]
    position: NDArray[np.float64]
    probability: NDArray[np.float64]
    covariance: NDArray[np.float64]

    def of_world(self, world: int) -> Self:
        """That of one world, without the W axis."""
        return type(self)(
            path=self.path[world],
            position=self.position[world],
            probability=self.probability[world],
            covariance=self.covariance[world],
        )

    def of_people(self, people: NDArray[np.int64]) -> Self:
        """That of some people of a single world: N becomes their number."""
        return type(self)(
            path=self.path[:, people],
            position=self.position[:, :, people],
            probability=self.probability[:, people],
            covariance=self.covariance[:, :, people],
        )

    def until(self, forecast_steps: int) -> Self:
        """The first so many frames of W worlds."""
        return replace(
            self,
            path=self.path[:, :forecast_steps],
            position=self.position[:, :, :forecast_steps],
            covariance=self.covariance[:, :, :forecast_steps],
        )

    def with_positions(self, changed: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> Self:
        """With (W, F, N, 2) paths `changed`, that of each mode as the one without modes."""
        modes = [changed(position) for position in self.position.swapaxes(0, 1)]
        return replace(self, path=changed(self.path), position=np.stack(modes, axis=1))


def scaled(forecast: ModalForecast, factor: NDArray[np.float64] | float) -> ModalForecast:
    """The same modes with covariances times a factor, or (F,) factors, one for each step."""
    by_step = np.reshape(factor, (-1, 1, 1, 1))
    return replace(forecast, covariance=forecast.covariance * by_step)


def standing(now: NDArray[np.float64], modes: int, forecast_steps: int) -> ModalForecast:
    """Everyone stays where (W, N, 2) they are."""
    worlds, people, _ = now.shape
    shape = (worlds, modes, forecast_steps, people)
    return ModalForecast(
        path=np.repeat(now[:, None], forecast_steps, axis=1),
        position=np.broadcast_to(now[:, None, None], (*shape, 2)).copy(),
        probability=np.full((worlds, modes, people), 1.0 / modes),
        covariance=np.zeros((*shape, 2, 2)),
    )


def covariance_in_world(
    covariance: NDArray[np.floating], world_from_agent: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Turn (B, M, F, 2, 2) covariances from the agent frames into the frames of their worlds.

    Written element by element: a matrix product would round differently in different batches.
    """
    axes = world_from_agent[:, None, None, :2, :2]
    cos, sin = axes[..., 0, 0], axes[..., 1, 0]
    exact = covariance.astype(np.float64)
    xx, xy, yy = exact[..., 0, 0], exact[..., 0, 1], exact[..., 1, 1]
    along = cos**2 * xx - 2.0 * cos * sin * xy + sin**2 * yy
    across = sin**2 * xx + 2.0 * cos * sin * xy + cos**2 * yy
    mixed = cos * sin * (xx - yy) + (cos**2 - sin**2) * xy
    return np.stack([along, mixed, mixed, across], axis=-1).reshape(exact.shape)
