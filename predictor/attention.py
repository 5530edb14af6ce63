"""What the latents of the network look at: its attention, read out for given agents.

`F.scaled_dot_product_attention` gives no weights, so they are computed a second time, plainly, from
what each cross-attention is given (Vaswani et al., "Attention Is All You Need", 2017, equation 1).
Weights say where was looked, not what that did: for the latter a stream is switched off
(`predictor.ablation`). Each stream has its own softmax, so weights of two streams do not compare.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from predictor.inputs import AgentInputs
from predictor.model import CrossAttention, IterativeAttention, Stream
from predictor.tensors import tensors


@dataclass(frozen=True, kw_only=True, eq=False)
class Attended:
    """Where the latents looked, averaged over blocks, heads and latents.

    The weights of a stream add up to 1, or to 0 where there was nothing to look at.

    Attributes:
        history: (B, T) weights of the frames of the agent's own history; None for a network that
            reads it whole.
        neighbors: (B, K) weights of the neighbors.
        ground: (B, R, R) weights of the patches of the crop, row by row; None without a map.
    """

    history: NDArray[np.float32] | None
    neighbors: NDArray[np.float32]
    ground: NDArray[np.float32] | None


def attention_weights(
    network: IterativeAttention, inputs: AgentInputs
) -> dict[str, NDArray[np.float32]]:
    """Weights with which the latents read each stream of tokens.

    Args:
        network: In `eval` mode.
        inputs: Of B agents.

    Returns:
        By stream (`history`, `neighbors`, `map`, as far as there is one): (B, blocks, H, L, S) for
        H heads, L latents and S tokens; 0 for tokens that are not valid.
    """
    found: dict[str, list[Tensor]] = {}

    def recorder(stream: str) -> Callable[[Any, Any], None]:
        return lambda module, given: found.setdefault(stream, []).append(_weights(module, *given))

    handles = [
        module.register_forward_pre_hook(recorder(path.rpartition(".")[2]))
        for path, module in network.encoder_blocks.named_modules()
        if isinstance(module, CrossAttention)
    ]
    try:
        with torch.inference_mode():
            network(**tensors(inputs))
    finally:
        for handle in handles:
            handle.remove()
    return {stream: torch.stack(blocks, dim=1).numpy() for stream, blocks in found.items()}


def _weights(module: CrossAttention, latents: Tensor, stream: Stream) -> Tensor:
    """(B, H, L, S) softmax of what `module` computes when it is given this."""
    query, key, _ = module.attention.project(module.norm(latents), stream.tokens)
    scores = query @ key.transpose(2, 3) / query.shape[-1] ** 0.5
    weights: Tensor = (scores + stream.mask).softmax(dim=-1) * stream.any_valid[..., None]
    return weights


def attended(network: IterativeAttention, inputs: AgentInputs) -> Attended:
    """Where the network looks for B agents: `attention_weights` in terms of people and places."""
    weights = {k: v.mean(axis=(1, 2, 3)) for k, v in attention_weights(network, inputs).items()}
    of_map = weights.get("map")  # (B, P)
    count, neighbors = inputs.neighbors.shape[:2]
    side = network.config.crop_px // network.config.patch_px
    return Attended(
        history=weights.get("history"),
        neighbors=weights["neighbors"].reshape(count, neighbors, -1).sum(axis=2),
        ground=None if of_map is None else of_map.reshape(count, side, side),
    )
