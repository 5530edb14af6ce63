"""The robots: how an action in [-1, 1] becomes motion. W robots at once, one per world."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

from envs.config import CrowdNavConfig
from envs.tracker import Rows

Floats = NDArray[np.float64]


@dataclass(eq=False)
class RobotState:
    """State of W robots, world frame, SI units; updated in place.

    Attributes:
        position: (W, 2), as the physics left it.
        velocity: (W, 2), as the physics left it.
        heading: (W,) radians, CCW from +x.
        command: (W, 2) last command, in the units of the robot's `commands`.
        angular_speed: (W,) [rad/s].
    """

    position: Floats
    velocity: Floats
    heading: Floats
    command: Floats
    angular_speed: Floats

    @classmethod
    def zeros(cls, worlds: int) -> "RobotState":
        """State of `worlds` robots that stand at the origin."""
        return cls(
            position=np.zeros((worlds, 2)),
            velocity=np.zeros((worlds, 2)),
            heading=np.zeros(worlds),
            command=np.zeros((worlds, 2)),
            angular_speed=np.zeros(worlds),
        )

    def rows(self, rows: Rows) -> "RobotState":
        """Returns the state of some of the robots; a slice shares memory with this one."""
        return RobotState(**{name: values[rows] for name, values in vars(self).items()})

    def restart(self, world: int, start: tuple[float, float, float]) -> None:
        """Puts the robot of one world at its start (x, y, heading), at rest."""
        self.position[world] = start[:2]
        self.velocity[world] = 0.0
        self.heading[world] = start[2]
        self.command[world] = 0.0
        self.angular_speed[world] = 0.0


class Robot(Protocol):
    """How one kind of robot turns actions into motion."""

    def apply(self, actions: Floats, state: RobotState) -> None:
        """Takes (W, 2) actions in [-1, 1] as the command for the next policy period."""

    def drive(self, state: RobotState, dt: float, steps: int) -> Floats:
        """Turns for `steps` times `dt` seconds.

        Returns:
            (W, steps, 2) velocities to reach in each of them, world frame [m/s].
        """

    def rollout(self, state: RobotState, times: Floats) -> Floats:
        """Returns (W, F, 2) world positions at `times` (F,) seconds ahead if the command stays."""


@dataclass(frozen=True)
class Unicycle:
    """Drives along its heading and turns: action (speed, angular speed).

    The first action maps [-1, 1] to [0, `max_speed`], the second to +-`max_angular_speed`.
    """

    max_speed: float
    max_angular_speed: float

    def apply(self, actions: Floats, state: RobotState) -> None:
        """Takes (W, 2) actions in [-1, 1] as (speed [m/s], angular speed [rad/s])."""
        state.command[:, 0] = 0.5 * (actions[:, 0] + 1.0) * self.max_speed
        state.command[:, 1] = actions[:, 1] * self.max_angular_speed
        state.angular_speed[:] = state.command[:, 1]

    def drive(self, state: RobotState, dt: float, steps: int) -> Floats:
        """Turns, and returns the (W, steps, 2) velocities to reach, world frame."""
        turn = state.angular_speed[:, None] * (dt * np.arange(1.0, steps + 1.0))
        headings = state.heading[:, None] + turn
        state.heading[:] = wrap_angle(headings[:, -1])
        return state.command[:, :1, None] * direction(headings)

    def rollout(self, state: RobotState, times: Floats) -> Floats:
        """Returns (W, F, 2) positions on the arc that the command describes."""
        turn = state.angular_speed[:, None] * times
        chord = state.command[:, :1] * times * np.sinc(turn / (2.0 * np.pi))
        course = state.heading[:, None] + 0.5 * turn
        return state.position[:, None] + chord[:, :, None] * direction(course)


@dataclass(frozen=True)
class Holonomic:
    """Moves in any direction without turning: action (velocity x, y) in its own frame.

    Actions outside the unit disc are shortened to it; length 1 is `max_speed`.
    """

    max_speed: float

    def apply(self, actions: Floats, state: RobotState) -> None:
        """Takes (W, 2) actions in [-1, 1] as velocities [m/s] in the robot's frame."""
        length = np.sqrt(actions[:, 0] ** 2 + actions[:, 1] ** 2)
        state.command[:] = actions * (self.max_speed / np.maximum(length, 1.0))[:, None]

    def drive(self, state: RobotState, dt: float, steps: int) -> Floats:
        """Returns the (W, steps, 2) velocities to reach, world frame."""
        velocity = to_world(state.command, state.heading)
        return np.repeat(velocity[:, None], steps, axis=1)

    def rollout(self, state: RobotState, times: Floats) -> Floats:
        """Returns (W, F, 2) positions on the straight line that the command describes."""
        velocity = to_world(state.command, state.heading)
        return state.position[:, None] + velocity[:, None] * times[:, None]


@dataclass(frozen=True)
class Bicycle:
    """Drives on two axles and steers the front one: action (speed, steering angle).

    The kinematic bicycle, whose disc is centred over its rear axle (Polack et al. 2017, "The
    kinematic bicycle model"): it turns by tan(steering) / `wheelbase` per metre, so that it cannot
    turn where it stands. The first action maps [-1, 1] to [0, `max_speed`], reached no faster than
    by `max_acceleration`; the second to +-`max_steering`, positive to the left.
    """

    max_speed: float
    max_acceleration: float
    max_steering: float
    wheelbase: float

    def apply(self, actions: Floats, state: RobotState) -> None:
        """Takes (W, 2) actions in [-1, 1] as (speed [m/s], steering angle [rad])."""
        state.command[:, 0] = 0.5 * (actions[:, 0] + 1.0) * self.max_speed
        state.command[:, 1] = actions[:, 1] * self.max_steering

    def drive(self, state: RobotState, dt: float, steps: int) -> Floats:
        """Speeds up, turns, and returns the (W, steps, 2) velocities to reach, world frame."""
        gain = self.max_acceleration * dt * np.arange(1.0, steps + 1.0)
        now = _speed(state)
        speed = now + np.clip(state.command[:, :1] - now, -gain, gain)  # (W, steps)
        turn = self._curvature(state) * dt * speed
        headings = state.heading[:, None] + np.cumsum(turn, axis=1)
        state.heading[:] = wrap_angle(headings[:, -1])
        state.angular_speed[:] = turn[:, -1] / dt
        return speed[..., None] * direction(headings - 0.5 * turn)

    def rollout(self, state: RobotState, times: Floats) -> Floats:
        """Returns (W, F, 2) positions on the arc that the command describes."""
        speed, wanted = _speed(state), state.command[:, :1]
        gain = np.copysign(self.max_acceleration, wanted - speed)
        ramp = np.minimum((wanted - speed) / gain, times)  # (W, F) how long the speed changes
        way = speed * ramp + 0.5 * gain * ramp**2 + wanted * (times - ramp)
        turn = self._curvature(state) * way
        course = state.heading[:, None] + 0.5 * turn
        chord = way * np.sinc(turn / (2.0 * np.pi))
        return np.asarray(state.position[:, None] + chord[:, :, None] * direction(course))

    def _curvature(self, state: RobotState) -> Floats:
        """(W, 1) turn per metre [rad/m]."""
        return np.asarray(np.tan(state.command[:, 1:]) / self.wheelbase)


def make_robot(config: CrowdNavConfig) -> Robot:
    """Returns the robot that `config.robot` names."""
    if config.robot == "unicycle":
        return Unicycle(config.max_speed, config.max_angular_speed)
    if config.robot == "bicycle":
        limits = config.max_acceleration, config.max_steering
        return Bicycle(config.max_speed, *limits, config.wheelbase)
    return Holonomic(config.max_speed)


def turning_limit(config: CrowdNavConfig) -> float:
    """Returns the largest angular speed [rad/s]; 0 for a robot that does not turn."""
    if config.robot == "bicycle":
        return config.max_speed * math.tan(config.max_steering) / config.wheelbase
    return config.max_angular_speed if config.robot == "unicycle" else 0.0


def action_space(config: CrowdNavConfig) -> spaces.Box:
    """Returns the Box of one action, (2,) in [-1, 1]; its meaning is the robot's."""
    return spaces.Box(-1.0, 1.0, (2,), np.float32)


def checked_actions(actions: ArrayLike, worlds: int) -> Floats:
    """Returns (W, 2) actions clipped to [-1, 1].

    Raises:
        ValueError: Wrong shape, no real numbers, or a value that is not finite.
    """
    array = np.asarray(actions)
    if array.dtype.kind not in "fiu":
        raise ValueError(f"actions must be real numbers, got {array.dtype}")
    if array.shape != (worlds, 2):
        raise ValueError(f"actions must have shape {(worlds, 2)}, got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"actions must be finite, got {array.tolist()}")
    return np.clip(array.astype(np.float64), -1.0, 1.0)


def direction(angle: Floats) -> Floats:
    """Returns unit vectors (..., 2) at `angle` (...) radians CCW from +x."""
    return np.stack((np.cos(angle), np.sin(angle)), axis=-1)


def wrap_angle(angle: Floats) -> Floats:
    """Returns the same angles in [-pi, pi)."""
    return np.mod(angle + np.pi, 2.0 * np.pi) - np.pi


def to_world(vectors: Floats, heading: Floats) -> Floats:
    """Rotates vectors (W, ..., 2) from the frames of robots with `heading` (W,) to the world."""
    return _rotated(vectors, heading)


def to_robot(vectors: Floats, heading: Floats) -> Floats:
    """Rotates vectors (W, ..., 2) from the world to the frames of robots with `heading` (W,).

    Subtract the robot's position first if the vectors are points.
    """
    return _rotated(vectors, -heading)


def _speed(state: RobotState) -> Floats:
    """(W, 1) speed of the robots' bodies [m/s]."""
    return np.asarray(np.sqrt((state.velocity**2).sum(axis=-1, keepdims=True)))


def _rotated(vectors: Floats, angle: Floats) -> Floats:
    angle = angle.reshape(-1, *(1,) * (vectors.ndim - 2))
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack((cos * x - sin * y, sin * x + cos * y), axis=-1)
