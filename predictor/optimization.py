"""One update of the weights: gradient, its clipping, the optimizer and its schedule."""

import math
from typing import Any

import torch
from torch import Tensor
from torch.optim.lr_scheduler import LRScheduler, OneCycleLR, StepLR

from predictor.config import TrainConfig
from predictor.networks import Network


class Optimization:
    """A network in training with all that its updates need.

    Args:
        network: What is trained, already on its device.
        training: How.
        batches: Batches in an epoch.
    """

    def __init__(self, network: Network, training: TrainConfig, batches: int) -> None:
        self.network = network
        self.gradient_clip = training.gradient_clip
        self.optimizer, self.scheduler = _optimizer(network, training, batches)

    def update(self, objective: Tensor, when: str) -> float:
        """Descend once along the gradient of `objective`.

        Args:
            objective: Scalar loss.
            when: For the error message.

        Returns:
            Norm of the gradient before it was clipped.

        Raises:
            FloatingPointError: Loss or gradient is not finite; the weights are as before.
        """
        _require_finite("loss", objective.item(), when)
        self.optimizer.zero_grad()
        objective.backward()  # type: ignore[no-untyped-call]
        norm = torch.nn.utils.clip_grad_norm_(self.network.parameters(), self.gradient_clip).item()
        _require_finite("gradient", norm, when)
        self.optimizer.step()
        self.scheduler.step()
        return norm

    def scalars(self, objective: float, norm: float) -> dict[str, float]:
        """What is worth watching, by name."""
        rate = self.scheduler.get_last_lr()[0]
        return {
            "train/loss": objective,
            "train/gradient_norm": norm,
            "train/learning_rate": float(rate),
        }

    def state(self) -> dict[str, Any]:
        """All that `load` needs to go on as if nothing had happened."""
        return {name: part.state_dict() for name, part in self._parts().items()}

    def load(self, state: dict[str, Any]) -> None:
        """Take over what `state` said."""
        for name, part in self._parts().items():
            part.load_state_dict(state[name])

    def _parts(self) -> dict[str, Any]:
        return {
            "network": self.network,
            "optimizer": self.optimizer,
            "scheduler": self.scheduler,
        }


def _require_finite(name: str, value: float, when: str) -> None:
    if not math.isfinite(value):
        raise FloatingPointError(
            f"expected a finite {name}, found {value} in {when}: "
            "lower learning_rate or gradient_clip"
        )


def _optimizer(
    network: Network, training: TrainConfig, batches: int
) -> tuple[torch.optim.Optimizer, LRScheduler]:
    """Optimizer, and the schedule that is stepped after each of the batches of an epoch."""
    rate = training.learning_rate
    if training.schedule == "step":
        adam = torch.optim.Adam(network.parameters(), lr=rate, fused=True)
        return adam, StepLR(adam, step_size=30 * batches, gamma=0.2)
    adamw = torch.optim.AdamW(network.parameters(), lr=rate, fused=True)
    return adamw, OneCycleLR(adamw, max_lr=rate, total_steps=training.epochs * batches)
