"""Scenarios that users write: a file is drawn as it says, and what is wrong in it is named."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from crowdsim.map import Map
from crowdsim.maps import make_place, write_geojson
from crowdsim.motion import MotionModel
from crowdsim.pedestrians import ALONE
from crowdsim.recordings.surfaces import Surface
from crowdsim.scenarios import make_scenario
from crowdsim.world import World

DOCS = Path(__file__).parents[2] / "docs"
PLAIN = {
    "map": {"bounds": [-10, -10, 10, 10]},
    "people": [{"count": 6, "start": [-9, -5, -7, 5], "goal": [8, 0]}],
    "robot": {"start": [0, -8], "goal": [0, 8]},
}


def write(folder: Path, content: object, name: str = "mine.yaml") -> str:
    path = folder / name
    path.write_text(yaml.safe_dump(content))
    return str(path)


def draw(file: str, seed: int = 0, **parameters):
    return make_scenario(file, np.random.default_rng(seed), **parameters)


def changed(**changes):
    return {**PLAIN, **changes}


def flow(**changes):
    return changed(people=[{**PLAIN["people"][0], **changes}])


def test_the_example_of_the_documentation_runs():
    text = (DOCS / "scenario_files.md").read_text(encoding="utf-8")
    assert (DOCS / "plaza.yaml").read_text(encoding="utf-8") in text
    scenario = draw(str(DOCS / "plaza.yaml"))
    world = World(scenario, rng=np.random.default_rng(0))
    stand = scenario.pedestrians.desired_speed == 0.0
    for _ in range(600):
        world.step()
    moved = np.linalg.norm(world.positions - scenario.pedestrians.position, axis=1)
    assert stand.sum() == 3
    assert moved[stand].max() < 2.0  # others push by
    assert (world.ids >= len(world.ids)).sum() > 5  # who left came back as somebody new


def test_the_same_seed_draws_the_same_and_another_one_another(tmp_path):
    file = write(tmp_path, flow(count=[2, 30]))
    one, same, other = draw(file, 1), draw(file, 1), draw(file, 2)
    np.testing.assert_array_equal(one.pedestrians.position, same.pedestrians.position)
    assert one.map is same.map is other.map  # physics keeps what it derives from a map
    assert len({len(draw(file, seed).pedestrians) for seed in range(8)}) > 3


def test_people_start_and_end_where_the_file_says(tmp_path):
    file = write(tmp_path, flow(via=[[0, 3, 2, 5]], desired_speed=[1.0, 0.05]))
    people = draw(file).pedestrians
    assert people.waypoints.shape == (6, 2, 2)
    assert ((people.position >= (-9, -5)) & (people.position <= (-7, 5))).all()
    assert ((people.waypoints[:, 0] >= (0, 3)) & (people.waypoints[:, 0] <= (2, 5))).all()
    np.testing.assert_array_equal(people.waypoints[:, 1], np.tile((8.0, 0.0), (6, 1)))
    assert 0.8 < people.desired_speed.min() < people.desired_speed.max() < 1.2


def test_those_who_are_spread_are_on_their_way_and_enter_at_the_start(tmp_path):
    wall = {"bounds": [-10, -10, 10, 10], "walls": [[[0, -10], [0, 4]]]}
    robot = {"start": [3, -8], "goal": [3, 8]}
    file = write(tmp_path, {**flow(spread=True, count=12), "map": wall, "robot": robot})
    scenario = draw(file)
    start = scenario.pedestrians.position
    assert start[:, 0].max() > 0.0  # somebody is past the wall already
    assert (scenario.entrances[:, 0] <= -7.0).all()


def test_groups_begin_side_by_side_and_stay_on_free_ground(tmp_path):
    house = {"bounds": [-10, -10, 10, 10], "surfaces": [{"building": [-7, -10, 7, -1]}]}
    file = write(
        tmp_path,
        {**flow(groups=1.0, count=8), "map": house, "robot": {"start": [0, 8, 0], "goal": [0, 2]}},
    )
    people = draw(file).pedestrians
    for number in set(people.group):
        members = people.position[people.group == number]
        assert number != ALONE
        assert np.linalg.norm(members - members[0], axis=1).max() < 3.0
    assert draw(file).map.walkable(people.position).all()


def test_flows_have_their_own_models_and_ends_unless_all_are_told_one(tmp_path):
    flows = [
        {**PLAIN["people"][0], "model": "orca", "on_arrival": "stop"},
        {**PLAIN["people"][0], "start": [-9, 6, -7, 9], "count": 2},
    ]
    file = write(tmp_path, changed(people=flows))
    assert draw(file).pedestrians.model.tolist() == [MotionModel.ORCA] * 6 + [0] * 2
    assert draw(file).on_arrival == ("stop",) * 6 + ("respawn",) * 2
    forced = draw(file, model="headed_social_force").pedestrians.model
    assert (forced == MotionModel.HEADED_SOCIAL_FORCE).all()


def test_a_place_gives_entrances_and_stops(tmp_path):
    file = write(
        tmp_path,
        {
            "map": {"place": "square", "layout": 3},
            "people": [{"count": 4, "start": "entrances", "via": ["stops"], "goal": "entrances"}],
            "robot": {"start": "entrances", "goal": "stops"},
        },
    )
    scenario, place = draw(file), make_place("square", 3)
    assert scenario.map is place.map
    via = scenario.pedestrians.waypoints[:, 0]
    assert (np.linalg.norm(via[:, None] - place.stops, axis=-1).min(axis=1) == 0.0).all()


def test_a_map_file_lies_beside_the_scenario(tmp_path):
    ground = Map(
        bounds=(-10.0, -10.0, 10.0, 10.0),
        surfaces=((Surface.WATER, np.array([(-2.0, -2.0), (2.0, -2.0), (0.0, 2.0)])),),
    )
    write_geojson(tmp_path / "pond.geojson", ground)
    scenario = draw(write(tmp_path, changed(map="pond.geojson")))
    assert not scenario.map.walkable((0.0, 0.0))


def test_a_named_scenario_takes_its_parameters_from_the_file(tmp_path):
    content = {"scenario": "circular_crossing", "parameters": {"pedestrians": 3, "radius": 4.0}}
    file = write(tmp_path, content, "small.yml")
    assert draw(file).robot_goal == (0.0, 4.0)
    assert len(draw(file, pedestrians=5).pedestrians) == 5


WRONG = [
    ([], "expected keys map, people, robot"),
    (changed(weather="rain"), "expected keys among map.*found 'weather'"),
    ({"map": PLAIN["map"], "people": []}, "expected the key 'robot'"),
    (changed(people=[]), "people: expected at least one flow"),
    (flow(speed=1.0), r"people\[0\]: expected keys among count.*found 'speed'"),
    (flow(count=[5, 2]), r"people\[0\].count: expected 0 <= least"),
    (flow(count="many"), r"people\[0\].count: expected a whole number"),
    (flow(goal=[1, 2, 3]), r"people\[0\].goal: expected 2 or 4 numbers"),
    (flow(goal=[4, 0, 1, 2]), r"people\[0\].goal: expected \[x_min"),
    (flow(via=[["a", 2]]), r"people\[0\].via\[0\]: expected a number, found 'a'"),
    (flow(groups=2), r"people\[0\].groups: expected a share"),
    (flow(model="teleport"), r"people\[0\].model: expected.*social_force"),
    (flow(on_arrival="vanish"), r"people\[0\].on_arrival: expected one of stop"),
    (flow(start=[9, 9]), "no room for person"),
    (flow(start="entrances"), "entrances and stops need a place"),
    (changed(behaviour={"naps": 1}), "behaviour: expected keys among pause_rate"),
    (changed(time_limit=0), "time_limit must be positive"),
    (changed(robot={"start": [0, 0], "goal": [0, 0.5]}), "no way whose points"),
    (changed(map={"place": "moon"}), "map.place: expected one of square"),
    (changed(map={"bounds": [0, 0, 1]}), "map.bounds: expected 4 numbers"),
    (changed(map={"bounds": [1, 0, 0, 1]}), "map.bounds: expected finite x_min < x_max"),
    (
        changed(map={"bounds": [0, 0, 9, 9], "surfaces": [{"lava": [0, 0, 1, 1]}]}),
        r"map.surfaces\[0\]: expected one of pavement.*lava",
    ),
    ({"scenario": "moon"}, "scenario: expected one of circular_crossing"),
    (
        {"scenario": "circular_crossing", "parameters": {"size": 3}},
        "parameters: expected keys among pedestrians.*found 'size'",
    ),
]


@pytest.mark.parametrize(("content", "message"), WRONG, ids=lambda value: str(value)[:40])
def test_what_is_wrong_is_named_with_file_and_key(tmp_path, content, message):
    file = write(tmp_path, content)
    with pytest.raises(ValueError, match=message) as found:
        draw(file)
    assert str(found.value).startswith(file)


def test_what_is_no_yaml_or_not_there_is_said(tmp_path):
    broken = tmp_path / "broken.yaml"
    broken.write_text("map: [unclosed")
    with pytest.raises(ValueError, match=r"broken\.yaml: expected YAML"):
        draw(str(broken))
    with pytest.raises(FileNotFoundError, match=r"absent\.yaml"):
        draw(str(tmp_path / "absent.yaml"))
