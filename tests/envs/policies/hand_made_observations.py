"""Observations by hand, and a robot that follows its commands exactly: no simulator."""

from dataclasses import dataclass, field

import numpy as np

from envs.config import CrowdNavConfig
from envs.observation import ROBOT_INDEX, observation_space
from envs.robots import turning_limit


def empty_observation(config, *, goal=(6.0, 0.0), waypoint=None, velocity=(0.0, 0.0, 0.0)):
    """One observation without people and walls, in the robot frame."""
    space = observation_space(config)
    observation = {key: np.zeros(box.shape, box.dtype) for key, box in space.items()}
    observation["lidar"][:] = config.sensor_range
    if waypoint is None:
        waypoint = np.asarray(goal) * min(1.0, 2.0 / max(np.hypot(*goal), 1e-9))
    fields = {
        "velocity_x": velocity[0],
        "velocity_y": velocity[1],
        "angular_speed": velocity[2],
        "goal_x": goal[0],
        "goal_y": goal[1],
        "waypoint_x": waypoint[0],
        "waypoint_y": waypoint[1],
        "radius": config.robot_radius,
        "max_speed": config.max_speed,
        "max_angular_speed": turning_limit(config),
        "max_acceleration": config.max_acceleration,
        "time_left": 1.0,
    }
    for name, value in fields.items():
        observation["robot"][ROBOT_INDEX[name]] = value
    return observation


def add_person(observation, config, slot, position, velocity, radius=0.25):
    """Put a person who has walked straight, and will, into a slot."""
    position, velocity = np.asarray(position), np.asarray(velocity)
    past = config.frame_dt * np.arange(1 - config.history_steps, 1)
    observation["history"][slot] = position + past[:, None] * velocity
    observation["history_valid"][slot] = 1.0
    observation["neighbors_valid"][slot] = 1.0
    observation["neighbors_radius"][slot] = radius
    if "forecast" in observation:
        ahead = config.frame_dt * np.arange(1, config.forecast_steps + 1)
        observation["forecast"][slot] = position + ahead[:, None] * velocity


def stack(observations):
    return {key: np.stack([one[key] for one in observations]) for key in observations[0]}


@dataclass
class Drive:
    """A kinematic robot that starts at the origin, among people who walk straight."""

    config: CrowdNavConfig
    goal: tuple[float, float] = (8.0, 0.0)
    people: list = field(default_factory=list)  # (position, velocity), world frame
    radius: float = 0.25
    position: np.ndarray = field(default_factory=lambda: np.zeros(2))
    heading: float = 0.0
    command: np.ndarray = field(default_factory=lambda: np.zeros(2))
    time: float = 0.0
    clearance: float = np.inf

    def observation(self):
        rotation = self._robot_from_world()
        if self.config.robot != "holonomic":
            velocity = (self.command[0], 0.0, self.command[1])
        else:
            velocity = (*self.command, 0.0)
        goal = rotation @ (np.asarray(self.goal) - self.position)
        observation = empty_observation(self.config, goal=goal, velocity=velocity)
        for slot, (position, velocity) in enumerate(self.people):
            now = np.asarray(position) + self.time * np.asarray(velocity)
            local = rotation @ (now - self.position), rotation @ np.asarray(velocity)
            add_person(observation, self.config, slot, *local, radius=self.radius)
        return observation

    def step(self, action):
        dt, limit = self.config.policy_dt, self.config.max_speed
        if self.config.robot != "holonomic":
            speed = 0.5 * (action[0] + 1.0) * limit
            turn = self._turn(speed, action[1])
            self.command = np.array([speed, turn])
            self.heading += turn * dt
            self.position = self.position + dt * self.command[0] * np.array(
                [np.cos(self.heading), np.sin(self.heading)]
            )
        else:
            self.command = np.asarray(action, float) * limit
            self.position = self.position + dt * self._robot_from_world().T @ self.command
        self.time += dt
        self._measure()

    def _turn(self, speed, action):
        if self.config.robot == "unicycle":
            return action * self.config.max_angular_speed
        return speed * np.tan(action * self.config.max_steering) / self.config.wheelbase

    def run(self, policy, seconds=20.0):
        """Drive until the goal is reached; whether it was."""
        while self.time < seconds:
            self.step(policy.act(self.observation()))
            if np.hypot(*(self.goal - self.position)) < self.config.goal_radius:
                return True
        return False

    def _measure(self):
        for position, velocity in self.people:
            gap = np.asarray(position) + self.time * np.asarray(velocity) - self.position
            clearance = np.hypot(*gap) - self.config.robot_radius - self.radius
            self.clearance = min(self.clearance, clearance)

    def _robot_from_world(self):
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        return np.array([[cos, sin], [-sin, cos]])
