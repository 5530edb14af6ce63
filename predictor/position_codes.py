"""Codes of positions in a sequence and in a picture, to be given to tokens."""

import math

import torch
from torch import Tensor


def sinusoidal_code(count: int, size: int) -> Tensor:
    """Sines and cosines of the positions 0..count-1 in geometric frequencies: (count, size)."""
    frequency = torch.exp(-math.log(10000.0) * torch.arange(0, size, 2) / size)
    angle = torch.arange(count)[:, None] * frequency
    return torch.stack([angle.sin(), angle.cos()], dim=-1).flatten(1)


def grid_code(side: int, size: int) -> Tensor:
    """Of the places of a square picture, row after row: (side^2, size), half of it for the row."""
    code = sinusoidal_code(side, size // 2)
    rows, columns = code[:, None].expand(side, side, -1), code[None].expand(side, side, -1)
    return torch.cat([rows, columns], dim=-1).flatten(0, 1)
