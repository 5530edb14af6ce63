"""The observation: its spaces, and the code that fills them.

A flat Dict of float32 Boxes in the robot's frame (REP-103: origin at the robot, +x along its
heading, y left). K nearest visible pedestrians, nearest first; a slot without a pedestrian is
zero everywhere. H history frames, F forecast frames, R lidar rays.

| key                | shape       | content                                                     |
|--------------------|-------------|-------------------------------------------------------------|
| `robot`            | (12,)       | see `ROBOT_FIELDS`                                          |
| `neighbors_valid`  | (K,)        | 1 where the slot holds a pedestrian                         |
| `neighbors_radius` | (K,)        | radius [m]                                                  |
| `history`          | (K, H, 2)   | positions `frame_dt` apart, the last one now [m]            |
| `history_valid`    | (K, H)      | 1 where the robot saw that pedestrian                       |
| `forecast`         | (K, F, 2)   | positions forecast, first one `frame_dt` ahead [m]; absent without a forecaster |
| `lidar`            | (R,)        | range to walls and obstacles (not people), ray 0 ahead, CCW [m] |
| `map`              | (64, 64, 3) | uint8 RGB crop of the map, only with `observe_map`          |
"""

import math
from typing import Final

import numpy as np
from gymnasium import spaces

from envs.config import CrowdNavConfig

ROBOT_FIELDS: Final = (
    "velocity_x",  # [m/s], robot frame
    "velocity_y",
    "angular_speed",  # [rad/s]
    "goal_x",  # [m], robot frame; shortened to GOAL_RANGE when farther
    "goal_y",
    "waypoint_x",  # [m], robot frame: WAYPOINT_DISTANCE ahead on the shortest path, or the goal
    "waypoint_y",
    "radius",  # [m]
    "max_speed",  # [m/s]
    "max_angular_speed",  # [rad/s], 0 for a robot that does not turn
    "max_acceleration",  # [m/s^2]
    "time_left",  # share of the time limit, 1 at the start
)
ROBOT_INDEX: Final = {name: index for index, name in enumerate(ROBOT_FIELDS)}
GOAL_RANGE: Final = 100.0
WAYPOINT_DISTANCE: Final = 2.0
MAP_PIXELS: Final = 64
MAP_SIDE: Final = 16.0  # [m]
# Faster than anybody walks or is pushed; keeps the Boxes finite without touching real values.
SPEED_BOUND: Final = 5.0


def observation_space(config: CrowdNavConfig) -> spaces.Dict:
    """Returns the space of one observation; see the module for keys, shapes and units."""
    observed, frames = config.pedestrians_observed, config.history_steps
    keys: dict[str, spaces.Space[np.ndarray]] = {
        "robot": robot_space(config),
        "neighbors_valid": _box(0.0, 1.0, (observed,)),
        "neighbors_radius": _box(0.0, 1.0, (observed,)),
        "history": _symmetric(history_bound(config), (observed, frames, 2)),
        "history_valid": _box(0.0, 1.0, (observed, frames)),
        "lidar": _box(0.0, config.sensor_range, (config.lidar_rays,)),
    }
    if config.forecaster != "none":
        shape = (observed, config.forecast_steps, 2)
        keys["forecast"] = _symmetric(forecast_bound(config), shape)
    if config.observe_map:
        keys["map"] = spaces.Box(0, 255, (MAP_PIXELS, MAP_PIXELS, 3), np.uint8)
    return spaces.Dict(keys)


def robot_space(config: CrowdNavConfig) -> spaces.Box:
    """Returns the Box of the key `robot`, bounds in the order of `ROBOT_FIELDS`."""
    turning = config.max_angular_speed if config.robot == "unicycle" else 0.0
    bounds = {
        "velocity_x": (-SPEED_BOUND, SPEED_BOUND),
        "velocity_y": (-SPEED_BOUND, SPEED_BOUND),
        "angular_speed": (-config.max_angular_speed, config.max_angular_speed),
        "goal_x": (-GOAL_RANGE, GOAL_RANGE),
        "goal_y": (-GOAL_RANGE, GOAL_RANGE),
        "waypoint_x": (-GOAL_RANGE, GOAL_RANGE),
        "waypoint_y": (-GOAL_RANGE, GOAL_RANGE),
        "radius": (0.0, config.robot_radius),
        "max_speed": (0.0, config.max_speed),
        "max_angular_speed": (0.0, max(turning, 1.0)),
        "max_acceleration": (0.0, config.max_acceleration),
        "time_left": (0.0, 1.0),
    }
    low, high = zip(*(bounds[name] for name in ROBOT_FIELDS), strict=True)
    return spaces.Box(np.float32(low), np.float32(high), dtype=np.float32)


def history_bound(config: CrowdNavConfig) -> float:
    """Largest coordinate of a history [m]: someone now in range, a history ago."""
    seconds = (config.history_steps - 1) * config.frame_dt
    return config.sensor_range + math.ceil(SPEED_BOUND * seconds)


def forecast_bound(config: CrowdNavConfig) -> float:
    """Largest coordinate of a forecast [m]: someone now in range, a horizon later."""
    return config.sensor_range + math.ceil(SPEED_BOUND * config.horizon)


def _box(low: float, high: float, shape: tuple[int, ...]) -> spaces.Box:
    return spaces.Box(low, high, shape, np.float32)


def _symmetric(bound: float, shape: tuple[int, ...]) -> spaces.Box:
    return _box(-bound, bound, shape)
