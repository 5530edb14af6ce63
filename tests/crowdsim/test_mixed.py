"""What training sets are drawn from: walkers as recorded ones, on maps that nobody is tested on."""

import numpy as np
import pytest

from crowdsim.motion import MotionModel
from crowdsim.pedestrians import ALONE
from crowdsim.scenarios import SCENARIOS, make_scenario
from crowdsim.scenarios.mixed import FEW, MIXTURE, draw_mixed


@pytest.fixture(scope="module")
def crowds():
    return [draw_mixed(np.random.default_rng(seed)) for seed in range(80)]


def test_the_shares_add_up():
    assert sum(ingredient.share for ingredient in MIXTURE) == pytest.approx(1.0)


def test_nobody_turns_on_the_spot(crowds):
    assert not any("return" in np.atleast_1d(crowd.on_arrival) for crowd in crowds)


def test_people_stand_and_walk_together_as_often_as_recorded_ones(crowds):
    people = [crowd.pedestrians for crowd in crowds]
    standing = np.concatenate([crowd.desired_speed for crowd in people]) == 0.0
    together = np.concatenate([crowd.group for crowd in people]) != ALONE
    assert 0.1 < standing.mean() < 0.25
    assert 0.3 < together.mean() < 0.6


def test_whole_crowds_are_slower_or_faster_than_others(crowds):
    speeds = [crowd.pedestrians.desired_speed for crowd in crowds]
    mean = [speed[speed > 0.0].mean() for speed in speeds]
    assert np.quantile(mean, 0.1) < 1.0 < 1.4 < np.quantile(mean, 0.9)


def test_members_of_a_group_stand_or_walk_as_one(crowds):
    for crowd in (crowd.pedestrians for crowd in crowds):
        for number in np.unique(crowd.group[crowd.group != ALONE]):
            assert len(set(crowd.desired_speed[crowd.group == number])) == 1


def test_maps_are_others_than_those_that_environments_draw(crowds):
    named = [name for name in SCENARIOS if name != "replay"]
    tested = [make_scenario(name, np.random.default_rng(seed)) for name in named for seed in (0, 1)]
    bounded = [crowd.map for crowd in tested if len(crowd.map.segments) > 0]
    for crowd in crowds:
        assert not any(same_ground(crowd.map, other) for other in bounded)


def same_ground(one, other) -> bool:
    return one.bounds == other.bounds and np.array_equal(one.segments, other.segments)


@pytest.mark.parametrize("ingredient", MIXTURE, ids=lambda i: i.make.__name__)
def test_every_ingredient_takes_the_model_that_is_asked_for(ingredient):
    rng = np.random.default_rng(3)
    crowd = ingredient.make(rng, **ingredient.parameters(rng), model="orca").pedestrians
    assert len(crowd) > 0
    assert (crowd.model == MotionModel.ORCA).all()


def test_places_have_few_layouts(crowds):
    """Ways are found once per layout: a few seconds for a process, whatever it makes."""
    for kind in ("square", "mall", "station_hall"):
        assert len({id(crowd.map) for crowd in crowds if crowd.name == kind}) <= FEW
