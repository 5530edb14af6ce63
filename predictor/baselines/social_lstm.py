"""Social-LSTM: an LSTM for each person that reads the pooled hidden states of those around it.

A. Alahi, K. Goel, V. Ramanathan, A. Robicquet, L. Fei-Fei, S. Savarese, "Social LSTM: Human
Trajectory Prediction in Crowded Spaces", CVPR 2016: hidden states are summed in the cells of a grid
around each person (equations 1 to 3). Two things differ: the people are the agent and its K nearest
neighbors, and a displacement is forecast and scored by its distance instead of a Gaussian.

In the shapes: B agents, P = 1 + K people, T history steps, F forecast steps, E embedding, D hidden
state, G cells.
"""

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from predictor.config import NetworkConfig


@dataclass(frozen=True, kw_only=True)
class SocialLstmConfig(NetworkConfig):
    """What Social-LSTM is.

    Attributes:
        neighbors: People besides the agent (K). The grid reaches 2 m, where more are rare; each
            costs as much as the agent.
        embedding: Size of an embedded displacement, and of an embedded grid (E).
        hidden: Size of the hidden state (D).
        grid: Cells along one side of the grid.
        cell_side: Side of one cell [m].
    """

    neighbors: int = 4
    embedding: int = 32
    hidden: int = 64
    grid: int = 4
    cell_side: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self.require_no_map()
        self.require_counts("embedding", "hidden", "grid")
        if not 0.0 < self.cell_side < 100.0:
            raise ValueError(f"cell_side must be in (0, 100) m, got {self.cell_side}")


class SocialLstm(nn.Module):
    """Path of each agent from its own history and from the hidden states around it.

    Args:
        config: What the network is.
    """

    def __init__(self, config: SocialLstmConfig) -> None:
        super().__init__()
        self.config = config
        self.embedding = nn.Linear(2, config.embedding)
        self.pooling = nn.Linear(config.hidden, config.grid**2 * config.embedding, bias=False)
        self.pooling_bias = nn.Parameter(torch.zeros(config.embedding))
        self.cell = nn.LSTMCell(2 * config.embedding, config.hidden)
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
        everyone = torch.cat([history[:, None], neighbors], dim=1)  # (B, P, T, 2)
        valid = torch.cat([history_valid[:, None], neighbors_valid], dim=1)  # (B, P, T)
        hidden = history.new_zeros(*everyone.shape[:2], self.config.hidden)
        state = hidden, torch.zeros_like(hidden)
        kept = torch.zeros_like(everyone[:, :, 0])  # (B, P, 2)
        for step in range(1, everyone.shape[2]):
            both = valid[:, :, step] & valid[:, :, step - 1]
            displacement = everyone[:, :, step] - everyone[:, :, step - 1]
            kept = torch.where(both[..., None], displacement, kept)
            state = self._read(everyone[:, :, step], displacement, both, state)
        kept = torch.cat([last_step[:, None], kept[:, 1:]], dim=1)
        path = self._walk_on(everyone[:, :, -1], kept, valid[:, :, -1], state)
        return path[:, -1], path

    def _read(
        self,
        position: Tensor,
        displacement: Tensor,
        valid: Tensor,
        state: tuple[Tensor, Tensor],
    ) -> tuple[Tensor, Tensor]:
        """One step of everyone's LSTM; the state of who is not `valid` (B, P) stays."""
        pooled = self._pool(position, valid, state[0])  # (B, P, E)
        read = torch.relu(torch.cat([self.embedding(displacement), pooled], dim=-1))
        flat = state[0].flatten(0, 1), state[1].flatten(0, 1)
        hidden, memory = (after.view_as(state[0]) for after in self.cell(read.flatten(0, 1), flat))
        there = valid[..., None]
        return torch.where(there, hidden, state[0]), torch.where(there, memory, state[1])

    def _pool(self, position: Tensor, valid: Tensor, hidden: Tensor) -> Tensor:
        """Embed the sums of the others' hidden states (B, P, D) in each cell: (B, P, E).

        The embedding is linear, so each person's share of it is added up instead of its state.
        """
        grid, people = self.config.grid, position.shape[1]
        offset = position[:, None] - position[:, :, None]  # (B, P, P, 2), row sees column
        cell = torch.floor(offset / self.config.cell_side + 0.5 * grid)  # (B, P, P, 2)
        others = ~torch.eye(people, dtype=torch.bool, device=position.device)
        inside = ((cell >= 0) & (cell < grid)).all(dim=-1) & valid[:, None] & others
        number = torch.where(inside, cell[..., 1] * grid + cell[..., 0], -1.0)
        cells = torch.arange(grid**2, device=position.device)
        occupied = (number[..., None] == cells).to(hidden).flatten(2)  # (B, P, P G)
        shares = self.pooling(hidden).unflatten(2, (grid**2, -1)).flatten(1, 2)  # (B, P G, E)
        pooled: Tensor = occupied @ shares + self.pooling_bias
        return pooled

    def _walk_on(
        self, position: Tensor, kept: Tensor, valid: Tensor, state: tuple[Tensor, Tensor]
    ) -> Tensor:
        """Walk everyone on by the displacements that their states tell: the agent's (B, F, 2)."""
        kept = kept if self.config.residual else torch.zeros_like(kept)
        path = []
        for _ in range(self.config.forecast_steps):
            displacement = kept + self.displacement(state[0])  # (B, P, 2)
            position = position + displacement
            path.append(position[:, 0])
            state = self._read(position, displacement, valid, state)
        return torch.stack(path, dim=1)
