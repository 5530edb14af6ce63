"""Generated places: varied, repeatable, and everything in them can be reached."""

import numpy as np
import pytest
import shapely

from crowdsim.maps import PLACES, make_place
from crowdsim.maps.plan import CLEAR, Plan
from crowdsim.maps.shapes import box, disc
from crowdsim.pedestrians import Pedestrians
from crowdsim.recordings.surfaces import Surface
from crowdsim.scenario import Scenario
from crowdsim.wayfinding import geodesic_field
from crowdsim.world import World

LAYOUTS = range(6)


def solid(place):
    return shapely.union(place.map.obstacles, shapely.MultiLineString(list(place.map.walls)))


@pytest.mark.parametrize("kind", PLACES)
@pytest.mark.parametrize("layout", LAYOUTS)
def test_people_can_enter_and_stop_clear_of_obstacles(kind, layout):
    place = make_place(kind, layout)
    gates, stops = shapely.linestrings(place.entrances), shapely.points(place.stops)
    assert shapely.distance(solid(place), gates).min() >= CLEAR - 0.1
    assert shapely.distance(solid(place), stops).min() >= CLEAR
    assert place.map.walkable(place.entrances).all()
    assert place.map.walkable(place.stops).all()
    assert len(place.entrances) >= 2


@pytest.mark.parametrize("kind", PLACES)
@pytest.mark.parametrize("layout", LAYOUTS)
def test_everything_can_be_reached_and_some_of_it_not_straight(kind, layout):
    place = make_place(kind, layout)
    gates = place.entrances.mean(axis=1)
    field = geodesic_field(place.map, gates[0], clearance=0.4)
    targets = np.concatenate([gates[1:], place.stops])
    walked = field.distance(targets)
    straight = np.linalg.norm(targets - gates[0], axis=1)
    assert np.isfinite(walked).all()
    assert (walked > 1.02 * straight).any()


@pytest.mark.parametrize("kind", PLACES)
def test_the_number_decides_and_every_number_is_another_place(kind):
    assert make_place(kind, 3) is make_place(kind, 3)
    make_place.cache_clear()
    first, again = make_place(kind, 3), (make_place.cache_clear(), make_place(kind, 3))[1]
    np.testing.assert_array_equal(first.map.segments, again.map.segments)
    np.testing.assert_array_equal(first.entrances, again.entrances)
    lengths = {round(solid(make_place(kind, layout)).length, 3) for layout in LAYOUTS}
    assert len(lengths) == len(LAYOUTS)


def test_places_are_full_of_things_to_walk_around():
    for kind in PLACES:
        counts = [len(shapely.get_parts(make_place(kind, n).map.obstacles)) for n in LAYOUTS]
        assert np.mean(counts) > 12


def test_nothing_is_put_where_people_would_not_fit_past():
    plan = Plan(np.random.default_rng(0))
    plan.open(box(0, 0, 10, 10))
    plan.door(5, 0.5)
    thing = [(Surface.BUILDING, disc(1.5, 5, 0.5))]
    assert not plan.furnish(thing, gap=1.6)
    assert plan.furnish(thing, gap=0.9)
    assert not plan.furnish([(Surface.BUILDING, disc(5, 1.9, 0.5))], gap=0.9)  # before the door


@pytest.mark.parametrize(
    ("kind", "layout", "message"),
    [("harbor", 0, "square, street, station, mall"), ("mall", -1, "layout must be in 0")],
)
def test_unknown_places_are_refused(kind, layout, message):
    with pytest.raises(ValueError, match=message):
        make_place(kind, layout)


@pytest.mark.parametrize("kind", PLACES)
def test_a_crowd_finds_its_way_from_gate_to_gate(kind):
    place = make_place(kind, 1)
    gates, rng = place.entrances.mean(axis=1), np.random.default_rng(0)
    goals = np.repeat(gates[:1], len(gates) - 1, axis=0)
    people = Pedestrians.draw(rng, position=gates[1:], waypoints=goals[:, None])
    scenario = Scenario(
        name=kind,
        map=place.map,
        pedestrians=people,
        robot_start=(*place.stops[0].tolist(), 0.0),
        robot_goal=tuple(gates[0].tolist()),
    )
    world = World(scenario, rng=rng)
    nearest = np.full(len(goals), np.inf)
    for _ in range(80):
        for _ in range(20):
            world.step()
        nearest = np.minimum(nearest, np.linalg.norm(world.positions - goals, axis=1))
    x_min, y_min, x_max, y_max = place.map.bounds  # the first at a gate are pushed out by others
    seen = np.clip(world.positions, (x_min, y_min), (x_max, y_max))
    assert place.map.walkable(seen).all()
    assert nearest.max() < 1.5  # the first ones stand where the others want to
