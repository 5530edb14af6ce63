"""The network of "Conditioned Human Trajectory Prediction using Iterative Attention Blocks".

Learned latent vectors look again and again at the agent's own history, at its neighbors and at the
map; a goal is decoded from them first, then the path towards it. Everything is in the agent frame.

In the shapes: B agents, T history steps, F forecast steps, K neighbors, L latents, P patches,
C width, H heads, D = C / H.
"""

from typing import NamedTuple, Self

import torch
import torch.nn.functional as F  # noqa: N812
from torch import Tensor, nn

from predictor.backbones import BackboneEncoder
from predictor.config import ModelConfig
from predictor.modes import ModeDecoder, Modes
from predictor.position_codes import grid_code, sinusoidal_code
from predictor.tensors import start_path


class Attention(nn.Module):
    """Multi-head attention of B x L latents over tokens."""

    def __init__(self, config: ModelConfig) -> None:
        super().__init__()
        self.heads, self.dropout_rate = config.heads, config.dropout
        self.query = nn.Linear(config.width, config.width)
        self.key_value = nn.Linear(config.width, 2 * config.width)
        self.output = nn.Linear(config.width, config.width)

    def forward(self, latents: Tensor, tokens: Tensor, mask: Tensor | None = None) -> Tensor:
        """Read (B, S, C) tokens into (B, L, C); `mask` (B, 1, 1, S) is added to the scores."""
        query, key, value = self.project(latents, tokens)
        read = F.scaled_dot_product_attention(
            query,
            key,
            value,
            attn_mask=mask,
            dropout_p=self.dropout_rate if self.training else 0.0,
        )
        joined = self.output(read.transpose(1, 2).flatten(2))  # (B, L, C)
        return F.dropout(joined, self.dropout_rate, self.training)

    def project(self, latents: Tensor, tokens: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Queries (B, H, L, D) of latents (B, L, C), keys and values (B, H, S, D) of tokens."""
        b, n, c = latents.shape
        query = self.query(latents).view(b, n, self.heads, -1).transpose(1, 2)  # (B, H, L, D)
        key_value = self.key_value(tokens).view(b, -1, 2, self.heads, c // self.heads)
        key, value = key_value.permute(2, 0, 3, 1, 4)  # 2 x (B, H, S, D)
        return query, key, value


class Stream(NamedTuple):
    """Tokens to be read, and which of them may be: computed once for all blocks.

    Attributes:
        tokens: (B, S, C).
        mask: (B, 1, 1, S) added to the scores: 0, or -inf where a token is not valid. A softmax
            over nothing is NaN: where no token is valid, all are read, and dropped by `any_valid`.
        any_valid: (B, 1, 1) 1, or 0 where no token is valid.
    """

    tokens: Tensor
    mask: Tensor
    any_valid: Tensor

    @classmethod
    def of(cls, tokens: Tensor, valid: Tensor) -> Self:
        """Of (B, S, C) tokens, `valid` (B, S)."""
        any_valid = valid.any(dim=1, keepdim=True)  # (B, 1)
        mask = torch.zeros_like(valid, dtype=tokens.dtype).masked_fill(
            any_valid & ~valid, -torch.inf
        )
        return cls(tokens, mask[:, None, None], any_valid[:, :, None].to(tokens.dtype))


class CrossAttention(nn.Module):
    """What the latents read from one stream of tokens: nothing where no token is real."""

    def __init__(self, config: ModelConfig) -> None:
        super().__init__()
        self.norm = nn.LayerNorm(config.width)
        self.attention = Attention(config)

    def forward(self, latents: Tensor, stream: Stream) -> Tensor:
        """Add to (B, L, C) latents what they read from a stream of tokens."""
        read: Tensor = self.attention(self.norm(latents), stream.tokens, stream.mask)
        return latents + read * stream.any_valid


class EncoderBlock(nn.Module):
    """Cross-attention to history, neighbors and map, then a pre-norm transformer block."""

    def __init__(self, config: ModelConfig) -> None:
        super().__init__()
        self.streams = nn.ModuleDict({name: CrossAttention(config) for name in _streams(config)})
        self.attention_norm = nn.LayerNorm(config.width)
        self.attention = Attention(config)
        self.mlp_norm = nn.LayerNorm(config.width)
        self.mlp = nn.Sequential(
            nn.Linear(config.width, 4 * config.width),
            nn.GELU(),
            nn.Linear(4 * config.width, config.width),
            nn.Dropout(config.dropout),
        )

    def forward(self, latents: Tensor, streams: dict[str, Stream]) -> Tensor:
        """Refine (B, L, C) latents by streams of tokens."""
        for name, cross_attention in self.streams.items():
            latents = cross_attention(latents, streams[name])
        normed = self.attention_norm(latents)
        latents = latents + self.attention(normed, normed)
        refined: Tensor = latents + self.mlp(self.mlp_norm(latents))
        return refined


def _streams(config: ModelConfig) -> list[str]:
    people = ["history", "neighbors"] if config.tokens == "frame" else ["neighbors"]
    return people + (["map"] if config.variant != "none" else [])


class PoseEncoder(nn.Module):
    """Turns positions at time steps into tokens; shared by own history and neighbors."""

    time_code: Tensor

    def __init__(self, config: ModelConfig) -> None:
        super().__init__()
        self.mlp = nn.Sequential(
            nn.Linear(2, 8), nn.ReLU(), nn.Linear(8, config.width - config.time_code), nn.ReLU()
        )
        code = sinusoidal_code(config.history_steps, config.time_code)
        self.register_buffer("time_code", code, persistent=False)

    def forward(self, positions: Tensor) -> Tensor:
        """Encode (B, ..., T, 2) positions as tokens (B, S, C), S the product of ... and T."""
        pose = self.mlp(positions)
        code = self.time_code.expand(*pose.shape[:-1], -1)
        return torch.cat([pose, code], dim=-1).flatten(1, -2)  # (B, S, C)


class TrackEncoder(nn.Module):
    """Turns a whole track into one vector.

    Args:
        config: What the network is.
        size: Size of the vector.
    """

    def __init__(self, config: ModelConfig, size: int) -> None:
        super().__init__()
        self.mlp = nn.Sequential(
            nn.Linear(3 * config.history_steps, 64), nn.ReLU(), nn.Linear(64, size)
        )

    def forward(self, positions: Tensor, valid: Tensor) -> Tensor:
        """Encode (B, ..., T, 2) positions, `valid` (B, ..., T), as (B, ..., size)."""
        seen = valid[..., None].to(positions.dtype)
        frames = torch.cat([positions * seen, seen], dim=-1)  # (B, ..., T, 3)
        encoded: Tensor = self.mlp(frames.flatten(-2))
        return encoded


class PatchEncoder(nn.Module):
    """Linear patches of the map crop with a two-dimensional position code."""

    position_code: Tensor

    def __init__(self, config: ModelConfig) -> None:
        super().__init__()
        self.patch_px = config.patch_px
        self.linear = nn.Linear(3 * config.patch_px**2, config.width)
        side = config.crop_px // config.patch_px
        code = grid_code(side, config.width)  # (P, C)
        self.register_buffer("position_code", code, persistent=False)

    def forward(self, crop: Tensor) -> Tensor:
        """Encode (B, S, S, 3) uint8 pictures as tokens (B, P, C)."""
        (b, size), px = crop.shape[:2], self.patch_px
        grid = crop.view(b, size // px, px, size // px, px, 3).transpose(2, 3)
        patches = grid.reshape(b, -1, 3 * px**2).float()  # (B, P, 3 px^2)
        # linear(patches / 255 - 1/2), without two more passes over all the pixels
        weight, bias = self.linear.weight, self.linear.bias
        tokens = F.linear(patches, weight / 255.0, bias - 0.5 * weight.sum(dim=1))
        return tokens + self.position_code


def _map_encoder(config: ModelConfig) -> PatchEncoder | BackboneEncoder | None:
    if config.backbone is not None:
        return BackboneEncoder(config, config.backbone)
    return PatchEncoder(config) if config.variant == "patch" else None


def _decoder(inputs: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Linear(inputs, 256), nn.ReLU(), nn.Linear(256, 64), nn.ReLU(), nn.Linear(64, outputs)
    )


class IterativeAttention(nn.Module):
    """Goal and path of each agent from its history, its neighbors and the map.

    Args:
        config: What the network is.
    """

    def __init__(self, config: ModelConfig) -> None:
        super().__init__()
        self.config = config
        self.latents = nn.Parameter(0.02 * torch.randn(config.latents, config.width))
        self.pose_encoder = PoseEncoder(config) if config.tokens == "frame" else None
        if config.tokens == "track":
            self.own_encoder = TrackEncoder(config, config.latents * config.width)
            self.neighbor_encoder = TrackEncoder(config, config.width)
        self.map_encoder = _map_encoder(config)
        self.encoder_blocks = nn.ModuleList(EncoderBlock(config) for _ in range(config.blocks))
        flat = config.latents * config.width
        rows = config.width if config.path_rows == "mean" else flat
        self.goal_decoder = _decoder(flat, 2)
        self.trajectory_decoder = _decoder(rows + 2, 2 * config.forecast_steps)
        # last, so that the weights drawn for all else do not depend on it
        self.mode_decoder = (
            ModeDecoder(flat, config.modes, config.forecast_steps) if config.modes > 0 else None
        )

    def forward(
        self,
        history: Tensor,
        history_valid: Tensor,
        neighbors: Tensor,
        neighbors_valid: Tensor,
        last_step: Tensor,
        crop: Tensor | None = None,
        crop_valid: Tensor | None = None,
        true_goal: Tensor | None = None,
    ) -> tuple[Tensor, Tensor]:
        """Forecast in the agent frame [m]; the arguments are as in `AgentInputs`.

        Args:
            history: (B, T, 2) own positions.
            history_valid: (B, T) bool.
            neighbors: (B, K, T, 2) positions.
            neighbors_valid: (B, K, T) bool.
            last_step: (B, 2) last displacement per frame.
            crop: (B, S, S, 3) uint8, needed unless the variant is `none`.
            crop_valid: (B,) bool, False where there is no picture.
            true_goal: (B, 2) goal that the path is decoded for, instead of the predicted one.

        Returns:
            (B, 2) goal, which is the last position, and (B, F, 2) path.
        """
        latents = self.encode(history, history_valid, neighbors, neighbors_valid, crop, crop_valid)
        return self.decode(latents, last_step, true_goal)

    def encode(
        self,
        history: Tensor,
        history_valid: Tensor,
        neighbors: Tensor,
        neighbors_valid: Tensor,
        crop: Tensor | None = None,
        crop_valid: Tensor | None = None,
    ) -> Tensor:
        """What the latents (B, L, C) read from histories and map; arguments as of `forward`."""
        latents, streams = self._begin(history, history_valid, neighbors, neighbors_valid)
        if self.map_encoder is not None and crop is not None and crop_valid is not None:
            tokens = self.map_encoder(crop)
            streams["map"] = Stream.of(tokens, crop_valid[:, None].expand(-1, tokens.shape[1]))
        for encoder_block in self.encoder_blocks:
            latents = encoder_block(latents, streams)
        return latents

    def _begin(
        self, history: Tensor, history_valid: Tensor, neighbors: Tensor, neighbors_valid: Tensor
    ) -> tuple[Tensor, dict[str, Stream]]:
        """The latents (B, L, C) before the first block, and the streams of people to read."""
        latents = self.latents.expand(history.shape[0], -1, -1)
        if self.pose_encoder is not None:
            return latents, {
                "history": Stream.of(self.pose_encoder(history), history_valid),
                "neighbors": Stream.of(self.pose_encoder(neighbors), neighbors_valid.flatten(1)),
            }
        own = self.own_encoder(history, history_valid).view_as(latents)
        tracks = self.neighbor_encoder(neighbors, neighbors_valid)  # (B, K, C)
        return latents + own, {"neighbors": Stream.of(tracks, neighbors_valid.any(dim=2))}

    def decode(
        self, latents: Tensor, last_step: Tensor, true_goal: Tensor | None = None
    ) -> tuple[Tensor, Tensor]:
        """Goal (B, 2) and path (B, F, 2) from latents (B, L, C); arguments as of `forward`."""
        config, b = self.config, latents.shape[0]
        start = start_path(last_step, config)  # (B, F, 2)
        goal = self.goal_decoder(latents.flatten(1)) + start[:, -1]  # (B, 2)
        towards = goal if true_goal is None else true_goal
        if config.path_rows == "flatten":
            rows = torch.cat([latents.flatten(1), towards], dim=1)[:, None]  # (B, 1, LC + 2)
        else:
            each = towards[:, None].expand(-1, config.latents, -1)
            rows = torch.cat([latents, each], dim=2)  # (B, L, C + 2)
        path = self.trajectory_decoder(rows).mean(dim=1)  # (B, 2F)
        return goal, path.view(b, config.forecast_steps, 2) + start

    def forward_modes(
        self, last_step: Tensor, true_goal: Tensor | None = None, **seen: Tensor
    ) -> tuple[Tensor, Tensor, Modes]:
        """Goal and path as `forward` gives them, and modes; `seen` are the arguments of `encode`.

        Raises:
            ValueError: The network has no modes.
        """
        if self.mode_decoder is None:
            raise ValueError("expected a network with modes, found one without")
        latents = self.encode(**seen)
        goal, path = self.decode(latents, last_step, true_goal)
        # modes correct the path that is forecast: one towards the true goal would tell it to them
        own = path if true_goal is None else self.decode(latents, last_step)[1]
        return goal, path, self.mode_decoder(latents, own)


def loss(goal: Tensor, path: Tensor, future: Tensor) -> Tensor:
    """The paper's loss: average displacement of the path + half that of the goal [m].

    Args:
        goal: (B, 2) predicted goal.
        path: (B, F, 2) predicted path.
        future: (B, F, 2) true path.
    """
    average: Tensor = torch.linalg.vector_norm(path - future, dim=-1).mean()
    final: Tensor = torch.linalg.vector_norm(goal - future[:, -1], dim=-1).mean()
    return average + 0.5 * final
