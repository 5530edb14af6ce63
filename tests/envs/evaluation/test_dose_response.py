import numpy as np
import pytest

from envs.evaluation.dose_response import rank_correlation

FORECASTERS = ("a", "b", "c", "d")


def episodes(
    success_of, *, scenario="s", seeds=range(40), noise=0.05, forecasters=FORECASTERS, horizon=4.8
):
    """Rows of arms whose errors are 1, 2, 3, ...; success has the share that is asked for."""
    rng = np.random.default_rng(0)
    return [
        {
            "scenario": scenario,
            "policy": "mppi",
            "arm": f"mppi/{forecaster}",
            "forecaster": forecaster,
            "horizon": horizon,
            "seed": seed,
            "forecast_fde": 1.0 + dose + noise * rng.standard_normal(),
            "success": bool(rng.random() < success_of(dose)),
        }
        for dose, forecaster in enumerate(forecasters)
        for seed in seeds
    ]


def correlate(rows):
    return rank_correlation(rows, "success", np.random.default_rng(1), resamples=300)


def test_who_errs_more_and_fails_more_is_anticorrelated():
    found = correlate(episodes(lambda dose: 1.0 - 0.3 * dose))
    assert found.mean == pytest.approx(-1.0)
    assert found.high < -0.5
    assert found.n == 1


def test_where_the_error_does_not_matter_the_interval_holds_zero():
    found = correlate(episodes(lambda dose: 0.5))
    assert found.low < 0.0 < found.high


def test_groups_are_averaged():
    rows = episodes(lambda dose: 1.0 - 0.3 * dose)
    rows += episodes(lambda dose: 0.1 + 0.3 * dose, scenario="t")
    found = correlate(rows)
    assert found.mean == pytest.approx(0.0)
    assert found.n == 2


def test_two_forecasters_are_too_few():
    found = correlate(episodes(lambda dose: 1.0 - 0.3 * dose, forecasters=("a", "b")))
    assert np.isnan(found.mean)
    assert found.n == 0


def test_an_arm_without_forecasts_does_not_count():
    rows = episodes(lambda dose: 1.0 - 0.3 * dose, forecasters=("none", "a", "b"))
    assert correlate(rows).n == 0


def test_episodes_without_an_error_are_left_out():
    rows = episodes(lambda dose: 1.0 - 0.3 * dose)
    rows[0]["forecast_fde"] = np.nan
    assert correlate(rows).mean == pytest.approx(-1.0)


def test_where_nobody_ever_fails_there_is_no_correlation():
    assert np.isnan(correlate(episodes(lambda dose: 2.0)).mean)


def test_forecasts_of_another_reach_are_another_group():
    # Within each horizon the error does not matter; over both the longer one errs and fails more.
    near = episodes(lambda dose: 0.9)
    far = [
        {**row, "arm": f"{row['arm']} 9.6 s", "forecast_fde": row["forecast_fde"] + 9.0}
        for row in episodes(lambda dose: 0.2, horizon=9.6)
    ]
    found = correlate(near + far)
    assert found.n == 2
    assert found.low < 0.0 < found.high
