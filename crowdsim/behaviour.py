"""What people do besides walking to their goals: pause, stop dead, change their minds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.pedestrians import ALONE

if TYPE_CHECKING:
    from crowdsim.routes import Routes

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

BRAKING = 5.0
"""Deceleration of who stops dead [m/s^2]: from 1.34 m/s within 0.3 s, less than one stride."""

GOAL_CHANGE = 2.0
"""A goal nearer than this to the present one is no other goal [m]."""

DRAWS = 5
"""Numbers per person and step: for pause, pause at a waypoint, stop, change; how long or whose."""

WALKING = 0.1
"""Who wants less than this share of the desired speed stands already, at the goal."""


@dataclass(frozen=True, kw_only=True)
class Behaviour:
    """How often people do what; nothing unless told, and members of a group do it together.

    What happens is drawn from a random stream of its own, anew in each step and for everybody who
    walks. Each pause and stop lasts 50 to 150 % of its mean time.

    Attributes:
        pause_rate: how often somebody slows down and waits; steps aside if need be [1/s].
        pause_time: mean length of it [s].
        waypoint_pause: share of the waypoints on the way, and of the ends where people turn back,
            at which they pause besides, 0 to 1.
        stop_rate: how often somebody stops dead, in less than a stride [1/s].
        stop_time: mean length of it [s].
        goal_change_rate: how often somebody changes over to another person's goal, at least
            `GOAL_CHANGE` from the own one, and walks straight there [1/s].
    """

    pause_rate: float = 0.0
    pause_time: float = 4.0
    waypoint_pause: float = 0.0
    stop_rate: float = 0.0
    stop_time: float = 1.5
    goal_change_rate: float = 0.0

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ValueError: if a number is not finite or negative, or the share of waypoints over 1.
        """
        for name, value in vars(self).items():
            if not (math.isfinite(value) and value >= 0):
                raise ValueError(f"behaviour {name}: expected a finite value >= 0, found {value}")
        if self.waypoint_pause > 1:
            raise ValueError(
                f"behaviour waypoint_pause: expected 0 to 1, found {self.waypoint_pause}"
            )

    @classmethod
    def of(cls, settings: Behaviour | Mapping[str, float]) -> Behaviour:
        """Read a behaviour from settings by name, as a scenario file or an environment has them.

        Raises:
            ValueError: if a name is unknown, or a number out of range.
        """
        if isinstance(settings, Behaviour):
            return settings
        known = [column.name for column in fields(cls)]
        unknown = sorted(set(settings) - set(known))
        if unknown:
            raise ValueError(f"behaviour: expected {', '.join(known)}, found {', '.join(unknown)}")
        return cls(**settings)


class Distractions:
    """What the people of one world are doing besides walking.

    Attributes:
        stands_until: `(N,)` step at which each walks on; those before the present one are over.
        brakes: `(N,)` who of those who stand stopped dead.
    """

    STATE: ClassVar[tuple[str, ...]] = ("stands_until", "brakes", "_step", "_legs", "_rng")

    def __init__(
        self, behaviour: Behaviour, group: IntArray, *, rng: np.random.Generator, dt: float
    ) -> None:
        """Begin with everybody walking.

        Args:
            behaviour: how often people do what.
            group: `(N,)` who walks with whom, as in `Pedestrians`.
            rng: source of all draws.
            dt: length of a step [s].
        """
        count = len(group)
        self._behaviour = behaviour
        # Floats, whatever was given: the kernel would be compiled anew for whole numbers.
        self._pause = (
            float(behaviour.pause_rate * dt),
            float(behaviour.waypoint_pause),
            float(behaviour.pause_time),
        )
        self._stop = (float(behaviour.stop_rate * dt), float(behaviour.stop_time))
        self._rng = rng
        self._dt = dt
        # Who decides for each: the first member of the group.
        first = np.append(True, (group[1:] != group[:-1]) | (group[1:] == ALONE))[:count]
        self._decider: IntArray = np.maximum.accumulate(np.where(first, np.arange(count), 0))
        self._step = 0
        self._legs: IntArray = np.ones(count, dtype=np.int64)
        self.stands_until: IntArray = np.zeros(count, dtype=np.int64)
        self.brakes: BoolArray = np.zeros(count, dtype=np.bool_)

    def distract(
        self, routes: Routes, bodies: FloatArray, present: BoolArray, direction: FloatArray
    ) -> None:
        """Draw what begins in this step, and hold those who stand.

        Args:
            routes: where everybody is walking; changed for those who change their minds.
            bodies: `(M, 4)` x, y, vx, vy, pedestrians first; who stops dead is slowed down.
            present: `(M,)` who is there.
            direction: `(M, 2)` wanted direction; zero afterwards for who stands.
        """
        count = len(self.stands_until)
        absent = np.flatnonzero(~present[:count])
        if len(absent):
            routes.restart(absent)
            self.stands_until[absent], self._legs[absent] = 0, 1
        chance = self._rng.random((count, DRAWS))[self._decider]
        at_waypoint = (routes.legs != self._legs)[self._decider]
        self._step += 1
        walking = _hold(
            self._step,
            self._pause,
            self._stop,
            self._dt,
            chance,
            at_waypoint,
            bodies,
            present,
            direction,
            self.stands_until,
            self.brakes,
        )
        changes = chance[:, 3] < self._behaviour.goal_change_rate * self._dt
        for person in np.flatnonzero(walking & changes):
            self._change_goal(routes, int(person), chance[person, 4])
        self._legs[:] = routes.legs

    def _change_goal(self, routes: Routes, person: int, chance: float) -> None:
        apart = np.linalg.norm(
            routes.planned_goals - routes.final_goals[self._decider[person]], axis=1
        )
        others = np.flatnonzero(apart > GOAL_CHANGE)
        if len(others):
            routes.redirect(person, others[int(chance * len(others))])


@njit(cache=True)
def _hold(
    step: int,
    pause: tuple[float, float, float],
    stop: tuple[float, float],
    dt: float,
    chance: FloatArray,
    at_waypoint: BoolArray,
    bodies: FloatArray,
    present: BoolArray,
    direction: FloatArray,
    stands_until: IntArray,
    brakes: BoolArray,
) -> BoolArray:
    """Let those stand whose time to do so begins or lasts, and tell who walks `(N,)`.

    Args:
        step: number of the present step.
        pause: chance to begin one in a step, chance at a waypoint, mean length [s].
        stop: chance to begin one in a step, mean length [s].
        dt: length of a step [s].
        chance: `(N, DRAWS)` uniform draws in 0 to 1.
        at_waypoint: `(N,)` who has just reached one.
        bodies: `(M, 4)`, slowed down for who stops dead.
        present: `(M,)` who is there.
        direction: `(M, 2)`, zero afterwards for who stands.
        stands_until: `(N,)` step at which each walks on, changed in place.
        brakes: `(N,)` who stops dead, likewise.
    """
    walking = np.zeros(len(stands_until), dtype=np.bool_)
    for i in range(len(stands_until)):
        wants = math.hypot(direction[i, 0], direction[i, 1]) > WALKING
        if present[i] and wants and step >= stands_until[i]:
            stops = chance[i, 2] < stop[0]
            pauses = chance[i, 0] < pause[0] or (at_waypoint[i] and chance[i, 1] < pause[1])
            walking[i] = not (stops or pauses)
            if not walking[i]:
                seconds = (stop[1] if stops else pause[2]) * (0.5 + chance[i, 4])
                stands_until[i] = step + round(seconds / dt)
                brakes[i] = stops
        if step < stands_until[i]:
            direction[i] = 0.0
            if brakes[i]:
                speed = math.hypot(bodies[i, 2], bodies[i, 3])
                left = max(0.0, speed - BRAKING * dt)
                bodies[i, 2:] *= left / speed if speed > 0 else 0.0
    return walking
