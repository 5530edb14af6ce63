"""A street with buildings, pavements, a crosswalk, lawns and trees, and people who cross it."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.groups import draw_groups
from crowdsim.motion import ModelChoice
from crowdsim.pedestrians import Pedestrians
from crowdsim.scenario import Scenario
from crowdsim.scenarios.placement import parties, place_parties, require_count, require_range
from crowdsim.scenarios.street import DEPTH, LENGTH, Street, street
from crowdsim.scenarios.walks import formation, shifted

STREETS: Final = 64
"""Streets that are drawn from unless one is asked for; physics keeps what it derives from them."""
LAYOUTS: Final = 100_000
"""Number of different streets."""
STRAIGHT: Final = 0.4
"""Share of people who walk along one pavement from end to end; the others' ends are any gates."""
END: Final = 0.6
"""People enter and leave this far inside the street's ends [m]."""
PAIR: Final = 0.4
"""Room to either side of a way, so that two walk abreast and more in single file [m]."""
WAYPOINTS: Final = 5
"""Alley mouth, kerb, kerb, alley mouth, goal; unused ones repeat the next."""

Gate = tuple[int, float, bool]
"""Where people come from and go to: side of the road (-1, 1), plan x, whether it is an alley."""


def urban_crossing(
    rng: np.random.Generator,
    *,
    pedestrians: int = 24,
    layout: int | None = None,
    groups: float = 0.0,
    model: ModelChoice = "social_force",
) -> Scenario:
    """The robot crosses a street with the people: along a pavement, over the crosswalk, and on.

    People walk between the ends of both pavements and the alleys between the buildings, and use
    the crosswalk where their way leads over the road. Who arrives enters again as a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 100.
        layout: Which street, 0 to 99,999; None draws one of the first 64. Streets differ in all
            widths, setbacks, lawns, trees, alleys, and are mirrored and turned by multiples of 90
            degrees. `mixed` training sets keep to the others.
        groups: Share of people who walk in groups, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the street is too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 100)
    if layout is None:
        layout = int(rng.integers(STREETS))
    require_count("layout", layout, 0, LAYOUTS - 1)
    require_range("groups", groups, 0.0, 1.0, unit="(share)")
    plan = street(layout)
    group = draw_groups(rng, pedestrians, groups)
    routes = _draw_routes(rng, plan, group)
    robot_start, robot_goal = _robot_task(rng, plan)

    def draw(first: int, size: int) -> NDArray[np.float64]:
        """Places on the first stretch of the ways, so that nobody misses a waypoint."""
        origin = routes[first : first + size, 0]
        ahead = routes[first : first + size, 1] - origin
        before = formation(size, PAIR)[0][::-1, None] / np.linalg.norm(ahead[0])
        return np.asarray(origin + (rng.uniform(0.0, 0.9) + before) * ahead)

    start = place_parties(group, draw, keep_away=[robot_start.tolist()])
    to_world = plan.world_from_plan.T
    turned = routes @ to_world
    ahead = (robot_goal - robot_start) @ to_world
    return Scenario(
        name="urban_crossing",
        map=plan.map,
        pedestrians=Pedestrians.draw(
            rng, position=start @ to_world, waypoints=turned[:, 1:], model=model, group=group
        ),
        on_arrival="respawn",
        entrances=turned[:, 0],
        robot_start=(*(robot_start @ to_world).tolist(), float(np.arctan2(ahead[1], ahead[0]))),
        robot_goal=tuple((robot_goal @ to_world).tolist()),
        time_limit=45.0,
    )


def _robot_task(
    rng: np.random.Generator, plan: Street
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Start and goal in the plan: on opposite pavements, on either side of the crosswalk."""
    side = int(rng.choice([-1, 1]))
    along = float(rng.choice([-1.0, 1.0]))
    middle = plan.crosswalk[0]
    start_y, goal_y = np.mean(plan.lanes(side)), np.mean(plan.lanes(-side))
    start = np.array([middle - along * rng.uniform(4.0, 8.0), start_y])
    goal = np.array([middle + along * rng.uniform(3.0, 7.0), goal_y])
    return start, goal


def _draw_routes(
    rng: np.random.Generator, plan: Street, group: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Origins and waypoints (N, 1 + G, 2) in the plan; members of a group go the same way."""
    routes = np.empty((len(group), WAYPOINTS + 1, 2))
    for first, size in parties(group):
        route = _draw_route(rng, plan)
        unused = ((0, WAYPOINTS + 1 - len(route)), (0, 0))
        for member, left in enumerate(formation(size, PAIR)[1]):
            routes[first + member] = np.pad(shifted(route, left), unused, mode="edge")
    return routes


def _draw_route(rng: np.random.Generator, plan: Street) -> NDArray[np.float64]:
    """Origin and up to `WAYPOINTS` waypoints (1 + G, 2) in the plan."""
    origin, goal = _draw_gates(rng, plan)
    lane = rng.uniform(-1.0, 1.0)
    points = [_gate_point(plan, origin, lane)]
    if origin[2]:
        points.append(_on_pavement(plan, origin[0], origin[1] + 0.25 * lane, lane))
    if origin[0] != goal[0]:
        points += _crossing(rng, plan, origin[0])
    if goal[2]:
        points.append(_on_pavement(plan, goal[0], goal[1] + 0.25 * lane, lane))
    return np.array([*points, _gate_point(plan, goal, lane)])


def _draw_gates(rng: np.random.Generator, plan: Street) -> tuple[Gate, Gate]:
    end = 0.5 * LENGTH - END
    pavements: list[Gate] = [(side, x, False) for side in (-1, 1) for x in (-end, end)]
    if rng.random() < STRAIGHT:
        side, x, _ = pavements[rng.integers(len(pavements))]
        return (side, x, False), (side, -x, False)
    gates = pavements + [(side, x, True) for side, x in plan.alleys]
    first, second = rng.choice(len(gates), 2, replace=False)
    return gates[first], gates[second]


def _gate_point(plan: Street, gate: Gate, lane: float) -> NDArray[np.float64]:
    side, x, is_alley = gate
    if not is_alley:
        return _on_pavement(plan, side, x, lane)
    back = plan.road_half + plan.pavement[max(side, 0)] + DEPTH - END
    return np.array([x + 0.25 * lane, side * back])


def _on_pavement(plan: Street, side: int, x: float, lane: float) -> NDArray[np.float64]:
    """The point at x of a lane in -1..1, from the kerb to the buildings."""
    kerb, front = plan.lanes(side)
    return np.array([x, kerb + 0.5 * (1.0 + lane) * (front - kerb)])


def _crossing(rng: np.random.Generator, plan: Street, side: int) -> list[NDArray[np.float64]]:
    """The two ends of a way over the crosswalk, starting from one side."""
    middle, width = plan.crosswalk
    here, there = middle + (0.5 * width - 0.5) * rng.uniform(-1.0, 1.0, 2)
    return [np.array([here, plan.lanes(side)[0]]), np.array([there, plan.lanes(-side)[0]])]
