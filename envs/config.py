"""What one environment is made of: every keyword of `gymnasium.make`, with units and checks."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, get_args

if TYPE_CHECKING:
    from predictor.forecaster import Forecaster

RobotKind = Literal["unicycle", "holonomic", "bicycle"]


@dataclass(frozen=True, kw_only=True)
class CrowdNavConfig:
    """Keywords of `gymnasium.make("crowdnav/CrowdNav-v0", ...)`.

    All of them fit into JSON, but for a forecaster that is handed in as an object.

    Attributes:
        scenario: Name in `crowdsim.scenarios.SCENARIOS`, several joined by `+`, of which every
            episode draws one, or a scenario file.
        scenario_parameters: Keywords of that scenario.
        robot: `unicycle` takes (speed, angular speed), `holonomic` a velocity in its own frame,
            `bicycle` (speed, steering angle).
        robot_visible: Whether pedestrians yield to the robot and the forecaster may use it as a
            neighbor. Bodies collide either way.
        robot_awareness: Share of the pedestrians who notice a visible robot, drawn per episode.
        crowd_speed: Factor on everybody's desired speed; recorded people keep theirs.
        forecaster: `none`, `constant_velocity`, `constant_velocity_map` (stops at walls),
            `social_force` (rolls that model on), `fast` or `iterative_attention` (networks), the
            path of a checkpoint, `oracle` (the simulator run ahead under the robot's present
            command), `oracle_noisy@sigma=METRES+delay=SECONDS+drop=SHARE`, or a forecaster itself.
        horizon: How far forecasts reach [s]; a whole number of `frame_dt`.
        modes_observed: M, how many of the ways that each of them may go are in the observation, the
            likeliest first; needs a forecaster with modes.
        pedestrians_observed: K, the number of nearest visible pedestrians in the observation.
        sensor_range: How far the robot sees people and walls [m].
        field_of_view: Full angle around the heading in which the robot sees people [rad].
        occlusion: Whether walls, buildings and people hide people from the robot.
        missed_detections: Share of the detections, once per policy step, that are missed.
        position_noise: Standard deviation of each measured coordinate of a person [m].
        frame_jitter: How much older a detection may be than the robot takes it for, drawn per
            world and policy step [s]; at most `policy_dt`, so that none overtakes another.
        track_loss_rate: How often the robot takes somebody for somebody new, whose history begins
            anew [1/s].
        track_memory: How long the robot goes on reckoning with somebody out of sight, by the last
            forecast of them or else at constant velocity [s].
        lidar_rays: Number of lidar rays over the full circle.
        observe_map: Whether the observation holds the map crop.
        physics_dt: Time of one physics step [s].
        policy_dt: Time of one environment step [s]; a whole number of `physics_dt`.
        frame_dt: Time between the frames of histories and forecasts [s]; a whole number of
            `policy_dt`.
        history_steps: Number of frames in a history; the last one is now.
        history_kept: How many of them the robot remembers, the older ones are not valid; `None` is
            all.
        max_speed: Robot's speed limit [m/s].
        max_angular_speed: Unicycle's turning limit [rad/s]; the holonomic robot does not turn.
        max_steering: Bicycle's steering limit [rad].
        wheelbase: Distance of the bicycle's axles [m].
        max_acceleration: Limit on the change of the robot's velocity [m/s^2].
        robot_radius: Radius of the robot's disc [m].
        goal_radius: The goal is reached when the robot's centre is nearer than this [m].
        time_limit: Time the robot has for a way to its goal [s]; `None` takes the scenario's.
        mission: The robot goes to and fro between its goal and its start until it arrives after
            so many seconds [s]; each way has the time limit. 0 is a single way.
        progress_weight: Reward per metre that the way to the goal has become shorter.
        goal_weight: Reward for reaching the goal.
        collision_weight: Reward (negative) for touching a person or a wall.
        discomfort_distance: Clearance below which people feel uneasy [m].
        discomfort_weight: Reward (negative) per second at zero clearance, linear up to
            `discomfort_distance`.
        predicted_intrusion_weight: Reward (negative) per second for being about to run through
            the forecast position of a person; see `envs.rewards.predicted_intrusion`.
        predicted_intrusion_decay: Time after which a predicted intrusion counts 1/e as much [s].
        time_weight: Reward (negative) per second.

    Raises:
        ValueError: A value is out of range, or the clocks are not whole multiples of each other.
    """

    scenario: str = "circular_crossing"
    scenario_parameters: Mapping[str, Any] = field(default_factory=dict)
    robot: RobotKind = "unicycle"
    robot_visible: bool = True
    robot_awareness: float = 1.0
    crowd_speed: float = 1.0
    forecaster: str | Forecaster = "fast"
    horizon: float = 4.8
    modes_observed: int = 0
    pedestrians_observed: int = 8
    sensor_range: float = 10.0
    field_of_view: float = 2.0 * math.pi
    occlusion: bool = False
    missed_detections: float = 0.0
    position_noise: float = 0.0
    frame_jitter: float = 0.0
    track_loss_rate: float = 0.0
    track_memory: float = 0.0
    lidar_rays: int = 64
    observe_map: bool = False
    physics_dt: float = 0.05
    policy_dt: float = 0.2
    frame_dt: float = 0.4
    history_steps: int = 8
    history_kept: int | None = None
    max_speed: float = 1.2
    max_angular_speed: float = 1.5
    max_steering: float = 0.6
    wheelbase: float = 0.5
    max_acceleration: float = 2.5
    robot_radius: float = 0.3
    goal_radius: float = 0.3
    time_limit: float | None = None
    mission: float = 0.0
    progress_weight: float = 1.0
    goal_weight: float = 10.0
    collision_weight: float = -10.0
    discomfort_distance: float = 0.45
    discomfort_weight: float = -2.0
    predicted_intrusion_weight: float = -1.0
    predicted_intrusion_decay: float = 2.0
    time_weight: float = -0.1

    def __post_init__(self) -> None:
        for name in ("robot_visible", "observe_map", "occlusion"):
            if not isinstance(getattr(self, name), bool):
                raise ValueError(f"{name} must be true or false, got {getattr(self, name)!r}")
        if self.robot not in get_args(RobotKind):
            raise ValueError(f"robot must be one of {get_args(RobotKind)}, got {self.robot!r}")
        for name in ("robot_awareness", "missed_detections"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name} must be in 0..1, got {getattr(self, name)!r}")
        for name in _NOT_NEGATIVE:
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) >= 0.0):
                raise ValueError(f"{name} must be at least 0, got {getattr(self, name)!r}")
        if self.frame_jitter > self.policy_dt:
            raise ValueError(
                f"frame_jitter must be at most policy_dt={self.policy_dt} s, "
                f"got {self.frame_jitter!r}"
            )
        if self.field_of_view > 2.0 * math.pi:
            raise ValueError(f"field_of_view must be at most 2 pi, got {self.field_of_view!r}")
        if self.max_steering >= 0.5 * math.pi:
            raise ValueError(f"max_steering must be below pi / 2, got {self.max_steering!r}")
        if self.modes_observed != 0:
            _check_count("modes_observed", self.modes_observed)
            if self.forecaster == "none":
                raise ValueError("modes_observed needs a forecaster, got forecaster 'none'")
        for name in _POSITIVE:
            _check_positive(name, getattr(self, name))
        if self.time_limit is not None:
            _check_positive("time_limit", self.time_limit)
        for name in ("pedestrians_observed", "lidar_rays", "history_steps"):
            _check_count(name, getattr(self, name))
        if self.history_kept is not None:
            _check_count("history_kept", self.history_kept)
        for name in _WEIGHTS:
            if not math.isfinite(getattr(self, name)):
                raise ValueError(f"{name} must be finite, got {getattr(self, name)!r}")
        whole_multiple("policy_dt", self.policy_dt, "physics_dt", self.physics_dt)
        whole_multiple("frame_dt", self.frame_dt, "policy_dt", self.policy_dt)
        whole_multiple("horizon", self.horizon, "frame_dt", self.frame_dt)

    @property
    def forecast_steps(self) -> int:
        """Number of forecast frames F."""
        return round(self.horizon / self.frame_dt)

    @property
    def physics_steps(self) -> int:
        """Number of physics steps in one environment step."""
        return round(self.policy_dt / self.physics_dt)

    @property
    def perfect_sensor(self) -> bool:
        """Whether the robot sees all within its range exactly as it is."""
        return (
            self.field_of_view == 2.0 * math.pi
            and not self.occlusion
            and self.missed_detections == self.position_noise == 0.0
            and self.track_loss_rate == self.frame_jitter == 0.0
        )

    @property
    def policy_steps_per_frame(self) -> int:
        """Number of environment steps from one frame to the next."""
        return round(self.frame_dt / self.policy_dt)


_NOT_NEGATIVE = ("position_noise", "frame_jitter", "track_loss_rate", "track_memory", "mission")
_POSITIVE = (
    "crowd_speed",
    "horizon",
    "sensor_range",
    "field_of_view",
    "physics_dt",
    "policy_dt",
    "frame_dt",
    "max_speed",
    "max_angular_speed",
    "max_steering",
    "wheelbase",
    "max_acceleration",
    "robot_radius",
    "goal_radius",
    "discomfort_distance",
    "predicted_intrusion_decay",
)
_WEIGHTS = tuple(
    item.name for item in dataclasses.fields(CrowdNavConfig) if item.name.endswith("_weight")
)


def make_config(**keywords: Any) -> CrowdNavConfig:
    """Builds the configuration from keywords of `gymnasium.make`.

    Raises:
        ValueError: An unknown keyword (the message lists the known ones) or a bad value.
    """
    known = [item.name for item in dataclasses.fields(CrowdNavConfig)]
    unknown = sorted(set(keywords) - set(known))
    if unknown:
        raise ValueError(f"unknown keyword {', '.join(unknown)}; known are {', '.join(known)}")
    return CrowdNavConfig(**keywords)


def whole_multiple(long_name: str, long: float, short_name: str, short: float) -> int:
    """Returns how often the clock `short` fits into `long`, both in seconds.

    Raises:
        ValueError: `long` is not a whole multiple (at least one) of `short`.
    """
    steps = round(long / short)
    if steps < 1 or abs(steps * short - long) > 1e-6 * long:
        raise ValueError(
            f"{long_name} must be a whole multiple of {short_name}={short} s, got {long} s"
        )
    return steps


def _check_positive(name: str, value: float) -> None:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{name} must be a positive number, got {value!r}")
    if not (math.isfinite(value) and value > 0.0):
        raise ValueError(f"{name} must be a positive number, got {value!r}")


def _check_count(name: str, value: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ValueError(f"{name} must be a positive whole number, got {value!r}")
