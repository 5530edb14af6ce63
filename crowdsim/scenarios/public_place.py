"""A generated place: people between its doors, gates and stops, and a robot on an errand."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.groups import draw_groups
from crowdsim.map import Map
from crowdsim.maps.places import LAYOUTS, make_place
from crowdsim.motion import ModelChoice
from crowdsim.pedestrians import Pedestrians
from crowdsim.routes import GOAL_SPACING
from crowdsim.scenario import Scenario
from crowdsim.scenarios.placement import place_parties, require_count, require_range
from crowdsim.scenarios.walks import ABREAST
from crowdsim.wayfinding import GeodesicField, geodesic_field

FloatArray = NDArray[np.float64]

DRAWN: Final = 8
"""Places of a kind that are drawn from unless one is asked for: physics keeps what it derives from
them. `mixed` training sets keep to others."""
GATES: Final = 6
"""Gates of a place that are in use; way-finding is computed once for each."""
STOPS: Final = 3
"""Shops and benches that people call at."""
CALLING: Final = 0.3
"""Share of people who call at one on their way."""
TASK: Final = (12.0, 25.0)
"""Least and largest length of the robot's way [m]."""


def public_place(
    rng: np.random.Generator,
    *,
    place: str = "square",
    pedestrians: int = 30,
    layout: int | None = None,
    groups: float = 0.0,
    model: ModelChoice = "social_force",
) -> Scenario:
    """People walk between the doors, gates and stops of a place; the robot runs an errand.

    A generated square, street, station or mall (`crowdsim.maps`) with what stands in it. Who has
    left through a gate enters again as a new person through the one that he or she came from.

    Args:
        rng: Source of all draws.
        place: Kind of place: square, street, station or mall.
        pedestrians: Number of people, 0 to 200.
        layout: Which of that kind, 0 to 99,999; None draws one of the first 8, which `mixed`
            training sets do without. The first time that a process meets a place it takes a few
            seconds to find the ways.
        groups: Share of people who walk in groups, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or there is no room for all people.
    """
    require_count("pedestrians", pedestrians, 0, 200)
    require_range("groups", groups, 0.0, 1.0, unit="(share)")
    if layout is None:
        layout = int(rng.integers(DRAWN))
    require_count("layout", layout, 0, LAYOUTS - 1)
    premises = _premises(place, layout)
    group = draw_groups(rng, pedestrians, groups)
    robot_start, robot_goal, length = _draw_errand(rng, premises)
    ways = np.empty((pedestrians, 3, 2))

    def draw(first: int, size: int) -> FloatArray:
        """Places on the shortest walk to the first waypoint, one behind the other."""
        ways[first : first + size] = _draw_way(rng, premises)
        entrance, waypoint = ways[first, :2]
        walk = premises.walk_to(waypoint)
        there = rng.uniform(0.0, 0.9) * walk.length(entrance) + ABREAST * np.arange(size)[::-1]
        return np.array([walk.point_ahead(entrance, distance) for distance in there])

    start = place_parties(group, draw, keep_away=[robot_start.tolist()], ground=premises.map)
    ahead = premises.walk_to(robot_goal).direction(robot_start)
    return Scenario(
        name="public_place",
        map=premises.map,
        pedestrians=Pedestrians.draw(
            rng, position=start, waypoints=ways[:, 1:], model=model, group=group
        ),
        on_arrival="respawn",
        entrances=ways[:, 0],
        robot_start=(*robot_start.tolist(), float(np.arctan2(ahead[1], ahead[0]))),
        robot_goal=(float(robot_goal[0]), float(robot_goal[1])),
        time_limit=max(45.0, 3.0 * length),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Premises:
    """What of a place is in use, so that way-finding stays cheap. World metres.

    Attributes:
        map: The ground.
        gates: (E, 2, 2) straight lines that people come and go on.
        stops: (S, 2) where they call on their way.
    """

    map: Map
    gates: FloatArray
    stops: FloatArray

    @property
    def doors(self) -> FloatArray:
        """(E, 2) middles of the gates: where people walk to [m]."""
        return np.asarray(self.gates.mean(axis=1))

    def walk_to(self, point: FloatArray) -> GeodesicField:
        """The very field of shortest walks that people are led to a waypoint (2,) by."""
        return geodesic_field(self.map, np.round(point / GOAL_SPACING) * GOAL_SPACING)


@lru_cache(maxsize=64)
def _premises(kind: str, layout: int) -> Premises:
    """Gates of all sorts alike, and some of the stops."""
    place = make_place(kind, layout)
    return Premises(
        map=place.map,
        gates=_some(place.entrances, GATES),
        stops=_some(place.stops, STOPS),
    )


def _some(rows: FloatArray, count: int) -> FloatArray:
    """Up to `count` of the rows, evenly spread from the first to the last."""
    spread = np.linspace(0, len(rows) - 1, min(count, len(rows)))
    return np.asarray(rows[spread.round().astype(int)])


def _draw_way(rng: np.random.Generator, premises: Premises) -> FloatArray:
    """Entrance, and two waypoints of which the first may be a stop (3, 2) [m].

    The goal is one of the half of the gates that are farther off: nobody changes train doors.
    """
    origin = rng.integers(len(premises.gates))
    first, last = premises.gates[origin]
    entrance = first + rng.uniform(0.2, 0.8) * (last - first)
    by_distance = np.argsort(np.linalg.norm(premises.doors - premises.doors[origin], axis=1))
    end = premises.doors[rng.choice(by_distance[len(by_distance) // 2 :])]
    calls = rng.random() < CALLING and len(premises.stops) > 0
    return np.array([entrance, rng.choice(premises.stops) if calls else end, end])


def _draw_errand(
    rng: np.random.Generator, premises: Premises
) -> tuple[FloatArray, FloatArray, float]:
    """Start and goal of the robot (2,), and its way's length, within `TASK` if possible [m]."""
    points = np.concatenate([premises.doors, premises.stops])
    # [goal, start]
    lengths = np.array([premises.walk_to(goal).distance(points) for goal in points])
    missed = np.maximum(np.maximum(TASK[0] - lengths, lengths - TASK[1]), 0.0)
    goal, start = rng.choice(np.argwhere(missed == missed.min()))
    return points[start], points[goal], float(lengths[goal, start])
