"""What happened in one episode, as metrics, player and renderer read it."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from crowdsim.scenario import Scenario

TerminationReason = Literal["goal", "collision_pedestrian", "collision_wall", "timeout"]
CollisionRole = Literal["robot_on_person", "person_on_robot"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Trace:
    """One finished episode at the policy clock, world frame, SI units.

    T rows: row 0 is the reset, row t the state after step t. Entries of pedestrians that are not
    there (`valid` False) are 0. What accumulates over a step (clearances, social work, seconds)
    stands in the row that the step led to; row 0 holds the value at the reset.

    Attributes:
        scenario: The initial conditions (map, goal, time limit, ...) this episode started from.
        world_seed: Seed of the world's random stream; with `scenario` it rebuilds the world.
        physics_dt: Time of one physics step [s].
        dt: Time between rows [s].
        frame_dt: Time between forecast steps [s].
        time_limit: Time the robot had for each way [s].
        mission: How long it was to go to and fro [s]; 0 is a single way.
        robot_radius: Robot's radius [m].
        robot_position: (T, 2).
        robot_velocity: (T, 2).
        robot_heading: (T,) radians, CCW from +x.
        robot_goal: (T, 2) where it was to go; from the row of an arrival on the next goal.
        goal_radius: Distance at which the goal counts as reached [m].
        shortest_path_lengths: (L,) length of the shortest path on the map from where each of the
            `ways` began to its goal [m].
        position: (T, N, 2) pedestrians.
        velocity: (T, N, 2) pedestrians.
        valid: (T, N), whether that pedestrian is there.
        ids: (T, N); a slot that is filled anew gets a new id.
        radius: (N,) pedestrians' radii [m].
        visible: (T, N), whether the robot saw that pedestrian.
        clearance_pedestrian: (T,) smallest distance, surface to surface, to any pedestrian over the
            physics steps of that row [m]; infinite where nobody is there.
        clearance_wall: (T,) likewise to walls and obstacles; infinite on a map without any.
        forecast: (T, K, F, 2) forecasts made at each row for the observed pedestrians, or None.
        forecast_ids: (T, K) whom they are for, -1 where the slot is empty, or None.
        forecast_radius: (T, K, F) within which 9 in 10 are expected of the forecast [m], or None.
        forecast_frames_seen: (T, K) frames of history that each forecast was made from, or None.
        forecast_seconds: (T,) wall-clock time that the forecaster took for this row's forecasts,
            shared evenly by the worlds of the batch [s]; 0 without a forecaster.
        social_work: (T,) social force on the robot plus those that the robot exerts on people,
            magnitudes in m/s^2, times the duration of the step [m/s].
        rewards: Named terms of the reward, each (T,), weighted; 0 in row 0.
        termination_reason: Why the episode ended.
        collision_role: On contact with a person, who moved faster toward the other; else None.
        branches: What else might have happened from some rows on; empty unless asked for.
    """

    scenario: Scenario
    world_seed: np.random.SeedSequence
    physics_dt: float
    dt: float
    frame_dt: float
    time_limit: float
    mission: float
    robot_radius: float
    robot_position: NDArray[np.float64]
    robot_velocity: NDArray[np.float64]
    robot_heading: NDArray[np.float64]
    robot_goal: NDArray[np.float64]
    goal_radius: float
    shortest_path_lengths: NDArray[np.float64]
    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    valid: NDArray[np.bool_]
    ids: NDArray[np.int64]
    radius: NDArray[np.float64]
    visible: NDArray[np.bool_]
    clearance_pedestrian: NDArray[np.float64]
    clearance_wall: NDArray[np.float64]
    forecast: NDArray[np.float64] | None
    forecast_ids: NDArray[np.int64] | None
    forecast_radius: NDArray[np.float64] | None
    forecast_frames_seen: NDArray[np.int64] | None
    forecast_seconds: NDArray[np.float64]
    social_work: NDArray[np.float64]
    rewards: dict[str, NDArray[np.float64]]
    termination_reason: TerminationReason
    collision_role: CollisionRole | None
    branches: "tuple[Branch, ...]" = ()

    @property
    def duration(self) -> float:
        """Time from the reset to the last row [s]."""
        return (len(self.robot_position) - 1) * self.dt

    @property
    def ways(self) -> tuple[slice, ...]:
        """Rows of the L ways to a goal, ends included; a single one unless in a mission.

        All but the last led to their goals; that one did if `termination_reason` says so.
        """
        turned = np.flatnonzero((np.diff(self.robot_goal, axis=0) != 0.0).any(axis=1)) + 1
        ends = [0, *turned.tolist(), len(self.robot_position) - 1]
        return tuple(slice(first, last + 1) for first, last in pairwise(ends))


@dataclass(frozen=True, kw_only=True, eq=False)
class TwinTrace:
    """The same crowd in the same world with another robot or none, T rows.

    Attributes:
        dt: Time between rows [s].
        position: (T, N, 2) pedestrians, world frame [m].
        velocity: (T, N, 2) [m/s].
        valid: (T, N), whether that pedestrian is there.
        ids: (T, N).
    """

    dt: float
    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    valid: NDArray[np.bool_]
    ids: NDArray[np.int64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Branch:
    """Where people would have gone from one row of a trace on, had the robot not driven on.

    Row k of each twin is k + 1 forecast steps later; both have the columns of the trace.

    Attributes:
        row: Row of the trace that the twins branch off from, in the same state in every respect.
        absent: The robot is gone.
        standing: The robot brakes and stands.
    """

    row: int
    absent: TwinTrace
    standing: TwinTrace
