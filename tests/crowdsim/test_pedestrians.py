import numpy as np
import pytest
from scipy import stats

from crowdsim.pedestrians import Pedestrians

DRAWN = {
    "desired_speed": (stats.norm(1.34, 0.26), 0.5, 2.2),
    "radius": (stats.uniform(0.2, 0.1), 0.2, 0.3),
    "relaxation_time": (stats.norm(0.5, 0.05), 0.35, 0.65),
    "mass": (stats.norm(73.5, 10.0), 45.0, 110.0),
}


def draw(count=400, **changes):
    position = np.arange(2.0 * count).reshape(count, 2)
    return Pedestrians.draw(
        np.random.default_rng(0),
        position=position,
        waypoints=position + np.array([3.0, 4.0]),
        **changes,
    )


@pytest.mark.parametrize("name", DRAWN)
def test_people_differ_as_documented(name):
    law, low, high = DRAWN[name]
    values = getattr(draw(20_000), name)
    assert stats.kstest(values, law.cdf).statistic < 0.012  # 1.2 % false alarms per name
    assert low <= values.min() < values.max() <= high


def test_aspects_of_a_person_do_not_depend_on_each_other():
    crowd = draw(20_000)
    columns = [getattr(crowd, name) for name in DRAWN]
    assert np.abs(np.corrcoef(columns) - np.eye(len(columns))).max() < 0.03


def test_people_start_walking_towards_their_first_waypoint():
    crowd = draw(desired_speed=1.5)
    np.testing.assert_allclose(crowd.velocity, np.tile([0.9, 1.2], (400, 1)))


@pytest.mark.parametrize("given", DRAWN)
def test_giving_one_aspect_changes_no_other_draw(given):
    drawn, fixed = draw(), draw(**{given: 0.6})
    np.testing.assert_array_equal(getattr(fixed, given), 0.6)
    for name in DRAWN.keys() - {given}:
        np.testing.assert_array_equal(getattr(drawn, name), getattr(fixed, name))


@pytest.mark.parametrize("name", DRAWN)
def test_one_more_person_changes_nobody_else(name):
    np.testing.assert_array_equal(getattr(draw(30), name), getattr(draw(31), name)[:30])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radius": -0.2}, "radius: expected > 0"),
        ({"radius": np.inf}, "radius: expected finite"),
    ],
)
def test_what_pymunk_would_swallow_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        draw(3, **changes)
