"""Several futures of each agent: a Gaussian mixture over paths, read from a network's latents.

Each of M modes is a path with a 2 x 2 covariance at every step, and has a probability (as in Y.
Chai et al., "MultiPath", 2019). The decoder reads latents and point forecast without sending
gradients back, so that modes can be added to a trained network and leave its point forecast as it
is. A mode belongs to one agent: the first mode of one and the first of another were not made to fit
together.

In the shapes: B agents, M modes, F forecast steps.
"""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

WIDTH: Final = 256
"""Size of the decoder's layers."""
LEAST_DEVIATION: Final = 0.02
"""Least standard deviation along any direction [m]: no tracker locates a person better, and without
it the density of who stands still grows without limit."""
RELAXATION: Final = 0.05
"""Share of the distance that the modes that are not nearest to the truth divide."""


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
        return torch.stack([xx, xy, xy, yy], dim=-1).view(*xx.shape, 2, 2)

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

    def log_mixture(self, future: Tensor) -> Tensor:
        """(B, F) log density of the mixture of each step [nat, per m^2] at the true path."""
        weight = self.logits.log_softmax(dim=1)[..., None]  # (B, M, 1)
        return torch.logsumexp(weight + self.log_density(future), dim=1)

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


def ordered(
    modes: Modes,
) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.float32]]:
    """The modes of each agent, the most probable first.

    Returns:
        (B, M, F, 2) positions, (B, M) probabilities and (B, M, F, 2, 2) covariances.
    """
    order = modes.logits.argsort(dim=1, descending=True, stable=True)
    row = torch.arange(len(order), device=order.device)[:, None]
    return (
        modes.path[row, order].cpu().numpy(),
        modes.logits.double().softmax(dim=1)[row, order].cpu().numpy(),
        modes.covariance()[row, order].cpu().numpy(),
    )


def mode_loss(modes: Modes, future: Tensor) -> Tensor:
    """Distance of the nearest mode from the truth, and negative log density of the mixture there.

    The nearest mode takes all but `RELAXATION` of the distance; the others divide that share, so
    that none is left untrained (C. Rupprecht et al., "Learning in an Uncertain World", 2017). The
    density moves covariances and probabilities only: it would pull a path with a force that grows
    without limit where the covariance is small.

    Args:
        modes: Of B agents.
        future: (B, F, 2) true path in the agent frame [m].
    """
    error = torch.linalg.vector_norm(modes.path - future[:, None], dim=-1).mean(-1)  # (B, M)
    nearest = error.argmin(dim=1, keepdim=True)
    others = max(1, error.shape[1] - 1)
    share = torch.full_like(error, RELAXATION / others).scatter(1, nearest, 1.0 - RELAXATION)
    distance: Tensor = (share * error).sum(dim=1).mean()
    fixed = replace(modes, path=modes.path.detach())
    return distance - fixed.log_mixture(future).mean()
