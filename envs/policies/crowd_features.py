"""Features of an observation for a learned policy: the people as a set, the rest as vectors."""

from __future__ import annotations

from collections.abc import Mapping

import torch
from gymnasium import spaces
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor, NatureCNN
from torch import Tensor, nn

LENGTH_SCALE = 3.0
"""Metres (and m/s) that become 1: where people start to matter."""

FARTHEST = 4.0
"""Scaled values are clipped here: a goal at 12 m or beyond is simply far."""


class CrowdFeatures(BaseFeaturesExtractor):
    """The same small network for every person, the largest value of each feature over all people.

    The order of people does not matter, and a crowd without anybody gives zeros (Deep Sets,
    Zaheer et al. 2017, with maximum pooling).

    Args:
        observation_space: Space of the environment; `forecast` and `map` may be absent.
        width: Features per person; the lidar and the map give as many.
    """

    def __init__(self, observation_space: spaces.Dict, width: int = 64) -> None:
        shapes = {key: space.shape or () for key, space in observation_space.items()}
        robot, rays, has_map = shapes["robot"][0], shapes["lidar"][0], "map" in shapes
        super().__init__(observation_space, robot + (3 if has_map else 2) * width)
        person = 3 * shapes["history"][1] + 1
        if "forecast" in shapes:
            person += 2 * shapes["forecast"][1]
        self.person = nn.Sequential(
            nn.Linear(person, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU()
        )
        self.walls = nn.Sequential(nn.Linear(rays, width), nn.ReLU())
        self.map = NatureCNN(observation_space["map"], width) if has_map else None

    def forward(self, observation: Mapping[str, Tensor]) -> Tensor:
        """Returns features (B, D) of a batch of observations."""
        parts = [
            scaled(observation["robot"]),
            self._crowd(observation),
            self.walls(scaled(observation["lidar"])),
        ]
        if self.map is not None:
            parts.append(self.map(observation["map"]))
        return torch.cat(parts, dim=1)

    def _crowd(self, observation: Mapping[str, Tensor]) -> Tensor:
        parts = [
            scaled(observation["history"]).flatten(2),  # (B, K, T*2)
            observation["history_valid"],  # (B, K, T)
            observation["neighbors_radius"].unsqueeze(2),  # (B, K, 1)
        ]
        if "forecast" in observation:
            parts.append(scaled(observation["forecast"]).flatten(2))  # (B, K, F*2)
        people: Tensor = self.person(torch.cat(parts, dim=2))
        # The features are not negative, so those of empty slots may become zeros.
        return (people * observation["neighbors_valid"].unsqueeze(2)).amax(dim=1)


def scaled(values: Tensor) -> Tensor:
    """Returns metres in units of `LENGTH_SCALE`, clipped where they no longer matter."""
    return (values / LENGTH_SCALE).clamp(-FARTHEST, FARTHEST)
