"""Forecasts averaged with those of the mirrored world: what is seen on the left, and on the right.

A network trained on mirrored windows is nearly, but not quite, the same for both sides; the mean of
both is, and is better, for twice the time.
"""

import torch
from torch import Tensor, nn

from predictor.networks import Network
from predictor.onnx_network import OnnxNetwork


class Mirrored(nn.Module):
    """The mean of a network's forecasts for the agents, and for the agents mirrored.

    Args:
        network: Whose forecasts.
    """

    flip: Tensor

    def __init__(self, network: Network | OnnxNetwork) -> None:
        super().__init__()
        self.network = network
        self.config = network.config
        self.register_buffer("flip", torch.tensor([1.0, -1.0]), persistent=False)

    def forward(self, **inputs: Tensor) -> tuple[Tensor, Tensor]:
        """Goal (B, 2) and path (B, F, 2); the arguments are those of the network."""
        goal, path = self.network(**inputs)
        mirrored_goal, mirrored_path = self.network(**self._mirrored(inputs))
        return (
            0.5 * (goal + mirrored_goal * self.flip),
            0.5 * (path + mirrored_path * self.flip),
        )

    def _mirrored(self, inputs: dict[str, Tensor]) -> dict[str, Tensor]:
        """What the agents would see if left were right."""
        mirrored = dict(inputs)
        for name in ("history", "neighbors", "last_step"):
            mirrored[name] = inputs[name] * self.flip
        if "crop" in inputs:
            mirrored["crop"] = inputs["crop"].flip(1)  # the agent looks along the middle row
        return mirrored
