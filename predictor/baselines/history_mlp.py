"""History-only baseline: a multilayer perceptron that sees nothing but the agent itself.

In the shapes: B agents, T history steps, F forecast steps.
"""

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from predictor.config import NetworkConfig
from predictor.tensors import start_path


@dataclass(frozen=True, kw_only=True)
class HistoryMlpConfig(NetworkConfig):
    """What the perceptron is.

    Attributes:
        hidden: Width of its two hidden layers.
    """

    neighbors: int = 1
    hidden: int = 256

    def __post_init__(self) -> None:
        super().__post_init__()
        self.require_no_map()
        self.require_counts("hidden")


class HistoryMlp(nn.Module):
    """Path of each agent from its own history alone.

    Args:
        config: What the network is.
    """

    def __init__(self, config: HistoryMlpConfig) -> None:
        super().__init__()
        self.config = config
        self.layers = nn.Sequential(
            nn.Linear(3 * config.history_steps, config.hidden),
            nn.ReLU(),
            nn.Linear(config.hidden, config.hidden),
            nn.ReLU(),
            nn.Linear(config.hidden, 2 * config.forecast_steps),
        )

    def forward(
        self,
        history: Tensor,
        history_valid: Tensor,
        neighbors: Tensor,
        neighbors_valid: Tensor,
        last_step: Tensor,
    ) -> tuple[Tensor, Tensor]:
        """Forecast in the agent frame [m]; the arguments are as in `AgentInputs`.

        Returns:
            (B, 2) goal, which is the last position of the path, and (B, F, 2) path.
        """
        seen = torch.cat([history.flatten(1), history_valid.to(history)], dim=1)  # (B, 3T)
        correction = self.layers(seen).unflatten(1, (-1, 2))  # (B, F, 2)
        path = correction + start_path(last_step, self.config)
        return path[:, -1], path
