"""Bodies start and enter without overlap, or an error says that there is no room."""

import numpy as np
import pytest
import shapely

from crowdsim.bodies import WALL_RADIUS
from crowdsim.robot_body import RobotBody
from crowdsim.scenario import Scenario
from crowdsim.scenarios import SCENARIOS, make_scenario
from crowdsim.scenarios.placement import SPACING, place
from crowdsim.world import World

CROWDED = {"circular_crossing": 50, "parallel_traffic": 90, "narrow_doorway": 40}
SYNTHETIC = [name for name in SCENARIOS if name != "replay"]


def gaps(position: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Distances between the surfaces of all pairs."""
    i, j = np.triu_indices(len(position), 1)
    return np.linalg.norm(position[i] - position[j], axis=1) - radius[i] - radius[j]


def make(name: str, seed: int) -> Scenario:
    parameters = {"pedestrians": CROWDED[name]} if name in CROWDED else {}
    return make_scenario(name, np.random.default_rng(seed), **parameters)


@pytest.mark.parametrize("name", SYNTHETIC)
@pytest.mark.parametrize("seed", range(3))
def test_nobody_starts_inside_anybody_or_a_wall(name, seed):
    scenario = make(name, seed)
    people = scenario.pedestrians
    assert gaps(people.position, people.radius).min(initial=np.inf) > 0.0
    if len(scenario.map.segments):
        walls = shapely.multilinestrings(shapely.linestrings(scenario.map.segments))
        apart = shapely.distance(walls, shapely.points(people.position))
        assert (apart - people.radius - WALL_RADIUS).min() > -1e-9
    running = World(scenario, rng=np.random.default_rng(seed), robot=RobotBody())
    assert running.robot_clearance > 0.0
    assert running.robot_wall_clearance > 0.0


def test_who_enters_again_overlaps_nobody():
    scenario = make_scenario(
        "parallel_traffic", np.random.default_rng(0), pedestrians=40, width=3.0, length=20.0
    )
    running = World(scenario, rng=np.random.default_rng(0))
    entered = 0
    for _ in range(1500):
        before = running.ids
        running.step()
        for row in np.flatnonzero(running.ids != before):
            others = running.valid
            others[row] = False
            apart = np.linalg.norm(running.positions[others] - running.positions[row], axis=1)
            assert (apart > running.radius[others] + running.radius[row]).all()
            entered += 1
    assert entered > 20


def test_as_many_as_there_is_room_for():
    spots = np.arange(10.0)[:, None] * [1.01 * SPACING, 0.0]
    rng = np.random.default_rng(0)
    starts = place(10, lambda _: rng.choice(spots))
    np.testing.assert_array_equal(np.sort(starts[:, 0]), spots[:, 0])
    with pytest.raises(ValueError, match="no room for person 11 of 11 after 2000 attempts"):
        place(11, lambda _: rng.choice(spots))
