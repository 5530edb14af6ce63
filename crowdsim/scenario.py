"""What a world starts from: the map, the people, and the robot's task."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from crowdsim.behaviour import Behaviour
from crowdsim.map import Map
from crowdsim.pedestrians import Pedestrians
from crowdsim.recordings import Recording

OnArrival = Literal["stop", "return", "respawn", "leave"]
ON_ARRIVAL: tuple[OnArrival, ...] = ("stop", "return", "respawn", "leave")


@dataclass(frozen=True, kw_only=True, eq=False)
class Scenario:
    """Frozen initial conditions of one world; `World` runs them.

    World metres, headings in radians CCW from +x.

    Attributes:
        name: Name in `crowdsim.scenarios.SCENARIOS`, or the user's own.
        map: Geometry that physics, wayfinding, lidar and picture share.
        pedestrians: Initial state and goals of the N people. For a replay there is one row per
            recorded track, in the order of `replay.ids`, and the recorded tracks drive them.
        on_arrival: What a person does at the last waypoint: stand there (`stop`), walk the
            waypoints backwards to the start (`return`), leave and enter again as a new person
            with a new id (`respawn`), or leave for good (`leave`). One word for all, or one for
            each of the N people.
        entrances: (N, 2) where each person enters [m]; None means at the start. People
            start somewhere on the way from there to their first waypoint.
        entry_times: (N,) time at which each person enters, or as soon after it as there is room
            [s]; 0 is there from the start. None means all are.
        behaviour: What people do besides walking; None means nothing.
        robot_start: Robot's x, y [m] and heading [rad].
        robot_goal: Robot's goal x, y [m].
        time_limit: Time the robot has [s].
        replay: Recorded tracks that drive the people instead of forces; its rows must be evenly
            spaced in time (`Recording.regular`).
        replay_start: Row of `replay` at world time 0.

    Raises:
        ValueError: A field is out of range or the robot starts or ends where nobody can stand.
    """

    name: str
    map: Map
    pedestrians: Pedestrians
    robot_start: tuple[float, float, float]
    robot_goal: tuple[float, float]
    on_arrival: OnArrival | tuple[OnArrival, ...] = "stop"
    entrances: NDArray[np.float64] | None = None
    entry_times: NDArray[np.float64] | None = None
    behaviour: Behaviour | None = None
    time_limit: float = 30.0
    replay: Recording | None = None
    replay_start: int = 0

    def __post_init__(self) -> None:
        self._check_on_arrival()
        if not (np.isfinite(self.time_limit) and self.time_limit > 0.0):
            raise ValueError(f"time_limit must be positive seconds, got {self.time_limit}")
        self._check_entering()
        self._check_robot()
        if self.replay is not None:
            self._check_replay(self.replay)

    def _check_on_arrival(self) -> None:
        one_word = isinstance(self.on_arrival, str)
        words = {self.on_arrival} if one_word else set(self.on_arrival)
        if not words <= set(ON_ARRIVAL):
            raise ValueError(f"on_arrival must be one of {ON_ARRIVAL}, got {self.on_arrival!r}")
        if not one_word and len(self.on_arrival) != len(self.pedestrians):
            raise ValueError(
                f"on_arrival must be one word, or one for each of {len(self.pedestrians)} people, "
                f"got {len(self.on_arrival)}"
            )

    def _check_entering(self) -> None:
        positions, times = self.pedestrians.position, self.entry_times
        one_word = isinstance(self.on_arrival, str)
        if (
            self.entrances is not None
            and one_word
            and self.on_arrival != "respawn"
            and times is None
        ):
            raise ValueError(
                f"entrances need on_arrival='respawn' or entry_times, got {self.on_arrival!r}"
            )
        if self.entrances is not None and self.entrances.shape != positions.shape:
            raise ValueError(f"entrances must be {positions.shape}, got {self.entrances.shape}")
        if times is None:
            return
        if times.shape != (len(positions),):
            raise ValueError(f"entry_times must be {(len(positions),)}, got {times.shape}")
        if not (np.isfinite(times).all() and (times >= 0.0).all()):
            raise ValueError(f"entry_times must be finite seconds >= 0, got {times.min()}")

    def _check_robot(self) -> None:
        start, goal = np.asarray(self.robot_start), np.asarray(self.robot_goal)
        if start.shape != (3,) or goal.shape != (2,):
            raise ValueError(
                "robot_start must be (x, y, heading) and robot_goal (x, y), "
                f"got {self.robot_start} and {self.robot_goal}"
            )
        for name, point in (("robot_start", start[:2]), ("robot_goal", goal)):
            if not (np.isfinite(point).all() and self.map.walkable(point)):
                raise ValueError(f"{name} must be a walkable point of the map, got {point}")

    def _check_replay(self, replay: Recording) -> None:
        steps, people = replay.valid.shape
        if self.behaviour is not None or self.entry_times is not None:
            raise ValueError("a replay takes no behaviour and no entry_times, got some")
        if not 0 <= self.replay_start < steps:
            raise ValueError(f"replay_start must be in 0..{steps - 1}, got {self.replay_start}")
        if len(self.pedestrians.position) != people:
            raise ValueError(
                f"a replay of {people} tracks needs as many pedestrians, "
                f"got {len(self.pedestrians.position)}"
            )
