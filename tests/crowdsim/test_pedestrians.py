import numpy as np
import pytest

from crowdsim.pedestrians import Pedestrians


def draw(count=400, **changes):
    position = np.arange(2.0 * count).reshape(count, 2)
    return Pedestrians.draw(
        np.random.default_rng(0),
        position=position,
        waypoints=position + np.array([3.0, 4.0]),
        **changes,
    )


def test_desired_speeds_follow_weidmann():
    speed = draw().desired_speed
    assert speed.mean() == pytest.approx(1.34, abs=0.04)
    assert speed.std() == pytest.approx(0.26, abs=0.03)


def test_people_start_walking_towards_their_first_waypoint():
    crowd = draw(desired_speed=1.5)
    np.testing.assert_allclose(crowd.velocity, np.tile([0.9, 1.2], (400, 1)))


def test_giving_the_speeds_changes_no_other_draw():
    np.testing.assert_array_equal(draw().radius, draw(desired_speed=1.0).radius)


def test_one_more_person_changes_nobody_else():
    np.testing.assert_array_equal(draw(30).desired_speed, draw(31).desired_speed[:30])
    np.testing.assert_array_equal(draw(30).radius, draw(31).radius[:30])


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
