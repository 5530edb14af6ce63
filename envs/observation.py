"""The observation: its spaces, and the code that fills them.

Policies import this module for the layout, so it stays free of the simulator.

A flat Dict of float32 Boxes in the robot's frame (REP-103: origin at the robot, +x along its
heading, y left). K nearest visible pedestrians, nearest first; a place without a pedestrian is
zero everywhere. T history frames, F forecast frames, M modes, R lidar rays. Without a forecaster
there is no `forecast…`.

| key                      | shape        | content                                               |
|--------------------------|--------------|-------------------------------------------------------|
| `robot`                  | (12,)        | see `ROBOT_FIELDS`                                    |
| `neighbors_valid`        | (K,)         | 1 where the place holds a pedestrian                  |
| `neighbors_radius`       | (K,)         | radius [m]                                            |
| `history`                | (K, T, 2)    | positions `frame_dt` apart, the last one now [m]      |
| `history_valid`          | (K, T)       | 1 where the robot reckoned with that pedestrian       |
| `forecast`               | (K, F, 2)    | forecast positions, the first `frame_dt` ahead [m]    |
| `forecast_radius`        | (K, F)       | of a circle that holds 9 in 10 around `forecast` [m]; |
|                          |              | wider for who has been out of sight for a while       |
| `forecast_modes`         | (K, M, F, 2) | other ways that they may go, the likeliest first [m]; |
|                          |              | only with `modes_observed`, as the next key           |
| `forecast_probabilities` | (K, M)       | of those ways                                         |
| `lidar`                  | (R,)         | range to walls and obstacles, not people [m]; ray 0   |
|                          |              | ahead, counter-clockwise                              |
| `map`                    | (64, 64, 3)  | uint8 RGB crop of the map, only with `observe_map`;   |
|                          |              | the robot is a quarter of the side from the left      |
|                          |              | edge, half-way down, and looks right; 16 m on a side  |
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from envs.config import CrowdNavConfig
from envs.robots import RobotState, direction, to_robot, turning_limit
from predictor.config import ModelConfig
from predictor.crops import crop_maps

if TYPE_CHECKING:
    from crowdsim.recordings import Picture
    from envs.foresight import Outlook
    from envs.perception import Percept

Observation = dict[str, NDArray[np.generic]]
Floats = NDArray[np.float64]

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
        keys["forecast_radius"] = _box(0.0, forecast_bound(config), shape[:2])
        if config.modes_observed > 0:
            modes = (observed, config.modes_observed, config.forecast_steps, 2)
            keys["forecast_modes"] = _symmetric(forecast_bound(config), modes)
            keys["forecast_probabilities"] = _box(0.0, 1.0, modes[:2])
    if config.observe_map:
        keys["map"] = spaces.Box(0, 255, (MAP_PIXELS, MAP_PIXELS, 3), np.uint8)
    return spaces.Dict(keys)


@dataclass(frozen=True, kw_only=True, eq=False)
class Task:
    """What is left of the tasks of R robots, world frame.

    Attributes:
        goal: (R, 2) [m].
        waypoint: (R, 2) point `WAYPOINT_DISTANCE` ahead on the shortest way, or the goal [m].
        time_left: (R,) share of the time limit.
    """

    goal: Floats
    waypoint: Floats
    time_left: Floats


def robot_space(config: CrowdNavConfig) -> spaces.Box:
    """Returns the Box of the key `robot`, bounds in the order of `ROBOT_FIELDS`."""
    turning = max(config.max_angular_speed, turning_limit(config))
    bounds = {
        "velocity_x": (-SPEED_BOUND, SPEED_BOUND),
        "velocity_y": (-SPEED_BOUND, SPEED_BOUND),
        "angular_speed": (-turning, turning),
        "goal_x": (-GOAL_RANGE, GOAL_RANGE),
        "goal_y": (-GOAL_RANGE, GOAL_RANGE),
        "waypoint_x": (-GOAL_RANGE, GOAL_RANGE),
        "waypoint_y": (-GOAL_RANGE, GOAL_RANGE),
        "radius": (0.0, config.robot_radius),
        "max_speed": (0.0, config.max_speed),
        "max_angular_speed": (0.0, turning),
        "max_acceleration": (0.0, config.max_acceleration),
        "time_left": (0.0, 1.0),
    }
    low, high = zip(*(bounds[name] for name in ROBOT_FIELDS), strict=True)
    return spaces.Box(
        np.array(low, dtype=np.float32), np.array(high, dtype=np.float32), dtype=np.float32
    )


def history_bound(config: CrowdNavConfig) -> float:
    """Largest coordinate of a history [m]: someone now in range, a history ago."""
    seconds = (config.history_steps - 1) * config.frame_dt
    return config.sensor_range + math.ceil(SPEED_BOUND * seconds)


def forecast_bound(config: CrowdNavConfig) -> float:
    """Largest coordinate of a forecast [m]: someone now in range, a horizon later."""
    return config.sensor_range + math.ceil(SPEED_BOUND * config.horizon)


def flattened_space(space: spaces.Dict) -> spaces.Dict:
    """Returns the space with the Box of every key flattened to one dimension."""
    boxes = {key: box for key, box in space.items() if isinstance(box, spaces.Box)}
    return spaces.Dict(
        {
            key: spaces.Box(box.low.ravel(), box.high.ravel(), dtype=box.dtype.type)
            for key, box in boxes.items()
        }
    )


def flattened(observation: Observation, leading: int) -> Observation:
    """Flattens every key to one dimension behind the `leading` ones."""
    return {key: values.reshape(*values.shape[:leading], -1) for key, values in observation.items()}


class Observer:
    """Fills the Boxes of its `space` for R worlds at once.

    Attributes:
        space: Space of one observation.
    """

    def __init__(self, config: CrowdNavConfig):
        self.space = observation_space(config)
        self._limits = robot_space(config)
        self._history_bound = history_bound(config)
        self._forecast_bound = forecast_bound(config)
        self._constants = {
            "radius": config.robot_radius,
            "max_speed": config.max_speed,
            "max_angular_speed": turning_limit(config),
            "max_acceleration": config.max_acceleration,
        }

    def observe(
        self, percept: Percept, robots: RobotState, task: Task, lidar: Floats
    ) -> Observation:
        """Returns every key but `map` (see `map_crops`), fresh arrays with R in front.

        Args:
            percept: What the robots perceive, world frame.
            robots: Where they are.
            task: Where they have to go.
            lidar: (R, rays) ranges [m].
        """
        valid = percept.observed.valid
        observation = {
            "robot": self._robot(robots, task),
            "neighbors_valid": valid,
            "neighbors_radius": np.minimum(percept.radius, 1.0),
            "history": _seen(percept.history, percept.history_valid, robots, self._history_bound),
            "history_valid": percept.history_valid,
            "lidar": lidar,
        }
        if percept.outlook is not None:
            observation |= self._outlook(percept.outlook, valid, robots)
        return {key: values.astype(np.float32) for key, values in observation.items()}

    def _outlook(
        self, outlook: Outlook, valid: NDArray[np.bool_], robots: RobotState
    ) -> dict[str, Floats]:
        """Returns the keys that a forecaster fills."""
        bound, there = self._forecast_bound, valid[:, :, None]
        keys = {
            "forecast": _seen(outlook.position, there, robots, bound),
            "forecast_radius": np.minimum(outlook.radius, bound),
        }
        if outlook.modes is not None and outlook.probability is not None:
            keys["forecast_modes"] = _seen(outlook.modes, there[..., None], robots, bound)
            keys["forecast_probabilities"] = outlook.probability
        return keys

    def _robot(self, robots: RobotState, task: Task) -> Floats:
        """Returns (R, 12), the columns of `ROBOT_FIELDS`."""
        velocity = to_robot(robots.velocity, robots.heading)
        goal = _shortened(to_robot(task.goal - robots.position, robots.heading))
        waypoint = _shortened(to_robot(task.waypoint - robots.position, robots.heading))
        values = self._constants | {
            "velocity_x": velocity[:, 0],
            "velocity_y": velocity[:, 1],
            "angular_speed": robots.angular_speed,
            "goal_x": goal[:, 0],
            "goal_y": goal[:, 1],
            "waypoint_x": waypoint[:, 0],
            "waypoint_y": waypoint[:, 1],
            "time_left": task.time_left,
        }
        filled = np.empty((len(goal), len(ROBOT_FIELDS)))
        for index, name in enumerate(ROBOT_FIELDS):
            filled[:, index] = values[name]
        return np.clip(filled, self._limits.low, self._limits.high)


def map_crops(robots: RobotState, pictures: Sequence[Picture]) -> NDArray[np.uint8]:
    """Cuts (R, 64, 64, 3) out of the pictures of R worlds, turned into the robots' frames."""
    rows = np.arange(len(pictures))
    world_from_robot = np.zeros((len(rows), 3, 3))
    world_from_robot[:, :2, 0] = direction(robots.heading)
    world_from_robot[:, :2, 1] = direction(robots.heading + 0.5 * np.pi)
    world_from_robot[:, :2, 2] = robots.position
    world_from_robot[:, 2, 2] = 1.0
    crops = crop_maps(
        [picture.image for picture in pictures],
        [picture.pixel_from_world for picture in pictures],
        rows,
        world_from_robot,
        ModelConfig(variant="patch", crop_side=MAP_SIDE, crop_px=MAP_PIXELS),
    )
    assert crops is not None  # only the variant without a map has none
    return crops


def _seen(points: Floats, valid: NDArray[np.bool_], robots: RobotState, bound: float) -> Floats:
    """Takes world points (R, K, ..., 2) into the robots' frames; 0 where not `valid`."""
    origin = robots.position.reshape(-1, *(1,) * (points.ndim - 2), 2)
    relative = to_robot(points - origin, robots.heading)
    # Not by a product: the zeros would have the signs of what stood there in an earlier episode.
    return np.where(valid[..., None], np.clip(relative, -bound, bound), 0.0)


def _shortened(vectors: Floats) -> Floats:
    """Keeps the direction of (R, 2) vectors and cuts their length at `GOAL_RANGE`."""
    length = np.sqrt(vectors[:, 0] ** 2 + vectors[:, 1] ** 2)
    return vectors * (GOAL_RANGE / np.maximum(length, GOAL_RANGE))[:, None]


def _box(low: float, high: float, shape: tuple[int, ...]) -> spaces.Box:
    return spaces.Box(low, high, shape, np.float32)


def _symmetric(bound: float, shape: tuple[int, ...]) -> spaces.Box:
    return _box(-bound, bound, shape)
