import numpy as np
import pytest
from test_world import crossing, world

from crowdsim.bodies import SKIN, WALL_RADIUS, Bodies
from crowdsim.map import Map

OPEN = Map(bounds=(0.0, 0.0, 20.0, 20.0))
ROOM = Map(
    bounds=(0.0, 0.0, 20.0, 20.0),
    walls=np.array([[[0.0, 5.0], [12.0, 5.0]], [[12.0, 5.0], [9.0, 14.0]]]),
)
RADIUS = 0.3


def solid(count, world_map=OPEN, dynamic_from=0):
    return Bodies(
        radius=np.full(count, RADIUS),
        mass=np.full(count, 80.0),
        dynamic_from=dynamic_from,
        world_map=world_map,
        dt=0.05,
    )


def both_ways(bodies, world_map=OPEN):
    """Where all coast to, or None if somebody touches something, and where the solver puts them."""
    solver, coasted = solid(len(bodies), world_map), bodies.copy()
    free = solver.coast(coasted, np.ones(len(bodies), dtype=bool))
    assert free or (coasted == bodies).all()
    return coasted if free else None, solver.solve(bodies)


def moving(*rows):
    return np.array(rows, dtype=float)


def test_coasting_gives_the_bits_of_the_contact_solver():
    rng = np.random.default_rng(0)
    coasted_often = 0
    for _ in range(300):
        bodies = np.concatenate([rng.uniform(1, 19, (12, 2)), rng.normal(0, 1.5, (12, 2))], axis=1)
        coasted, solved = both_ways(bodies, ROOM)
        if coasted is not None:
            np.testing.assert_array_equal(coasted, solved)
            coasted_often += 1
    assert 50 < coasted_often < 290


@pytest.mark.parametrize("gap", [-0.03, 0.0, 0.02])
def test_who_touches_somebody_does_not_coast(gap):
    closing = 2 * 1.0 * 0.05
    apart = 2 * (RADIUS + SKIN) + closing + gap
    coasted, solved = both_ways(moving([5, 5, 1, 0], [5 + apart, 5, -1, 0]))
    assert (coasted is not None) == (gap > 0)
    assert (solved[0, 2] < 1.0) == (gap < 0)


@pytest.mark.parametrize("end", [6.0, 12.0])
def test_who_touches_a_wall_does_not_coast(end):
    height = 5.0 + RADIUS + WALL_RADIUS + 2 * SKIN
    coasted, _ = both_ways(moving([end, height - 0.01, 1, 0]), ROOM)
    assert coasted is None
    coasted, _ = both_ways(moving([end - 3, height + 0.05, 0.1, 0]), ROOM)
    assert coasted is not None


def test_bodies_that_are_told_where_to_go_stay_for_others_to_move():
    bodies = moving([5, 5, 1, 0], [9, 9, 1, 0])
    assert solid(2, dynamic_from=1).coast(bodies, np.ones(2, dtype=bool))
    np.testing.assert_array_equal(bodies[:, 0] > [5, 9], [False, True])


def test_a_crowd_walks_the_same_with_and_without_coasting(monkeypatch):
    def walk():
        crowd = world(crossing())
        for _ in range(300):
            crowd.step()
        return crowd.positions

    coasting = walk()
    monkeypatch.setattr("crowdsim.bodies.SPARSE", -1)
    np.testing.assert_array_equal(coasting, walk())
