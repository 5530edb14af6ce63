from typing import Any

import numpy as np
import pytest

from envs.evaluation.curves import setting_curves
from envs.evaluation.episode_rows import Row
from envs.evaluation.metric_table import METRICS


def episode(seed: int, success: bool, **about: Any) -> Row:
    row: Row = {key: metric.kind == "share" or np.nan for key, metric in METRICS.items()}
    row |= {"scenario": "s", "place": "s", "model": "", "robot_visible": True, "horizon": 4.8}
    row |= {"arm": "mppi/fast", "policy": "mppi", "forecaster": "fast"}
    return {**row, "seed": seed, "success": success, "clearance_min": float(seed), **about}


def at_horizon(horizon: float, successes: int) -> list[Row]:
    arm = f"mppi/fast {horizon:g} s"
    return [episode(seed, seed < successes, horizon=horizon, arm=arm) for seed in range(20)]


def test_each_horizon_is_compared_with_the_next_shorter_one() -> None:
    blind = [episode(seed, seed < 2, arm="mppi/none", forecaster="none") for seed in range(20)]
    # Neither the order of horizons nor that of seeds says what is paired.
    rows = at_horizon(9.6, 19)[::-1] + blind + at_horizon(0.4, 12)
    (points,) = setting_curves(rows)["horizon"].values()
    assert [point["value"] for point in points] == [0.0, 0.4, 9.6]
    assert points[0]["change"] == {}
    changes = [point["change"]["success"]["mean"] for point in points[1:]]
    assert changes == pytest.approx([0.5, 0.35])
    clearance = points[2]["change"]["clearance_min"]
    assert (clearance["mean"], clearance["low"], clearance["high"]) == (0.0, 0.0, 0.0)


def test_a_single_horizon_is_no_curve() -> None:
    blind = [episode(seed, True, arm="mppi/none", forecaster="none") for seed in range(4)]
    assert setting_curves(blind + at_horizon(4.8, 4)) == {
        "horizon": {},
        "robot_visible": {},
        "model": {},
    }


def test_visibility_is_paired_within_place_model_and_seed() -> None:
    rows = [
        episode(
            seed,
            True,
            place=place,
            robot_visible=visible,
            scenario=f"{place}, {visible}",
            clearance_min=10.0 * seed + (place == "b") - 0.5 * (not visible),
        )
        for visible in (True, False)
        for seed in (3, 1, 2)
        for place in ("b", "a")
    ]
    (points,) = setting_curves(rows)["robot_visible"].values()
    assert [point["value"] for point in points] == [True, False]
    difference = points[1]["change"]["clearance_min"]
    assert (difference["mean"], difference["low"], difference["high"]) == (-0.5, -0.5, -0.5)
    assert difference["n"] == 6


def test_what_was_not_run_at_every_value_is_no_curve() -> None:
    rows = at_horizon(0.4, 3) + at_horizon(9.6, 3)[:-1]
    assert setting_curves(rows)["horizon"] == {}
