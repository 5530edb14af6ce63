"""Features of an observation for a learned policy: the robot looks at the people, one by one."""

from __future__ import annotations

from collections.abc import Mapping

import torch
import torch.nn.functional as F  # noqa: N812
from gymnasium import spaces
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor, NatureCNN
from torch import Tensor, nn

from envs.observation import ROBOT_INDEX

LENGTH_SCALE = 3.0
"""Metres that become 1: where people start to matter."""

FARTHEST = 4.0
"""Scaled values are clipped here: a goal at 12 m or beyond is simply far."""

HEADS = 4
"""Ways of looking at the crowd at once."""

HERE = 0.05
"""A target so near has no direction any more, rather than one that whirls around [m]."""

_MOTION = [ROBOT_INDEX[name] for name in ("velocity_x", "velocity_y", "angular_speed")]
_GOAL = [ROBOT_INDEX["goal_x"], ROBOT_INDEX["goal_y"]]
_WAYPOINT = [ROBOT_INDEX["waypoint_x"], ROBOT_INDEX["waypoint_y"]]
_RADIUS = ROBOT_INDEX["radius"]
_LIMITS = [
    ROBOT_INDEX[name]
    for name in ("radius", "max_speed", "max_angular_speed", "max_acceleration", "time_left")
]


class CrowdFeatures(BaseFeaturesExtractor):
    """Attention of the robot over the people that it sees.

    Everybody becomes a token, the same network for each, which knows the robot's task and motion
    as well. The robot has a token, too: it asks, and without people it looks at itself. The order
    of people does not matter, and what stands in empty places is not looked at.

    Args:
        observation_space: Space of the environment; `forecast…` and `map` may be absent.
        width: Features of a token, a multiple of `HEADS`; the lidar and the map give as many.
        frame_dt: Time between the frames of forecasts [s].
    """

    def __init__(
        self, observation_space: spaces.Dict, width: int = 64, frame_dt: float = 0.4
    ) -> None:
        nothing = {
            key: torch.zeros(1, *(space.shape or ())) for key, space in observation_space.items()
        }
        robot = robot_features(nothing).shape[1]
        person = person_features(nothing, frame_dt).shape[2]
        walls = wall_features(nothing).shape[1]
        has_map = "map" in nothing
        super().__init__(observation_space, robot + (3 if has_map else 2) * width)
        self.frame_dt = frame_dt
        self.robot = nn.Linear(robot, width)
        self.person = nn.Linear(person, width)
        self.token = nn.Sequential(nn.ReLU(), nn.Linear(width, width), nn.ReLU())
        self.query = nn.Linear(width, width)
        self.key_value = nn.Linear(width, 2 * width)
        self.walls = nn.Sequential(nn.Linear(walls, width), nn.ReLU())
        self.map = NatureCNN(observation_space["map"], width) if has_map else None

    def forward(self, observation: Mapping[str, Tensor]) -> Tensor:
        """Returns features (B, D) of a batch of observations."""
        robot = robot_features(observation)
        parts = [
            robot,
            self._crowd(robot, observation),
            self.walls(wall_features(observation)),
        ]
        if self.map is not None:
            parts.append(self.map(observation["map"]))
        return torch.cat(parts, dim=1)

    def _crowd(self, robot: Tensor, observation: Mapping[str, Tensor]) -> Tensor:
        """Returns (B, width): what the robot sees in itself and in the people around it."""
        own = self.robot(robot).unsqueeze(1)  # (B, 1, width)
        people = self.person(person_features(observation, self.frame_dt)) + own  # (B, K, width)
        tokens = self.token(torch.cat((own, people), dim=1))  # (B, 1+K, width)
        query = by_head(self.query(tokens[:, :1]))
        key, value = (by_head(part) for part in self.key_value(tokens).chunk(2, dim=2))
        there = F.pad(observation["neighbors_valid"] > 0.5, (1, 0), value=True)
        seen = F.scaled_dot_product_attention(query, key, value, attn_mask=there[:, None, None])
        return seen.flatten(1)  # (B, heads, 1, width/heads) -> (B, width)


def by_head(tokens: Tensor) -> Tensor:
    """Returns tokens (B, N, width) as (B, heads, N, width/heads)."""
    return tokens.view(*tokens.shape[:2], HEADS, -1).transpose(1, 2)


def robot_features(observation: Mapping[str, Tensor]) -> Tensor:
    """Returns (B, D): the robot's motion, its limits, and where its goal and its waypoint are."""
    robot = observation["robot"]
    parts = [robot[:, _MOTION], robot[:, _LIMITS]]
    for target in (robot[:, _GOAL], robot[:, _WAYPOINT]):
        distance = target.norm(dim=1, keepdim=True)
        parts += [scaled(target), nearness(distance), target / (distance + HERE)]
    return torch.cat(parts, dim=1)


def person_features(observation: Mapping[str, Tensor], frame_dt: float) -> Tensor:
    """Returns (B, K, D): where each person is, was, and is forecast to be, seen from the robot.

    Paths are relative to where the person stands now. Nearness is that of the surfaces of the two
    discs, at each step of the forecast to where the robot is now, and to where it is then if it
    goes on as it does.
    """
    history, valid = observation["history"], observation["history_valid"]
    now = history[:, :, -1:]  # (B, K, 1, 2)
    reach = (observation["neighbors_radius"] + observation["robot"][:, _RADIUS, None]).unsqueeze(2)
    past = (history - now) * valid.unsqueeze(3)
    parts = [
        scaled(now).flatten(2),
        scaled(past[:, :, :-1]).flatten(2),
        valid,
        reach,
        nearness(now.norm(dim=3) - reach),
    ]
    if "forecast" in observation:
        forecast = observation["forecast"]
        parts += [
            scaled(forecast - now).flatten(2),
            nearness(forecast.norm(dim=3) - reach),
            nearness((forecast - going_on(observation, frame_dt)).norm(dim=3) - reach),
            scaled(observation["forecast_radius"]),
        ]
    if "forecast_modes" in observation:
        modes = observation["forecast_modes"] - now.unsqueeze(2)
        parts += [scaled(modes).flatten(2), observation["forecast_probabilities"]]
    return torch.cat(parts, dim=2)


def going_on(observation: Mapping[str, Tensor], frame_dt: float) -> Tensor:
    """Returns (B, 1, F, 2): where the robot is at each step of the forecast at its velocity [m]."""
    steps = observation["forecast"].shape[2]
    velocity = observation["robot"][:, None, None, _MOTION[:2]]
    return velocity * (frame_dt * torch.arange(1, steps + 1)).unsqueeze(1)


def wall_features(observation: Mapping[str, Tensor]) -> Tensor:
    """Returns (B, 2R): how far the walls are along each ray, and how near."""
    lidar = observation["lidar"]
    return torch.cat((scaled(lidar), nearness(lidar)), dim=1)


def scaled(lengths: Tensor) -> Tensor:
    """Returns metres in units of `LENGTH_SCALE`, clipped where they no longer matter."""
    return (lengths / LENGTH_SCALE).clamp(-FARTHEST, FARTHEST)


def nearness(distance: Tensor) -> Tensor:
    """Returns 1 at contact, falling to 1/e within a metre."""
    return torch.exp(-distance.clamp(min=0.0))
