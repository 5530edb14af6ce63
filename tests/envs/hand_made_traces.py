"""Small traces written by hand: constant-velocity robots and people, nothing simulated."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crowdsim.map import Map
from crowdsim.pedestrians import Pedestrians
from crowdsim.scenario import Scenario
from envs.trace import Trace, TwinTrace

DT = 0.2
ROBOT_RADIUS = 0.3
PEDESTRIAN_RADIUS = 0.2


def walk(start: ArrayLike, velocity: ArrayLike, steps: int) -> np.ndarray:
    """(steps + 1, 2) positions of somebody who keeps going."""
    return np.asarray(start) + np.arange(steps + 1)[:, None] * DT * np.asarray(velocity)


def make_trace(robot: np.ndarray, people: list[np.ndarray], **changes: Any) -> Trace:
    """A trace of a robot path (T, 2) and pedestrian paths (T, 2) each, ending at the goal."""
    steps, count = len(robot), len(people)
    position = np.stack(people, axis=1) if people else np.zeros((steps, 0, 2))
    robot_velocity = np.gradient(robot, DT, axis=0)
    distance = np.linalg.norm(position - robot[:, None], axis=-1)
    clearance = distance - ROBOT_RADIUS - PEDESTRIAN_RADIUS
    forecast = changes.get("forecast")
    fields: dict[str, Any] = {
        "scenario": open_scenario(count, robot[0], robot[-1]),
        "world_seed": np.random.SeedSequence(0),
        "physics_dt": 0.05,
        "dt": DT,
        "frame_dt": 0.4,
        "time_limit": 30.0,
        "mission": 0.0,
        "robot_radius": ROBOT_RADIUS,
        "robot_position": robot,
        "robot_velocity": robot_velocity,
        "robot_heading": np.arctan2(robot_velocity[:, 1], robot_velocity[:, 0]),
        "robot_goal": np.tile(robot[-1], (steps, 1)),
        "goal_radius": 0.3,
        "shortest_path_lengths": np.linalg.norm(robot[-1:] - robot[:1], axis=1),
        "position": position,
        "velocity": np.gradient(position, DT, axis=0),
        "valid": np.ones((steps, count), bool),
        "ids": np.tile(np.arange(count), (steps, 1)),
        "radius": np.full(count, PEDESTRIAN_RADIUS),
        "visible": np.ones((steps, count), bool),
        "clearance_pedestrian": clearance.min(axis=1, initial=np.inf),
        "clearance_wall": np.full(steps, np.inf),
        "forecast": None,
        "forecast_ids": None,
        "forecast_radius": None if forecast is None else np.zeros(forecast.shape[:3]),
        "forecast_frames_seen": None if forecast is None else np.full(forecast.shape[:2], 8),
        "forecast_seconds": np.zeros(steps),
        "social_work": np.zeros(steps),
        "rewards": {},
        "termination_reason": "goal",
        "collision_role": None,
    }
    return Trace(**(fields | changes))


def make_twin(people: list[np.ndarray], **changes: Any) -> TwinTrace:
    """The twin run of people on given paths (T, 2) each."""
    position = np.stack(people, axis=1)
    fields: dict[str, Any] = {
        "dt": DT,
        "position": position,
        "velocity": np.gradient(position, DT, axis=0),
        "valid": np.ones(position.shape[:2], bool),
        "ids": np.tile(np.arange(len(people)), (len(position), 1)),
    }
    return TwinTrace(**(fields | changes))


def open_scenario(people: int, start: np.ndarray, goal: np.ndarray) -> Scenario:
    """An empty square of 40 m with people who stand where they do not matter."""
    pedestrians = Pedestrians(
        position=np.zeros((people, 2)),
        velocity=np.zeros((people, 2)),
        waypoints=np.zeros((people, 1, 2)),
        desired_speed=np.ones(people),
        relaxation_time=np.full(people, 0.5),
        radius=np.full(people, PEDESTRIAN_RADIUS),
        mass=np.full(people, 80.0),
    )
    return Scenario(
        name="open",
        map=Map(bounds=(-20.0, -20.0, 20.0, 20.0)),
        pedestrians=pedestrians,
        robot_start=(float(start[0]), float(start[1]), 0.0),
        robot_goal=(float(goal[0]), float(goal[1])),
    )
