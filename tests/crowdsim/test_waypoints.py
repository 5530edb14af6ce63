"""When a waypoint counts as reached, and where people enter again."""

import numpy as np
import pytest

from crowdsim.map import Map
from crowdsim.pedestrians import Pedestrians
from crowdsim.routes import Routes

RADIUS = np.array([0.25])


def one_walker(on_arrival: str = "stop", entrances: np.ndarray | None = None) -> Routes:
    """Somebody who walks from x = 0 by way of x = 5 to x = 10."""
    walker = Pedestrians.draw(
        np.random.default_rng(0),
        position=[(0.0, 0.0)],
        waypoints=[[(5.0, 0.0), (10.0, 0.0)]],
    )
    open_ground = Map(bounds=(-2.0, -5.0, 12.0, 5.0))
    return Routes(walker, open_ground, on_arrival, entrances)


def goal_after(routes: Routes, position: tuple[float, float]) -> float:
    """The x that is walked to next by somebody who stands at `position`."""
    bodies = np.array([[*position, 1.0, 0.0]])
    routes.advance(1, bodies, RADIUS, np.array([True]), np.array([0]))
    return float(routes.goals[0, 0])


@pytest.mark.parametrize(
    ("position", "goal"),
    [
        ((4.6, 0.0), 10.0),  # as good as there
        ((5.1, 1.2), 10.0),  # pushed past it
        ((4.9, 1.2), 5.0),  # still before it
        ((5.1, 2.0), 5.0),  # too far off to have passed it
    ],
)
def test_nobody_turns_back_for_a_waypoint_close_behind(position, goal):
    assert goal_after(one_walker(), position) == goal


def test_who_leaves_comes_in_at_the_entrance():
    routes = one_walker("respawn", entrances=np.array([[-1.0, 0.5]]))
    bodies, present, ids = np.array([[5.0, 0.0, 1.0, 0.0]]), np.array([True]), np.array([0])
    for x in (5.0, 10.0):
        bodies[0, 0] = x
        routes.advance(1, bodies, RADIUS, present, ids)
    assert not present[0]
    routes.advance(1, bodies, RADIUS, present, ids)
    assert present[0]
    assert ids[0] == 1
    np.testing.assert_array_equal(bodies[0, :2], (-1.0, 0.5))


def test_who_was_pushed_past_a_goal_listed_twice_does_not_turn_back():
    walker = Pedestrians.draw(
        np.random.default_rng(0), position=[(0.0, 0.0)], waypoints=[[(10.0, 0.0), (10.0, 0.0)]]
    )
    routes = Routes(walker, Map(bounds=(-2.0, -5.0, 12.0, 5.0)), "respawn")
    bodies, present = np.array([[10.1, 1.2, 1.0, 0.0]]), np.array([True])
    for _ in range(2):
        routes.advance(1, bodies, RADIUS, present, np.array([0]))
    assert not present[0]
