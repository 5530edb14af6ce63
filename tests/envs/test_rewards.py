import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from envs.config import make_config
from envs.rewards import (
    REWARD_TERMS,
    Consequences,
    closeness,
    predicted_intrusion,
    reward_terms,
    total,
)

CONFIG = make_config(horizon=4.8, predicted_intrusion_decay=2.0, robot_radius=0.3)
TIMES = CONFIG.frame_dt * np.arange(1, 13)


def quiet(**changes):
    """Nothing happens: one robot that stands, one person far away."""
    step = Consequences(
        progress=np.zeros(1),
        reached=np.array([False]),
        collided=np.array([False]),
        clearance=np.array([np.inf]),
        planned=np.zeros((1, 12, 2)),
        forecast=np.full((1, 1, 12, 2), 50.0),
        neighbors_valid=np.array([[True]]),
        neighbors_radius=np.array([[0.2]]),
    )
    return dataclasses.replace(step, **changes)


def along_x(start, velocity):
    path = np.zeros((12, 2))
    path[:, 0] = start + velocity * TIMES
    return path


def test_a_quiet_step_costs_only_time():
    terms = reward_terms(quiet(), CONFIG)
    assert tuple(terms) == REWARD_TERMS
    assert_allclose(total(terms), CONFIG.time_weight * CONFIG.policy_dt)
    assert all((terms[name] == 0.0).all() for name in REWARD_TERMS if name != "time")


def test_the_reward_is_the_sum_of_its_terms():
    step = quiet(progress=np.array([0.2]), reached=np.array([True]), clearance=np.array([0.1]))
    terms = reward_terms(step, CONFIG)
    assert_allclose(terms["progress"], 0.2)
    assert_allclose(terms["goal"], 10.0)
    assert terms["discomfort"][0] < 0.0
    assert_allclose(total(terms), sum(terms.values()))


@pytest.mark.parametrize("name", [name for name in REWARD_TERMS if name != "predicted_intrusion"])
def test_each_weight_scales_its_own_term(name):
    step = quiet(
        progress=np.array([0.2]),
        reached=np.array([True]),
        collided=np.array([True]),
        clearance=np.array([0.1]),
    )
    doubled = dataclasses.replace(
        CONFIG, **{f"{name}_weight": 2 * getattr(CONFIG, f"{name}_weight")}
    )
    before, after = reward_terms(step, CONFIG), reward_terms(step, doubled)
    for term in REWARD_TERMS:
        assert_allclose(after[term], before[term] * (2.0 if term == name else 1.0))


def test_discomfort_grows_linearly_below_its_distance():
    assert_allclose(closeness(np.array([np.inf, 0.45, 0.225, 0.0, -0.1]), 0.45), [0, 0, 0.5, 1, 1])


def test_walking_side_by_side_is_no_intrusion():
    # Whoever compares the robot's place now with people's later places sees a collision here:
    # the person will pass over the point where the robot is now.
    step = quiet(planned=along_x(0.0, 1.0)[None], forecast=along_x(-2.0, 1.0)[None, None])
    assert_array_equal(predicted_intrusion(step, CONFIG), 0.0)


def test_meeting_head_on_is_an_intrusion_when_both_get_there():
    step = quiet(planned=along_x(0.0, 1.0)[None], forecast=along_x(4.0, -1.0)[None, None])
    # They meet at t = 2 s, which is the fifth forecast step.
    assert_allclose(predicted_intrusion(step, CONFIG), np.exp(-2.0 / 2.0))


def test_an_intrusion_that_is_sooner_counts_more():
    later = quiet(forecast=along_x(4.0, -1.0)[None, None])
    sooner = quiet(forecast=along_x(2.0, -1.0)[None, None])
    assert predicted_intrusion(sooner, CONFIG) > predicted_intrusion(later, CONFIG) > 0.0


def test_empty_places_and_a_missing_forecaster_intrude_on_nobody():
    crossing = along_x(0.0, 0.0)[None, None]
    empty = quiet(forecast=crossing, neighbors_valid=np.array([[False]]))
    assert_array_equal(predicted_intrusion(empty, CONFIG), 0.0)
    assert_array_equal(predicted_intrusion(quiet(forecast=None), CONFIG), 0.0)
