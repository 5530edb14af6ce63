"""Single scenarios and replays: what each draws, and what it refuses."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from crowdsim.scenario import Scenario
from crowdsim.scenarios import make_scenario
from crowdsim.scenarios.street import street
from crowdsim.world import World


def make(name: str, seed: int, **parameters: object) -> Scenario:
    return make_scenario(name, np.random.default_rng(seed), **parameters)


def test_opposite_goals_on_the_circle():
    scenario = make("circular_crossing", 0, radius=7.0)
    people = scenario.pedestrians
    np.testing.assert_array_equal(people.waypoints[:, -1], -people.position)
    assert np.abs(np.linalg.norm(people.position, axis=1) - 7.0).max() < 0.75


def test_share_against_the_robot():
    scenario = make("parallel_traffic", 0, pedestrians=20, oncoming=0.25)
    people = scenario.pedestrians
    ahead = people.waypoints[:, -1, 0] - people.position[:, 0]
    assert (ahead < 0.0).sum() == 5
    np.testing.assert_allclose(scenario.entrances[:, 0], -people.waypoints[:, -1, 0])


def test_the_door_is_used_both_ways():
    scenario = make("narrow_doorway", 0, pedestrians=8, crossing=0.5)
    people = scenario.pedestrians
    side = np.sign(people.position[:, 0])
    changes = side != np.sign(people.waypoints[:, -1, 0])
    assert changes[side < 0].sum() == changes[side > 0].sum() == 2


def test_the_door_is_as_wide_as_asked():
    map_ = make("narrow_doorway", 0, door_width=1.2).map
    assert map_.walkable([(0.0, 0.59), (0.0, -0.59)]).all()
    assert not map_.walkable([(0.0, 0.61), (0.0, -0.61)]).any()


def test_streets_differ_and_face_all_ways():
    streets = [street(layout) for layout in range(64)]
    assert len({plan.world_from_plan.tobytes() for plan in streets}) == 8
    assert len({plan.road_half for plan in streets}) == 64
    assert np.ptp([sum(plan.pavement) for plan in streets]) > 2.0


def test_people_walk_over_the_crosswalk_only():
    scenario = make("urban_crossing", 2, layout=5, pedestrians=40)
    plan = street(5)
    way = np.concatenate([scenario.entrances[:, None], scenario.pedestrians.waypoints], axis=1)
    way = way @ plan.world_from_plan  # rows; the inverse of an orthogonal matrix is its transpose
    leg_from, leg_to = way[:, :-1].reshape(-1, 2), way[:, 1:].reshape(-1, 2)
    over = np.sign(leg_from[:, 1]) != np.sign(leg_to[:, 1])
    middle, width = plan.crosswalk
    assert over.sum() >= 5
    assert np.abs(leg_from[over][:, 0] - middle).max() <= 0.5 * width
    assert np.abs(leg_to[over][:, 0] - middle).max() <= 0.5 * width


def test_unknown_names_and_parameters_list_the_known_ones():
    with pytest.raises(ValueError, match="narrow_doorway"):
        make("wide_doorway", 0)
    with pytest.raises(ValueError, match="door_width"):
        make("narrow_doorway", 0, door=1.0)


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("circular_crossing", {"radius": -1.0}, "radius must be in 2"),
        ("circular_crossing", {"pedestrians": 2.5}, "whole number"),
        ("circular_crossing", {"on_arrival": "leave"}, "stop or respawn"),
        ("circular_crossing", {"pedestrians": 200, "radius": 2.0}, "no room"),
        ("parallel_traffic", {"width": float("nan")}, "width must be in"),
        ("narrow_doorway", {"crossing": 2.0}, "crossing must be in"),
        ("urban_crossing", {"layout": -1}, "layout must be"),
        ("replay", {"scene": "uni"}, "crowds_zara01"),
    ],
)
def test_parameters_out_of_range_are_named(name, parameters, message):
    with pytest.raises(ValueError, match=message):
        make(name, 0, **parameters)


def test_a_robot_inside_a_building_is_refused():
    scenario = make("narrow_doorway", 0)
    with pytest.raises(ValueError, match="robot_goal must be a walkable point"):
        Scenario(
            name="walled in",
            map=scenario.map,
            pedestrians=scenario.pedestrians,
            robot_start=scenario.robot_start,
            robot_goal=(0.0, 3.0),
        )


@pytest.mark.parametrize("scene", ["crowds_zara01", "biwi_eth"])
def test_replay_gives_the_robot_the_way_of_somebody_left_out(data_root, scene):
    scenario = make("replay", 0, scene=scene, data=str(data_root))
    crowd, row = scenario.replay, scenario.replay_start
    assert crowd.valid.shape[1] == len(scenario.pedestrians)
    assert (np.diff(crowd.frames) == crowd.frame_step).all()
    assert crowd.mean_speed < 1.5  # biwi_eth at its true rate, not that of the standard file
    start, goal = np.array(scenario.robot_start[:2]), np.array(scenario.robot_goal)
    assert np.linalg.norm(goal - start) >= 6.0
    present = crowd.positions[row, crowd.valid[row]]
    assert np.linalg.norm(present - start, axis=1).min() >= 1.0
    assert shapely.distance(scenario.map.obstacles, shapely.Point(start)) >= 0.5


def test_replayed_people_walk_on_the_open_ground_of_their_map(data_root):
    scenario = make("replay", 0, scene="crowds_zara02", data=str(data_root))
    crowd, image = scenario.replay, scenario.map.picture.image
    height, width = image.shape[:2]
    points = crowd.positions[crowd.valid]
    pixel = np.column_stack([points, np.ones(len(points))]) @ crowd.pixel_from_world.T
    pixel = pixel[:, :2] / pixel[:, 2:]
    inside = ((pixel > 3.0) & (pixel < (width - 4.0, height - 4.0))).all(axis=1)
    assert scenario.map.walkable(points[inside]).mean() > 0.99


def test_each_person_has_a_word_on_arrival():
    two = replace(make("narrow_hallway", 0, pedestrians=2), on_arrival=("stop", "respawn"))
    world = World(two, rng=np.random.default_rng(0))
    for _ in range(600):
        world.step()
    assert world.ids[0] == 0
    assert np.linalg.norm(world.positions[0] - two.pedestrians.waypoints[0, -1]) < 0.6
    assert world.ids[1] > 1
    with pytest.raises(ValueError, match="one for each of 2 people, got 3"):
        replace(two, on_arrival=("stop",) * 3)
    with pytest.raises(ValueError, match="on_arrival must be one of"):
        replace(two, on_arrival=("stop", "vanish"))


def test_one_of_several_scenarios_is_drawn_each_time():
    names = "narrow_doorway+circular_crossing+t_intersection"
    drawn = [make(names, seed).name for seed in range(20)]
    assert set(drawn) == set(names.split("+"))
    assert drawn == [make(names, seed).name for seed in range(20)]


def test_several_scenarios_take_no_parameters_and_all_must_be_known():
    with pytest.raises(ValueError, match="got pedestrians"):
        make("narrow_doorway+circular_crossing", 0, pedestrians=3)
    with pytest.raises(ValueError, match="must be one of"):
        make("narrow_doorway+nowhere", 0)
