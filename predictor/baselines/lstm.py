"""LSTM baseline: reads the agent's displacements one by one, then walks on by its own forecasts.

In the shapes: B agents, T history steps, F forecast steps, E embedding, D hidden state.
"""

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from predictor.config import NetworkConfig


@dataclass(frozen=True, kw_only=True)
class LstmConfig(NetworkConfig):
    """What the LSTM is.

    Attributes:
        embedding: Size of an embedded displacement (E).
        hidden: Size of the hidden state (D).
    """

    neighbors: int = 1
    embedding: int = 32
    hidden: int = 64

    def __post_init__(self) -> None:
        super().__post_init__()
        self.require_no_map()
        self.require_counts("embedding", "hidden")


class Lstm(nn.Module):
    """Path of each agent from its own displacements.

    Args:
        config: What the network is.
    """

    def __init__(self, config: LstmConfig) -> None:
        super().__init__()
        self.config = config
        self.embedding = nn.Linear(2, config.embedding)
        self.cell = nn.LSTMCell(config.embedding, config.hidden)
        self.displacement = nn.Linear(config.hidden, 2)

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
        hidden = history.new_zeros(history.shape[0], self.config.hidden)
        state = hidden, torch.zeros_like(hidden)
        for step in range(1, history.shape[1]):
            both = (history_valid[:, step] & history_valid[:, step - 1])[:, None]  # (B, 1)
            read = self._read(history[:, step] - history[:, step - 1], state)
            state = torch.where(both, read[0], state[0]), torch.where(both, read[1], state[1])
        path = self._walk_on(state, last_step)
        return path[:, -1], path

    def _read(self, displacement: Tensor, state: tuple[Tensor, Tensor]) -> tuple[Tensor, Tensor]:
        after: tuple[Tensor, Tensor] = self.cell(torch.relu(self.embedding(displacement)), state)
        return after

    def _walk_on(self, state: tuple[Tensor, Tensor], last_step: Tensor) -> Tensor:
        """Add up the displacements that the state tells, each read again: (B, F, 2)."""
        kept = last_step if self.config.residual else torch.zeros_like(last_step)
        displacements = []
        for _ in range(self.config.forecast_steps):
            displacements.append(kept + self.displacement(state[0]))
            state = self._read(displacements[-1], state)
        return torch.stack(displacements, dim=1).cumsum(dim=1)
