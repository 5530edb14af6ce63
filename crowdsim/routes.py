"""Where each pedestrian walks to, and what happens on arrival."""

import math
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
import shapely
from numba import njit
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.pedestrians import Pedestrians
from crowdsim.wayfinding import AnchorArray, geodesic_field, next_point

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

ARRIVAL_DISTANCE = 0.5
"""A waypoint counts as reached within this distance [m]."""

PASSING_DISTANCE = 1.5
"""So does one that is behind somebody this near: who was pushed past it does not turn back [m]."""

STOPPING_TIME = 1.0
"""Who is going to stop slows down when the goal is this near at the desired speed [s]."""

ENTRY_GAP = 0.2
"""Free space around somebody who enters [m]."""

STRAIGHT_CLEARANCE = 1.0
"""Ways that stay this far from all walls need no way-finding, even for who is pushed aside [m]."""

GOAL_SPACING = 0.5
"""Waypoints within such a square share the way there, up to the last glimpse [m]."""

STRAIGHT = -1
STOP, RETURN, RESPAWN, LEAVE = 0, 1, 2, 3
_ON_ARRIVAL = {"stop": STOP, "return": RETURN, "respawn": RESPAWN, "leave": LEAVE}

NEVER = np.iinfo(np.int64).max
"""Step at which nobody enters again."""


class Routes:
    """The pedestrians' ways from waypoint to waypoint.

    Attributes:
        points: `(N, G + 1, 2)` start or entrance, and waypoints [m].
        legs: `(N,)` index in `points` of the one being walked to.
        onward: `(N,)` +1 on the way out, -1 on the way back.
        enters_at: `(N,)` step from which on each enters when there is room, if absent.
        next_id: of whoever enters next.
    """

    STATE: ClassVar[tuple[str, ...]] = (
        "points",
        "legs",
        "onward",
        "enters_at",
        "_fields",
        "next_id",
    )

    def __init__(
        self,
        pedestrians: Pedestrians,
        world_map: Map,
        on_arrival: str | Sequence[str],
        entrances: FloatArray | None = None,
        *,
        enters_at: IntArray | None = None,
        goals_change: bool = False,
    ) -> None:
        """Plan all ways, around the obstacles where there are any.

        Args:
            pedestrians: who walks, and where to.
            world_map: what is in the way.
            on_arrival: `stop`, `return`, `respawn` or `leave`, for all or for each.
            entrances: `(N, 2)` where people enter [m]; None is where they start.
            enters_at: `(N,)` step at which those enter who are not there at the start.
            goals_change: whether people may have to come to any goal from anywhere.
        """
        first = pedestrians.position if entrances is None else entrances
        self.points: FloatArray = np.concatenate([first[:, None], pedestrians.waypoints], axis=1)
        self.legs: IntArray = np.ones(len(pedestrians), dtype=np.int64)
        self.onward: IntArray = np.ones(len(pedestrians), dtype=np.int64)
        each = [on_arrival] * len(pedestrians) if isinstance(on_arrival, str) else on_arrival
        self._on_arrival: IntArray = np.array([_ON_ARRIVAL[word] for word in each], dtype=np.int64)
        self._start_velocity = pedestrians.velocity
        self.next_id = len(pedestrians)
        self.enters_at: IntArray = (
            np.zeros(len(pedestrians), dtype=np.int64) if enters_at is None else enters_at
        )
        walked_to = np.ones(self.points.shape[:2], dtype=np.bool_)
        # Nobody but those who return ever walks to the start.
        walked_to[:, 0] = self._on_arrival == RETURN
        by_wall = _needs_field(self.points, world_map)
        if goals_change and len(world_map.segments):
            by_wall[:] = True
        self._anchors, self._fields, self._origin = _plan(
            self.points, walked_to & by_wall, world_map
        )
        self._planned_points, self._planned_fields = self.points.copy(), self._fields.copy()

    @property
    def goals(self) -> FloatArray:
        """Points `(N, 2)` that the pedestrians are walking to now [m]."""
        return self.points[np.arange(len(self.legs)), self.legs]

    @property
    def planned_goals(self) -> FloatArray:
        """Last waypoints `(N, 2)` of all at the start [m]."""
        return self._planned_points[:, -1]

    @property
    def final_goals(self) -> FloatArray:
        """Ends `(N, 2)` of the ways that people are on; starts for those on the way back [m]."""
        return self.points[np.arange(len(self.legs)), self._ends]

    @property
    def _ends(self) -> IntArray:
        return np.where(self.onward > 0, self.points.shape[1] - 1, 0)

    @property
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """All that `steer` and `advance` read and change, as `free_steps` takes it."""
        return (
            self.points,
            self.legs,
            self.onward,
            self.enters_at,
            self._start_velocity,
            self._on_arrival,
            self._fields,
            self._anchors,
            self._origin,
        )

    def redirect(self, person: int, other: int) -> None:
        """Send a person straight to the goal that another one had at the start."""
        end = self._ends[person]
        self.points[person, end] = self._planned_points[other, -1]
        self._fields[person, end] = self._planned_fields[other, -1]
        self.legs[person] = end

    def restart(self, people: IntArray) -> None:
        """Give people, who are absent, the way that was planned for them at the start."""
        self.points[people] = self._planned_points[people]
        self._fields[people] = self._planned_fields[people]

    def steer(self, bodies: FloatArray, desired_speed: FloatArray, direction: FloatArray) -> None:
        """Write the wanted directions `(N, 2)` into the first rows of `direction`.

        They have length 1, less for people who slow down because they stop at their goal.

        Args:
            bodies: `(M, 4)` x, y, vx, vy, pedestrians first.
            desired_speed: `(N,)` [m/s].
            direction: `(M, 2)`, changed in place.
        """
        steer(
            bodies,
            desired_speed,
            self.points,
            self.legs,
            self._fields,
            self._anchors,
            self._origin,
            self._on_arrival,
            direction,
        )

    def advance(
        self, step: int, bodies: FloatArray, radius: FloatArray, present: BoolArray, ids: IntArray
    ) -> None:
        """Send those who arrived to their next waypoint, out of the scene, or in again.

        Args:
            step: how many there have been.
            bodies: `(M, 4)`, changed in place for those who leave or enter.
            radius: `(M,)` [m].
            present: `(M,)`, changed in place likewise.
            ids: `(N,)`; in place, everybody who enters gets an id never used before.
        """
        self.next_id = advance(
            step,
            bodies,
            radius,
            present,
            ids,
            self.next_id,
            self.points,
            self.legs,
            self.onward,
            self.enters_at,
            self._start_velocity,
            self._on_arrival,
        )


def _plan(
    points: FloatArray, needed: BoolArray, world_map: Map
) -> tuple[AnchorArray, IntArray, FloatArray]:
    """Find the geodesic fields that lead to those points `(N, G + 1, 2)` that need one.

    Returns:
        anchors: `(F, H, W)` of all fields.
        fields: `(N, G + 1)` which field leads to which point, `STRAIGHT` where none is needed.
        origin: `(2,)` of the fields' grid [m].
    """
    fields = np.full(points.shape[:2], STRAIGHT, dtype=np.int64)
    rows, legs = np.nonzero(needed)
    if len(rows) == 0:
        return np.zeros((0, 0, 0), dtype=np.int32), fields, np.zeros(2)
    places = np.round(points[rows, legs] / GOAL_SPACING) * GOAL_SPACING
    distinct, field_of = np.unique(places, axis=0, return_inverse=True)
    fields[rows, legs] = field_of
    ways = [geodesic_field(world_map, place) for place in distinct]
    return np.stack([way.anchors for way in ways]), fields, ways[0].origin


def _needs_field(points: FloatArray, world_map: Map) -> BoolArray:
    """Whether walls come near the straight lines that lead to the points `(N, G + 1)`."""
    near = np.zeros(points.shape[:2], dtype=np.bool_)
    if len(world_map.segments) == 0 or len(points) == 0:
        return near
    walls = shapely.multilinestrings(shapely.linestrings(world_map.segments))
    lines = shapely.linestrings(np.stack([points[:, :-1], points[:, 1:]], axis=2))  # (N, G)
    blocked = shapely.dwithin(lines, walls, STRAIGHT_CLEARANCE)
    near[:, 1:] |= blocked
    near[:, :-1] |= blocked
    return near


@njit(cache=True)
def park(bodies: FloatArray, index: int) -> None:
    """Put an absent body where it meets nobody; each has a place of its own."""
    bodies[index, 0] = 1e4 + 10.0 * index
    bodies[index, 1] = -1e4
    bodies[index, 2:] = 0.0


@njit(cache=True)
def steer(
    bodies: FloatArray,
    desired_speed: FloatArray,
    points: FloatArray,
    legs: IntArray,
    fields: IntArray,
    anchors: AnchorArray,
    origin: FloatArray,
    on_arrival: IntArray,
    direction: FloatArray,
) -> None:
    """Do what `Routes.steer` says."""
    for i in range(len(legs)):
        x, y = bodies[i, 0], bodies[i, 1]
        goal = points[i, legs[i]]
        aim_x, aim_y = goal[0], goal[1]
        field = fields[i, legs[i]]
        if field != STRAIGHT:
            aim_x, aim_y = next_point(anchors[field], origin, goal, x, y)
        length = math.hypot(aim_x - x, aim_y - y)
        if on_arrival[i] == STOP and legs[i] == points.shape[1] - 1:
            nearness = math.hypot(goal[0] - x, goal[1] - y) / STOPPING_TIME
            length *= max(1.0, desired_speed[i] / nearness) if nearness > 0 else 1.0
        direction[i, 0] = (aim_x - x) / length if length > 0 else 0.0
        direction[i, 1] = (aim_y - y) / length if length > 0 else 0.0


@njit(cache=True)
def advance(
    step: int,
    bodies: FloatArray,
    radius: FloatArray,
    present: BoolArray,
    ids: IntArray,
    next_id: int,
    points: FloatArray,
    legs: IntArray,
    onward: IntArray,
    enters_at: IntArray,
    start_velocity: FloatArray,
    on_arrival: IntArray,
) -> int:
    """Do what `Routes.advance` says; gives the next unused id."""
    last = points.shape[1] - 1
    for i in range(len(legs)):
        if not present[i]:
            if step >= enters_at[i] and _is_free(bodies, radius, present, i, points[i, 0]):
                bodies[i, :2], bodies[i, 2:] = points[i, 0], start_velocity[i]
                present[i], legs[i], ids[i] = True, 1, next_id
                next_id += 1
        elif _has_arrived(bodies[i], points[i, legs[i] - onward[i]], points[i, legs[i]]):
            at_end = legs[i] == (last if onward[i] > 0 else 0)
            if at_end and (on_arrival[i] == RESPAWN or on_arrival[i] == LEAVE):
                present[i] = False
                enters_at[i] = NEVER if on_arrival[i] == LEAVE else 0
                park(bodies, i)
            elif at_end and on_arrival[i] == RETURN:
                onward[i] = -onward[i]
                legs[i] += onward[i]
            elif not at_end:
                legs[i] += onward[i]
    return next_id


@njit(cache=True)
def _has_arrived(body: FloatArray, before: FloatArray, point: FloatArray) -> bool:
    """Whether a body is at a waypoint, or past it as seen from the one before.

    Who was pushed past a waypoint that is listed twice is past its second copy as well.
    """
    dx, dy = body[0] - point[0], body[1] - point[1]
    distance = math.hypot(dx, dy)
    is_past = dx * (point[0] - before[0]) + dy * (point[1] - before[1]) >= 0
    return distance <= ARRIVAL_DISTANCE or (is_past and distance <= PASSING_DISTANCE)


@njit(cache=True)
def _is_free(
    bodies: FloatArray, radius: FloatArray, present: BoolArray, index: int, place: FloatArray
) -> bool:
    """Whether a body has room at a place `(2,)`."""
    for other in range(len(bodies)):
        room = radius[index] + radius[other] + ENTRY_GAP
        dx, dy = bodies[other, 0] - place[0], bodies[other, 1] - place[1]
        if present[other] and dx * dx + dy * dy < room * room:
            return False
    return True
