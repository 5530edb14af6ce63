"""Scenarios that a user describes: a map, flows of people from region to region, a robot's task."""

import dataclasses
import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.behaviour import Behaviour
from crowdsim.groups import draw_groups
from crowdsim.map import Map
from crowdsim.motion import ModelChoice
from crowdsim.pedestrians import ALONE, Pedestrians
from crowdsim.scenario import OnArrival, Scenario
from crowdsim.scenarios.placement import place_parties
from crowdsim.scenarios.regions import PlaceChoice, Points, Region
from crowdsim.scenarios.walks import formation, shifted

FloatArray = NDArray[np.float64]

MOST_PEOPLE: Final = 1000
"""In one flow; the groups of each flow are numbered from a multiple of this on."""
SLOWEST: Final = 0.3
"""Drawn desired speeds are at least this [m/s]."""


@dataclass(frozen=True, kw_only=True)
class Flow:
    """People with the same task.

    Attributes:
        count: Least and greatest number of people.
        start: Where they start, and enter again.
        via: Where they pass, in order.
        goal: Where they walk to.
        desired_speed: Mean and deviation of a normal distribution [m/s]; None is that of
            `Pedestrians.draw`. A mean of 0 makes them stand, facing their goal.
        groups: Share of them who walk in groups, 0 to 1.
        spread: Whether they begin anywhere on the walk to their first point, as if they had long
            been coming, instead of all at the start.
        on_arrival: What they do at their goal, see `Scenario`.
        model: Motion model of all, or the share of each.
    """

    count: tuple[int, int]
    start: Region
    goal: Region
    via: tuple[Region, ...] = ()
    desired_speed: tuple[float, float] | None = None
    groups: float = 0.0
    spread: bool = False
    on_arrival: OnArrival = "respawn"
    model: ModelChoice = "social_force"


@dataclass(frozen=True, kw_only=True, eq=False)
class Description:
    """A scenario before anything is drawn.

    Attributes:
        source: Where it is described, for messages.
        name: What the scenario is called.
        ground: Its map, or the place that it is drawn from.
        flows: Its people.
        robot_start: Region, or the pose x, y, heading [m, rad]; with a region the robot faces its
            goal.
        robot_goal: Region.
        behaviour: What people do besides walking; None means nothing.
        time_limit: Time that the robot has [s].
    """

    source: str
    name: str
    ground: Map | PlaceChoice
    flows: tuple[Flow, ...]
    robot_start: Region
    robot_goal: Region
    behaviour: Behaviour | None = None
    time_limit: float = 30.0

    def draw(self, rng: np.random.Generator, *, model: ModelChoice | None = None) -> Scenario:
        """Draw the initial conditions of one world.

        Args:
            rng: Source of all draws; robot and flows have streams of their own.
            model: Motion model of all, or the share of each; None leaves it to the flows.

        Raises:
            ValueError: Too many people for their regions, or no free point in one.
        """
        try:
            return self._draw(rng, model)
        except ValueError as error:
            raise ValueError(f"{self.source}: {error}") from error

    def _draw(self, rng: np.random.Generator, model: ModelChoice | None) -> Scenario:
        ground_rng, robot_rng, *flow_rngs = rng.spawn(2 + len(self.flows))
        points = Points(self.ground, ground_rng)
        robot_start, robot_goal = self._robot_task(points, robot_rng)
        crowds = [
            _Crowd(flow, points, flow_rng, index * MOST_PEOPLE)
            for index, (flow, flow_rng) in enumerate(zip(self.flows, flow_rngs, strict=True))
        ]
        _put_down(crowds, robot_start[:2])
        return Scenario(
            name=self.name,
            map=points.map,
            pedestrians=_joined(crowds, model),
            on_arrival=tuple(crowd.flow.on_arrival for crowd in crowds for _ in crowd.group),
            entrances=np.concatenate([crowd.entrances for crowd in crowds]),
            behaviour=self.behaviour,
            robot_start=robot_start,
            robot_goal=robot_goal,
            time_limit=self.time_limit,
        )

    def _robot_task(
        self, points: Points, rng: np.random.Generator
    ) -> tuple[tuple[float, float, float], tuple[float, float]]:
        """Pose to start from and goal."""
        start = self.robot_start
        if len(start) == 3:
            x, y, heading = (float(value) for value in start)
            goal_x, goal_y = points.way(rng, ((x, y), self.robot_goal))[1].tolist()
            return (x, y, heading), (goal_x, goal_y)
        (x, y), (goal_x, goal_y) = points.way(rng, (start, self.robot_goal)).tolist()
        return (x, y, math.atan2(goal_y - y, goal_x - x)), (goal_x, goal_y)


class _Crowd:
    """The people of one flow: who is with whom, and the ways."""

    def __init__(
        self, flow: Flow, points: Points, rng: np.random.Generator, first_group: int
    ) -> None:
        self.flow = flow
        self.count = int(rng.integers(flow.count[0], flow.count[1], endpoint=True))
        group = draw_groups(rng, self.count, flow.groups)
        self.group = np.where(group == ALONE, ALONE, group + first_group)
        self._regions = (flow.start, *flow.via, flow.goal)
        self._points = points
        self._rng = rng
        self._ways = np.empty((self.count, len(self._regions), 2))
        self._begin = np.empty((self.count, 2))

    def draw_party(self, first: int, size: int) -> FloatArray:
        """Draw the way of those who walk together; returns their starts (size, 2)."""
        way = self._points.way(self._rng, self._regions)
        _, across = formation(size, lane=math.inf)
        lines = np.array([shifted(way, left) for left in across])  # (size, 1 + G, 2)
        free = self._points.are_free(lines)
        self._ways[first : first + size] = np.where(free[..., None], lines, way)
        if self.flow.spread:
            self._begin[first : first + size] = self._points.on_the_walk(self._rng, way, size)
        else:
            self._begin[first : first + size] = lines[:, 0]
        begin = self._begin[first : first + size]
        # Nothing keeps clear of NaN: who stands in a wall is drawn again.
        return np.where(self._points.are_free(begin)[:, None], begin, np.nan)

    @property
    def entrances(self) -> FloatArray:
        """(N, 2) where their ways begin [m]."""
        return self._ways[:, 0]

    def people(self, length: int, model: ModelChoice | None) -> Pedestrians:
        """Those who were put down, with `length` waypoints each; the goal is repeated."""
        goals = self._ways[:, 1:]
        padding = np.repeat(goals[:, -1:], length - goals.shape[1], axis=1)
        return Pedestrians.draw(
            self._rng,
            position=self._begin,
            waypoints=np.concatenate([goals, padding], axis=1),
            desired_speed=self._speeds(),
            model=self.flow.model if model is None else model,
            group=self.group,
        )

    def _speeds(self) -> FloatArray | None:
        if self.flow.desired_speed is None:
            return None
        mean, deviation = self.flow.desired_speed
        if mean == 0.0:
            return np.zeros(self.count)
        return np.maximum(self._rng.normal(mean, deviation, self.count), SLOWEST)


def _put_down(crowds: list[_Crowd], robot: tuple[float, ...]) -> None:
    """Give everybody a free start of their own, flow after flow."""
    ends = np.cumsum([crowd.count for crowd in crowds])

    def draw(row: int, size: int) -> FloatArray:
        index = int(np.searchsorted(ends, row, side="right"))
        crowd = crowds[index]
        return crowd.draw_party(row - int(ends[index]) + crowd.count, size)

    group = np.concatenate([crowd.group for crowd in crowds])
    place_parties(group, draw, keep_away=[robot])


def _joined(crowds: list[_Crowd], model: ModelChoice | None) -> Pedestrians:
    """The people of all flows as one crowd."""
    length = max(1 + len(crowd.flow.via) for crowd in crowds)
    parts = [crowd.people(length, model) for crowd in crowds]
    columns = [column.name for column in dataclasses.fields(Pedestrians)]
    return Pedestrians(
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in columns}
    )
