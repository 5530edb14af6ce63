import numpy as np
import pytest
import scipy.stats

from envs.evaluation.statistics import bca, mean_interval, paired_difference, wilson


def test_wilson_matches_scipy() -> None:
    for successes, n in [(0, 10), (3, 10), (17, 20), (20, 20)]:
        expected = scipy.stats.binomtest(successes, n).proportion_ci(method="wilson")
        found = wilson(successes, n)
        assert (found.low, found.high) == pytest.approx((expected.low, expected.high))


def test_a_proportion_of_one_is_not_certain() -> None:
    interval = mean_interval(np.ones(20, bool), np.random.default_rng(0))
    assert interval.mean == 1.0
    assert interval.low < 0.9


def test_bca_matches_scipy() -> None:
    values = np.random.default_rng(1).lognormal(size=25)
    expected = scipy.stats.bootstrap(
        (values,), np.mean, method="BCa", n_resamples=20000, rng=np.random.default_rng(2)
    ).confidence_interval
    found = bca(values, np.random.default_rng(3), resamples=20000)
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), rel=0.03)


def test_bca_covers_the_mean_about_as_often_as_it_says() -> None:
    rng = np.random.default_rng(4)
    hits = 0
    for _ in range(300):
        interval = bca(rng.normal(2.0, 1.0, size=20), rng, resamples=500)
        hits += interval.low <= 2.0 <= interval.high
    assert 0.88 < hits / 300 < 0.99


def test_missing_values_are_dropped_and_counted() -> None:
    interval = mean_interval([1.0, np.nan, 3.0], np.random.default_rng(0))
    assert (interval.mean, interval.n) == (2.0, 2)
    nothing = mean_interval([np.nan], np.random.default_rng(0))
    assert np.isnan(nothing.mean)
    assert nothing.n == 0


def test_one_value_has_no_interval() -> None:
    interval = mean_interval([4.0], np.random.default_rng(0))
    assert interval.mean == 4.0
    assert np.isnan(interval.low)
    assert not interval.excludes_zero


def test_pairing_removes_what_the_seed_explains() -> None:
    rng = np.random.default_rng(5)
    seed_effect = rng.normal(0, 10, size=40)
    reference = seed_effect + rng.normal(0, 0.1, size=40)
    ours = seed_effect + 1.0 + rng.normal(0, 0.1, size=40)
    interval = paired_difference(ours, reference, rng)
    assert interval.mean == pytest.approx(1.0, abs=0.1)
    assert interval.high - interval.low < 0.2
    assert interval.excludes_zero


def test_paired_proportions_that_never_disagree_stay_uncertain() -> None:
    same = np.ones(10, bool)
    interval = paired_difference(same, same, np.random.default_rng(0))
    assert interval.mean == 0.0
    assert interval.low < -0.05
    assert interval.high > 0.05


def test_a_paired_proportion_difference_is_antisymmetric() -> None:
    rng = np.random.default_rng(6)
    first, second = rng.random(30) < 0.9, rng.random(30) < 0.3
    forward = paired_difference(first, second, rng)
    backward = paired_difference(second, first, rng)
    assert forward.low == pytest.approx(-backward.high)
    assert forward.mean == pytest.approx(first.mean() - second.mean())
    assert forward.excludes_zero


def test_a_missing_value_on_either_side_drops_the_pair() -> None:
    interval = paired_difference(
        [1.0, np.nan, 5.0, 2.0], [0.0, 1.0, np.nan, 1.0], np.random.default_rng(0)
    )
    assert (interval.mean, interval.n) == (1.0, 2)


def test_arms_of_different_length_are_refused() -> None:
    with pytest.raises(ValueError, match=r"\(3,\) and \(2,\)"):
        paired_difference([1.0, 2.0, 3.0], [1.0, 2.0], np.random.default_rng(0))


def test_the_same_generator_state_gives_the_same_interval() -> None:
    values = np.random.default_rng(7).normal(size=12)
    first, second = (mean_interval(values, np.random.default_rng(8)) for _ in range(2))
    assert first == second
