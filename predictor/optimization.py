"""One update of the weights: gradient, its clipping, the optimizer and its schedule."""

import math
from typing import Any

import torch
from torch import Tensor
from torch.optim.lr_scheduler import LRScheduler, OneCycleLR, StepLR

from predictor.config import TrainConfig
from predictor.distributed import ALONE, Processes
from predictor.networks import Network


class Optimization:
    """A network in training with all that its updates need.

    Args:
        network: What is trained, already on its device.
        training: How.
        batches: Batches in an epoch.
        processes: Who trains the same network on other rows of each batch.
    """

    def __init__(
        self,
        network: Network,
        training: TrainConfig,
        batches: int,
        processes: Processes = ALONE,
    ) -> None:
        self.network = network
        self.processes = processes
        self.gradient_clip = training.gradient_clip
        self.optimizer, self.scheduler = _optimizer(network, training, batches)

    def update(self, objective: Tensor, when: str) -> dict[str, float]:
        """Descend once along the gradient of `objective`, added up over the processes.

        Args:
            objective: Scalar loss, or this process's share of it.
            when: For the error message.

        Returns:
            What is worth watching, by name: loss, learning rate, and norm of the gradient before
            it was clipped.

        Raises:
            FloatingPointError: Loss or gradient is not finite; the weights are as before.
        """
        self.optimizer.zero_grad()
        objective.backward()  # type: ignore[no-untyped-call]
        loss = objective.detach().clone()
        gradients = [p.grad for p in self.network.parameters() if p.grad is not None]
        self.processes.add_up([loss, *gradients])
        _require_finite("loss", loss.item(), when)
        norm = torch.nn.utils.clip_grad_norm_(self.network.parameters(), self.gradient_clip).item()
        _require_finite("gradient", norm, when)
        self.optimizer.step()
        self.scheduler.step()
        return {
            "train/loss": loss.item(),
            "train/gradient_norm": norm,
            "train/learning_rate": float(self.scheduler.get_last_lr()[0]),
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
            "lower learning_rate or gradient_clip of its TrainConfig"
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
