"""Every scenario does what its name promises."""

import numpy as np
import pytest
from rides import ride

from crowdsim.pedestrians import ALONE
from crowdsim.scenario import Scenario
from crowdsim.scenarios import make_scenario
from crowdsim.visibility import visible
from crowdsim.world import World


def make(name: str, seed: int = 0, **parameters: object) -> Scenario:
    return make_scenario(name, np.random.default_rng(seed), **parameters)


def seen_at_start(scenario: Scenario) -> np.ndarray:
    """Which people the robot sees."""
    x, y, heading = scenario.robot_start
    people = scenario.pedestrians.position
    sight = visible(scenario.map.occluders, [(x, y)], [heading], people, max_range=50.0)
    return sight[0]


def walked(scenario: Scenario, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions (T, N, 2), NaN where absent, and ids (T, N) without a robot, every 0.1 s."""
    world = World(scenario, rng=np.random.default_rng(0))
    positions, ids = [], []
    for _ in range(round(seconds / 0.1)):
        world.step()
        world.step()
        positions.append(np.where(world.valid[:, None], world.positions, np.nan))
        ids.append(world.ids)
    return np.array(positions), np.array(ids)


@pytest.mark.parametrize("seed", range(4))
def test_frontal_approach_is_head_on(seed):
    trip = ride(make("frontal_approach", seed))
    meeting = int(trip.clearance.argmin())
    assert trip.clearance[meeting] < 1.0
    before = max(meeting - 15, 0)  # 3 s earlier
    assert trip.positions[before, 0, 0] > trip.robot[before, 0] + 2.0
    assert abs(trip.positions[before, 0, 1] - trip.robot[before, 1]) < 0.7
    assert trip.velocities[before, 0, 0] < -0.4


@pytest.mark.parametrize("seed", range(4))
def test_pedestrian_overtaking_passes_the_robot(seed):
    trip = ride(make("pedestrian_overtaking", seed))
    ahead = trip.positions[:, 0, 0] - trip.robot[:, 0]
    first = trip.ids[:, 0] == 0
    assert ahead[0] < -1.0
    assert ahead[first][-1] > 1.0
    assert trip.clearance.min() < 1.0


@pytest.mark.parametrize("seed", range(4))
def test_robot_overtaking_passes_somebody_slow(seed):
    scenario = make("robot_overtaking", seed)
    trip = ride(scenario, by_way_of=[(-5.0, 1.2), (5.0, 1.2)])
    ahead = trip.positions[:, 0, 0] - trip.robot[:, 0]
    assert ahead[0] > 1.0
    assert trip.arrived
    assert ahead[-1] < -1.0
    assert trip.ids[-1, 0] == 0


@pytest.mark.parametrize("seed", range(12))
def test_nobody_sees_around_the_blind_corner(seed):
    assert not seen_at_start(make("blind_corner", seed)).any()


@pytest.mark.parametrize("turn", ["left", "right"])
def test_the_blind_corner_shows_people_late(turn):
    scenario = make("blind_corner", turn=turn)
    trip = ride(scenario)
    sight = [
        visible(scenario.map.occluders, [here], [0.0], people, max_range=50.0)[0]
        for here, people in zip(trip.robot, trip.positions, strict=True)
    ]
    first = int(np.flatnonzero(np.any(sight, axis=1))[0])
    apart = np.linalg.norm(trip.positions[first] - trip.robot[first], axis=1)
    assert apart[sight[first]].min() < 7.0
    assert trip.clearance.min() < 1.0
    assert np.sign(scenario.robot_goal[0]) == (-1.0 if turn == "left" else 1.0)


def test_all_arms_of_an_intersection_are_used():
    scenario = make("intersection", pedestrians=40, width=5.0)
    ends = np.concatenate([scenario.entrances, scenario.pedestrians.waypoints[:, -1]])
    east_west = np.abs(ends[:, 0]) > np.abs(ends[:, 1])
    arms = {
        (bool(on_x), bool(end[on_x ^ 1] > 0.0)) for on_x, end in zip(east_west, ends, strict=True)
    }
    assert len(arms) == 4


def test_a_tee_is_closed_ahead():
    scenario = make("t_intersection", 1, width=4.0)
    assert scenario.map.walkable([(7.0, 0.0), (-7.0, 0.0), (0.0, -7.0)]).all()
    assert not scenario.map.walkable((0.0, 3.0))
    assert abs(scenario.robot_goal[0]) > 3.0


@pytest.mark.parametrize("turn", ["left", "straight", "right"])
def test_the_robot_turns_as_asked(turn):
    goal = make("intersection", turn=turn).robot_goal
    assert np.allclose(goal, {"left": (-6, 0), "straight": (0, 6), "right": (6, 0)}[turn])


def test_the_robot_can_only_just_pass_in_a_narrow_hallway():
    scenario = make("narrow_hallway", pedestrians=1)
    trip = ride(scenario, by_way_of=[(-3.0, -0.5), (3.0, -0.5)])
    assert trip.arrived
    assert trip.clearance.min() < 0.5


def test_everybody_passes_the_bottleneck():
    scenario = make("bottleneck", width=1.2, passage=2.0)
    positions, ids = walked(scenario, 60.0)
    assert (ids[-1] >= len(scenario.pedestrians)).all()
    inside = (positions[..., 0] > 0.0) & (positions[..., 0] < 2.0)
    assert np.abs(positions[inside][:, 1]).max() < 0.6


@pytest.mark.parametrize(("name", "sign"), [("entering_room", 1.0), ("exiting_room", -1.0)])
def test_people_come_through_the_door_against_the_robot(name, sign):
    scenario = make(name)
    positions, ids = walked(scenario, 30.0)
    same = ids[1:] == ids[:-1]
    x, y = positions[..., 0], positions[..., 1]
    through = same & (x[1:] * x[:-1] < 0.0) & (np.abs(y[1:]) < 1.0)
    steps = np.diff(x, axis=0)[through]
    assert len(steps) >= 10
    assert (np.sign(steps) == -sign).all()
    start, goal = scenario.robot_start[0], scenario.robot_goal[0]
    assert np.sign(goal) == -np.sign(start) == sign


def test_groups_cross_together():
    scenario = make("group_crossing")
    group = scenario.pedestrians.group
    assert (group != ALONE).mean() > 0.9
    positions, _ = walked(scenario, 20.0)
    spread = [
        np.linalg.norm(positions[:, i] - positions[:, j], axis=1)
        for i, j in zip(*np.nonzero(np.triu(group[:, None] == group, 1)), strict=True)
    ]
    near = np.array(spread)
    assert np.nanmedian(near) < 1.5
    # A few m apart are members of whom one has just entered anew.
    assert (near[np.isfinite(near)] < 3.0).mean() > 0.85


@pytest.mark.parametrize("name", ["crowd_navigation", "robot_crowding"])
def test_who_stands_stays_about_there_and_the_others_come_and_go(name):
    scenario = make(name)
    stands = np.array(scenario.on_arrival) == "stop"
    positions, ids = walked(scenario, 40.0)
    off = np.linalg.norm(positions[:, stands] - scenario.pedestrians.position[stands], axis=-1)
    assert stands.sum() == round((0.3 if name == "crowd_navigation" else 0.6) * len(stands))
    assert np.median(off) < 0.5
    assert off.max() < 2.0
    assert (ids[-1, stands] == ids[0, stands]).all()
    assert (ids[-1, ~stands] != ids[0, ~stands]).all()


def test_onlookers_surround_the_robot():
    scenario = make("robot_crowding")
    stands = np.array(scenario.on_arrival) == "stop"
    offset = scenario.pedestrians.position[stands] - scenario.robot_start[:2]
    assert np.linalg.norm(offset, axis=1).max() < 3.3
    bearing = np.sort(np.arctan2(offset[:, 1], offset[:, 0]))
    assert np.diff(bearing, append=bearing[0] + 2.0 * np.pi).max() < np.pi


def test_perpendicular_traffic_crosses_from_the_side_asked_for():
    for share in (0.0, 1.0):
        people = make("perpendicular_traffic", from_left=share, pedestrians=12).pedestrians
        way = people.waypoints[:, -1] - people.position
        assert (np.sign(way[:, 0]) == (1.0 if share else -1.0)).all()
        assert np.abs(way[:, 1]).max() < 1e-9


def test_random_crossings_go_all_ways():
    people = make("random_crossing", pedestrians=40).pedestrians
    way = people.waypoints[:, -1] - people.position
    assert len({tuple(signs) for signs in (way > 0.0).tolist()}) == 4


def test_planters_stand_where_people_cross():
    world_map = make("circular_crossing_with_static_obstacles", layout=3, obstacles=6).map
    assert len(world_map.obstacles.geoms) == 6
    x_min, y_min, x_max, y_max = world_map.obstacles.bounds
    assert max(-x_min, -y_min, x_max, y_max) < 7.0


def test_stations_differ_and_people_use_their_gates():
    scenario, other = make("station_hall", layout=0), make("station_hall", layout=1)
    assert scenario.map is not other.map
    ends = {tuple(end) for end in scenario.pedestrians.waypoints[:, -1].tolist()}
    assert 3 <= len(ends) <= 6
