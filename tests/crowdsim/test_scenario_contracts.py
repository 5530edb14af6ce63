"""What holds for every scenario that needs no data: ways, meetings, pace, documented ranges."""

import inspect
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rides import ride

from crowdsim.distance_field import distance_field
from crowdsim.scenario import Scenario
from crowdsim.scenarios import SCENARIOS, make_scenario
from crowdsim.wayfinding import geodesic_field
from crowdsim.world import World

SYNTHETIC = [name for name in SCENARIOS if name != "replay"]
ONE_PLACE = {"station_hall": {"layout": 0}, "public_place": {"layout": 0}}
"""Finding the ways of a place takes seconds once; one of each will do."""


def make(name: str, seed: int, **parameters: object) -> Scenario:
    parameters = {**ONE_PLACE.get(name, {}), **parameters}
    return make_scenario(name, np.random.default_rng(seed), **parameters)


def refusal(name: str, **parameters: object) -> str:
    """What the error says, "" without one."""
    try:
        make(name, 0, **parameters)
    except ValueError as error:
        return str(error)
    return ""


def documented(name: str) -> dict[str, tuple[float, float]]:
    """The range of each number, as the documentation of its parameter ends."""
    text = re.sub(r"\s+", " ", inspect.getdoc(SCENARIOS[name]) or "")
    ranges = {}
    for parameter in inspect.signature(SCENARIOS[name]).parameters:
        found = re.search(rf" {parameter}: [^:]*?([\d.]+) to ([\d.,]*\d)", text)
        if found and parameter != "rng":
            low, high = (float(number.replace(",", "")) for number in found.groups())
            ranges[parameter] = low, high
    return ranges


@pytest.mark.parametrize("name", SYNTHETIC)
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), groups=st.sampled_from([0.0, 0.6]))
def test_nobody_starts_in_anybody_or_anything(name, seed, groups):
    takes_groups = "groups" in inspect.signature(SCENARIOS[name]).parameters
    scenario = make(name, seed, **({"groups": groups} if takes_groups else {}))
    people, robot = scenario.pedestrians, np.array(scenario.robot_start[:2])
    apart = np.linalg.norm(people.position[:, None] - people.position, axis=-1)
    gaps = apart - people.radius[:, None] - people.radius + np.diag(np.full(len(people), np.inf))
    assert gaps.min() > 0.0
    assert (np.linalg.norm(people.position - robot, axis=1) - people.radius).min() > 0.3
    if len(scenario.map.segments):
        walls = distance_field(scenario.map)
        assert (walls.distance(people.position) - people.radius).min() > 0.05
        assert walls.distance(np.array([robot, scenario.robot_goal])).min() > 0.4


@pytest.mark.parametrize("name", SYNTHETIC)
def test_the_way_through_the_crowd_is_neither_short_nor_out_of_time(name):
    scenario = make(name, 1)
    distance = np.linalg.norm(np.subtract(scenario.robot_goal, scenario.robot_start[:2]))
    assert distance > 7.0
    assert distance / scenario.time_limit < 0.7  # a robot of 1 m/s has time to wait


@pytest.mark.parametrize("name", SYNTHETIC)
def test_the_seed_decides(name):
    first, again, other = (make(name, seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first.pedestrians.position, again.pedestrians.position)
    np.testing.assert_array_equal(first.pedestrians.radius, again.pedestrians.radius)
    assert first.map is again.map  # what physics derives from a map is computed once
    assert (first.pedestrians.position != other.pedestrians.position).any()


@pytest.mark.parametrize("name", SYNTHETIC)
def test_the_count_is_what_was_asked_for(name):
    for count in (0, 3):
        assert len(make(name, 0, pedestrians=count).pedestrians) == count


@pytest.mark.parametrize("name", SYNTHETIC)
def test_everybody_can_walk_to_where_they_want_to(name):
    scenario = make(name, 1)
    field = geodesic_field(scenario.map, scenario.robot_goal)
    people = scenario.pedestrians
    places = [people.position[:, None], people.waypoints]
    if scenario.entrances is not None:
        places.append(scenario.entrances[:, None])
    everywhere = np.concatenate(places, axis=1)
    assert scenario.map.walkable(everywhere).all()
    assert np.isfinite(field.distance(everywhere)).all()
    assert np.isfinite(field.length(scenario.robot_start[:2]))


@pytest.mark.parametrize("name", SYNTHETIC)
def test_the_robot_meets_people_and_can_arrive_in_time(name):
    trips = [ride(make(name, seed)) for seed in range(4)]
    assert sum(trip.clearance.min() < 1.5 for trip in trips) >= 3
    assert sum(trip.arrived for trip in trips) >= 2


@pytest.mark.parametrize("name", SYNTHETIC)
def test_people_walk_at_their_pace_until_the_time_is_over(name):
    scenario = make(name, 2)
    world = World(scenario, rng=np.random.default_rng(0))
    walks = np.broadcast_to(np.array(scenario.on_arrival) != "stop", len(scenario.pedestrians))
    pace, there = [], []
    while world.time < scenario.time_limit:
        world.step()
        present = walks & world.valid
        there.append(present.sum() / walks.sum())
        if present.any():
            speed = np.hypot(*world.velocities[present].T)
            pace.append((speed / world.desired_speed[present]).mean())
    quarter = len(pace) // 4
    assert 0.6 < np.mean(pace[:quarter]) < 1.15
    assert 0.6 < np.mean(pace[-quarter:]) < 1.15  # nobody is stuck for good
    assert np.mean(there[-quarter:]) > 0.8


@pytest.mark.parametrize(
    ("name", "parameter"), [(name, key) for name in SYNTHETIC for key in documented(name)]
)
def test_documented_ranges_are_kept(name, parameter):
    for value, step in zip(documented(name)[parameter], (-1, 1), strict=True):
        whole = parameter in ("pedestrians", "layout", "obstacles")
        outside = int(value) + step if whole else value + 0.01 * step
        with pytest.raises(ValueError, match=f"{parameter} must be"):
            make(name, 0, **{parameter: outside})


@pytest.mark.parametrize(
    ("name", "parameter"), [(name, key) for name in SYNTHETIC for key in documented(name)]
)
def test_the_ends_of_documented_ranges_are_taken(name, parameter):
    kind = type(inspect.signature(SCENARIOS[name]).parameters[parameter].default)
    whole = kind is not float
    for value in documented(name)[parameter]:
        refused = refusal(name, **{parameter: int(value) if whole else value})
        assert refused == "" or "no room" in refused


@pytest.mark.parametrize("name", SYNTHETIC)
def test_every_number_documents_its_range(name):
    numbers = {
        parameter.name
        for parameter in inspect.signature(SCENARIOS[name]).parameters.values()
        if isinstance(parameter.default, int | float)
    }
    assert numbers <= set(documented(name))


@pytest.mark.parametrize("name", SYNTHETIC)
def test_any_model_moves_the_people(name):
    scenario = make(name, 0, model={"orca": 0.5, "headed_social_force": 0.5})
    world = World(scenario, rng=np.random.default_rng(0))
    for _ in range(20):
        world.step()
    assert set(scenario.pedestrians.model) <= {1, 2}
    assert np.isfinite(world.positions).all()
