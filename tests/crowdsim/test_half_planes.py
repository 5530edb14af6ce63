import numpy as np
import pytest

from crowdsim.half_planes import breach, nearest_permitted

LEFT_OF_HALF = (0.5, 0.0, -1.0, 0.0)  # x <= 0.5
RIGHT_OF_ONE = (1.0, 3.0, 1.0, 0.0)  # x >= 1
ABOVE_ZERO = (7.0, 0.0, 0.0, 1.0)  # y >= 0


def permitted(planes, wanted, *, firm=0, max_speed=2.0):
    rows = np.array(planes, dtype=float).reshape(-1, 4)
    return nearest_permitted(rows, len(rows), firm, *wanted, max_speed)


def random_planes(rng, count, offset):
    """Half-planes whose borders lie `offset` from the origin on average."""
    angle = rng.uniform(-np.pi, np.pi, count)
    normal = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.concatenate([-rng.normal(offset, 0.5, (count, 1)) * normal, normal], axis=1)


def breaches(planes, velocities):
    """By how much each of (V, 2) breaks each of (K, 4): (V, K)."""
    return ((planes[:, :2] - velocities[:, None]) * planes[:, 2:]).sum(axis=-1)


@pytest.fixture(scope="module")
def disc():
    """Velocities everywhere in the disc of speed 2."""
    grid = np.stack(np.meshgrid(*2 * [np.linspace(-2, 2, 401)]), axis=-1).reshape(-1, 2)
    return grid[np.linalg.norm(grid, axis=1) <= 2]


def test_what_is_permitted_is_done():
    assert permitted([], (0.7, -0.4)) == (0.7, -0.4)
    assert permitted([LEFT_OF_HALF], (0.3, 1.0)) == (0.3, 1.0)


def test_nobody_is_faster_than_the_limit():
    assert permitted([], (3.0, 4.0), max_speed=1.0) == pytest.approx((0.6, 0.8))


def test_one_half_plane_is_met_at_right_angles():
    assert permitted([LEFT_OF_HALF], (1.0, 0.2)) == pytest.approx((0.5, 0.2))


def test_two_half_planes_are_met_in_their_corner():
    assert permitted([LEFT_OF_HALF, ABOVE_ZERO], (1.0, -1.0)) == pytest.approx((0.5, 0.0))


def test_what_cannot_all_hold_is_broken_equally():
    x, _ = permitted([LEFT_OF_HALF, RIGHT_OF_ONE], (0.0, 0.0))
    assert x == pytest.approx(0.75)


def test_what_is_firm_is_not_broken():
    x, _ = permitted([LEFT_OF_HALF, RIGHT_OF_ONE], (0.0, 0.0), firm=1)
    assert x == pytest.approx(0.5)


@pytest.mark.parametrize("seed", range(20))
def test_no_permitted_velocity_is_nearer_to_the_wanted_one(seed, disc):
    rng = np.random.default_rng(seed)
    planes, wanted = random_planes(rng, 8, 1.0), rng.normal(0, 1.5, 2)
    free = disc[(breaches(planes, disc) <= 0).all(axis=1)]
    assert len(free) > 0
    found = np.array(permitted(planes, wanted))
    assert breaches(planes, found[None]).max() < 1e-9
    assert np.linalg.norm(found) < 2 + 1e-9
    nearest = np.linalg.norm(free - wanted, axis=1).min()
    assert np.linalg.norm(found - wanted) <= nearest + 1e-9


@pytest.mark.parametrize("seed", range(20))
def test_no_velocity_breaks_the_worst_half_plane_less(seed, disc):
    rng = np.random.default_rng(seed)
    planes = random_planes(rng, 8, -0.3)
    worst = breaches(planes, disc).max(axis=1)
    assert worst.min() > 0
    found = permitted(planes, (0.5, 0.5))
    assert max(breach(plane, *found) for plane in planes) <= worst.min() + 1e-9
