import math

import numpy as np
import pytest

from crowdsim.interactions import circular, elliptical, moussaid_2009, repulsion, time_to_closest


def test_repulsion_is_minus_the_gradient_of_its_potential():
    strength, reach, gap, small = 2.5, 0.25, 0.4, 1e-6

    def potential(gap):
        return strength * reach * math.exp(-gap / reach)

    slope = (potential(gap + small) - potential(gap - small)) / (2 * small)
    assert repulsion(strength, reach, gap) == pytest.approx(-slope, rel=1e-8)


def test_time_to_closest_of_two_who_walk_towards_each_other():
    assert time_to_closest(4.0, 0.3, -2.0, 0.0) == 2.0
    assert time_to_closest(4.0, 0.3, 2.0, 0.0) == 0.0
    assert time_to_closest(4.0, 0.3, 0.0, 0.0) == 0.0


def test_people_on_collision_course_turn_aside_rather_than_brake():
    strength, nx, ny = circular(-3.0, 0.1, 2.0, 0.0, 0.5, 2.0, 0.5, 2.0)
    assert (nx, ny) == (0.0, 1.0)
    assert strength == pytest.approx((1 - 1.5 / 2.0) * 2.0 * math.exp((0.5 - 0.1) / 0.5))


class TestElliptical:
    def test_by_hand(self):
        # Foci 1.5 m apart, one body 2 m from the first and 2.5 m from the second.
        acceleration, nx, ny = elliptical(-2.0, 0.0, 0.0, 3.0, 0.5, 2.7, 1.07, 0.5)
        axis = math.sqrt((2.0 + 2.5) ** 2 - 1.5**2) / 2
        expected = 2.7 * math.exp((0.5 - axis) / 1.07) * 4.5 / (4 * axis)
        assert acceleration == pytest.approx(expected)
        assert (nx, ny) == pytest.approx((-1.0 - 2.0 / 2.5, 1.5 / 2.5))

    def test_is_minus_the_gradient_of_its_potential(self):
        velocity, contact, strength, reach, step = np.array([-1.2, 0.4]), 0.5, 2.7, 1.07, 0.5

        def potential(place):
            around = np.linalg.norm(place) + np.linalg.norm(place + velocity * step)
            axis = math.sqrt(around**2 - (step**2) * (velocity**2).sum()) / 2
            return strength * reach * math.exp((contact - axis) / reach)

        place, small = np.array([1.4, -0.7]), 1e-6 * np.eye(2)
        slope = [(potential(place + s) - potential(place - s)) / 2e-6 for s in small]
        size, nx, ny = elliptical(*place, *velocity, contact, strength, reach, step)
        np.testing.assert_allclose([size * nx, size * ny], -np.array(slope), rtol=1e-6)

    def test_of_two_who_keep_their_distance_is_circular(self):
        size, nx, ny = elliptical(0.6, 0.8, 0.0, 0.0, 0.5, 2.7, 1.07, 0.5)
        other, ox, oy = circular(0.6, 0.8, 0.0, 0.0, 0.5, 2.7, 1.07, 0.0)
        assert (size * nx, size * ny) == pytest.approx((other * ox, other * oy))

    def test_head_on_it_pushes_aside_between_now_and_then(self):
        _, nx, ny = elliptical(-0.5, 0.1, 2.0, 0.0, 0.5, 2.7, 1.07, 0.5)
        assert nx == pytest.approx(0.0)
        assert ny > 0.1


class TestMoussaid2009:
    def test_two_who_stand_push_each_other_straight_away(self):
        size, x, y = moussaid_2009(-0.6, -0.8, 0.0, 0.0, 4.5, 0.35)
        assert size == pytest.approx(4.5 * math.exp(-1.0 / 0.35))
        assert (x, y) == pytest.approx((-0.6, -0.8))

    def test_by_hand(self):
        # i walks along +x at 1 m/s, j stands 2 m ahead and 45 degrees to the left.
        place = -math.sqrt(2.0)
        size, x, y = moussaid_2009(place, place, 1.0, 0.0, 4.5, 0.35)
        along = np.array([2.0 + math.sqrt(0.5), math.sqrt(0.5)])
        length = np.linalg.norm(along)
        angle = math.pi / 4 - math.atan2(along[1], along[0])
        spread = 0.35 * length
        brake = math.exp(-((3.0 * spread * angle) ** 2))
        aside = math.exp(-((2.0 * spread * angle) ** 2))
        left = np.array([-along[1], along[0]]) / length
        expected = -brake * along / length - aside * left
        assert size == pytest.approx(4.5 * math.exp(-2.0 / spread))
        np.testing.assert_allclose([x, y], expected)

    @pytest.mark.parametrize("side", [1.0, -1.0])
    def test_one_steps_away_from_the_side_of_the_other_and_brakes(self, side):
        _, x, y = moussaid_2009(-3.0, -0.5 * side, 2.0, 0.0, 4.5, 0.35)
        assert x < 0
        assert y * side < 0
