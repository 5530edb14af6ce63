"""What every network starts from: its inputs as tensors, and the path of constant velocity."""

import torch
from torch import Tensor

from predictor.config import NetworkConfig
from predictor.inputs import AgentInputs


def tensors(inputs: AgentInputs, device: torch.device | str = "cpu") -> dict[str, Tensor]:
    """The arguments of the `forward` of any network for some agents."""
    names = ["history", "history_valid", "neighbors", "neighbors_valid", "last_step"]
    if inputs.crop is not None:
        names += ["crop", "crop_valid"]
    return {name: torch.from_numpy(getattr(inputs, name)).to(device) for name in names}


def start_path(last_step: Tensor, config: NetworkConfig) -> Tensor:
    """What a forecast is added to: (B, F, 2) constant velocity, or zeros if not `residual`.

    Args:
        last_step: (B, 2) last displacement per frame.
        config: Says how many frames, and whether the network corrects constant velocity.
    """
    if not config.residual:
        return last_step.new_zeros(last_step.shape[0], config.forecast_steps, 2)
    ahead = torch.arange(1, config.forecast_steps + 1, device=last_step.device)[:, None]
    return last_step[:, None] * ahead
