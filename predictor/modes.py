"""Several futures of each agent: a Gaussian mixture over paths, read from a network's latents.

Each of M modes is a path with a 2 x 2 covariance at every step, and has a probability (as in Y.
Chai et al., "MultiPath", 2019). The decoder reads latents and point forecast without sending
gradients back, so that modes can be added to a trained network and leave its point forecast as it
is. A mode belongs to one agent: the first mode of one and the first of another were not made to fit
together.

In the shapes: B agents, M modes, F forecast steps, N people, W worlds.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import torch
import torch.nn.functional as F  # noqa: N812
from numpy.typing import NDArray
from torch import Tensor, nn

WIDTH: Final = 256
"""Size of the decoder's layers."""
LEAST_DEVIATION: Final = 0.02
"""Least standard deviation along any direction [m]: no tracker locates a person better, and without
it the density of who stands still grows without limit."""
RELAXATION: Final = 0.1
"""Share of the regression loss that the modes that are not nearest to the truth divide."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ModalForecast:
    """Several futures of N people of W worlds, the most probable of each person first.

    In the frame of their worlds. A single world may stand without the W axis. Who was not asked for
    stays; who is not seen now is at 0.

    Attributes:
        position: (W, M, F, N, 2) positions [m].
        probability: (W, M, N), 1 in the sum over modes.
        covariance: (W, M, F, N, 2, 2) of the position about that of the mode [m^2].
    """

    position: NDArray[np.float64]
    probability: NDArray[np.float64]
    covariance: NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Modes:
    """What the decoder gives for B agents, in their frames [m].

    Attributes:
        path: (B, M, F, 2) positions.
        logits: (B, M) of the probabilities.
        factor: (B, M, F, 3) lower triangle (xx, yx, yy) of L in the covariance L L' + d^2 1, where
            d is `LEAST_DEVIATION`.
    """

    path: Tensor
    logits: Tensor
    factor: Tensor

    def covariance(self) -> Tensor:
        """(B, M, F, 2, 2) [m^2]; no eigenvalue is below `LEAST_DEVIATION` squared."""
        xx, xy, yy = self._entries()
        return torch.stack([xx, xy, xy, yy], dim=-1).unflatten(-1, (2, 2))

    def log_density(self, future: Tensor) -> Tensor:
        """(B, M, F) log density of each mode [nat, per m^2] at the (B, F, 2) true path."""
        xx, xy, yy = self._entries()
        a, _, c = self.factor.unbind(-1)
        least = LEAST_DEVIATION**2
        # as a sum of squares, which is not lost where the difference of products would be
        determinant = (a * c) ** 2 + least * (xx + yy - least)
        x, y = (future[:, None] - self.path).unbind(-1)
        distance = (yy * x**2 - 2.0 * xy * x * y + xx * y**2) / determinant
        return -0.5 * (distance + determinant.log()) - math.log(2.0 * math.pi)

    def _entries(self) -> tuple[Tensor, Tensor, Tensor]:
        a, b, c = self.factor.unbind(-1)
        least = LEAST_DEVIATION**2
        return a**2 + least, a * b, b**2 + c**2 + least


class ModeDecoder(nn.Module):
    """Modes as corrections of the point forecast.

    Args:
        inputs: Size of the flattened latents.
        modes: Number of modes (M).
        forecast_steps: Frames of a path (F).
    """

    def __init__(self, inputs: int, modes: int, forecast_steps: int) -> None:
        super().__init__()
        self.layers = nn.Sequential(
            nn.Linear(inputs + 2 * forecast_steps, WIDTH),
            nn.ReLU(),
            nn.Linear(WIDTH, WIDTH),
            nn.ReLU(),
        )
        self.logits = nn.Linear(WIDTH, modes)
        self.path = nn.Linear(WIDTH, modes * forecast_steps * 2)
        self.factor = nn.Linear(WIDTH, modes * forecast_steps * 3)
        self.shape = (modes, forecast_steps)

    def forward(self, latents: Tensor, path: Tensor) -> Modes:
        """Decode (B, L, C) latents and the (B, F, 2) point forecast; no gradient goes back."""
        latents, path = latents.detach().flatten(1), path.detach()
        read = self.layers(torch.cat([latents, path.flatten(1)], dim=1))  # (B, WIDTH)
        factor = self.factor(read).unflatten(1, (*self.shape, 3))
        return Modes(
            path=self.path(read).unflatten(1, (*self.shape, 2)) + path[:, None],
            logits=self.logits(read),
            factor=factor,
        )


def mode_loss(modes: Modes, future: Tensor) -> Tensor:
    """Negative log density of the mode nearest to the truth, and cross-entropy of choosing it.

    The nearest mode takes all but `RELAXATION` of the regression; the others divide that share, so
    that none is never trained (C. Rupprecht et al., "Learning in an Uncertain World", 2017).

    Args:
        modes: Of B agents.
        future: (B, F, 2) true path in the agent frame [m].
    """
    error = torch.linalg.vector_norm(modes.path.detach() - future[:, None], dim=-1).mean(-1)
    nearest = error.argmin(dim=1)  # (B,)
    count = error.shape[1]
    share = torch.full_like(error, RELAXATION / max(1, count - 1))
    share.scatter_(1, nearest[:, None], 1.0 - RELAXATION if count > 1 else 1.0)
    regression = -(share * modes.log_density(future).mean(-1)).sum(1).mean()
    return regression + F.cross_entropy(modes.logits, nearest)
