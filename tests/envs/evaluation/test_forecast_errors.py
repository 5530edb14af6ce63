"""Closed-loop forecast errors of traces written by hand, in their bins and all together."""

from typing import Any

import numpy as np
import pytest
from hand_made_traces import make_trace, walk

from envs.evaluation.forecast_breakdown import forecast_breakdown, mean_of_sums
from envs.evaluation.forecast_cells import CELL_COLUMNS, forecast_cells
from envs.evaluation.metrics import navigation_metrics
from envs.report.forecast_section import forecast_section
from envs.trace import Trace

STEPS, FRAMES = 25, 3
ABOUT = {
    "scenario": "s",
    "place": "s",
    "model": "",
    "robot_visible": True,
    "arm": "a",
    "policy": "p",
    "forecaster": "f",
    "horizon": 1.2,
    "seed": 0,
}
OFF = (0.1, 0.4)
"""How far the forecasts of the near and of the far person are off [m]."""


def known_errors(radius: float = 0.2, frames_seen: tuple[int, int] = (8, 2)) -> Trace:
    """A standing robot with somebody walking 1.5 m and somebody 9.5 m beside it."""
    robot = walk((2.0, 0.0), (0.0, 0.0), STEPS)
    people = [walk((2.0, 2.0), (0.0, 0.0), STEPS), walk((2.0, 10.0), (0.0, 0.0), STEPS)]
    forecast = np.stack(people, axis=1)[:, :, None].repeat(FRAMES, axis=2)
    forecast[..., 0] += np.array(OFF)[:, None]
    return make_trace(
        robot,
        people,
        forecast=forecast,
        forecast_ids=np.tile([0, 1], (STEPS + 1, 1)),
        forecast_radius=np.full((STEPS + 1, 2, FRAMES), radius),
        forecast_frames_seen=np.tile(frames_seen, (STEPS + 1, 1)),
    )


def cells_of(trace: Trace, **about: Any) -> list[dict[str, Any]]:
    return forecast_cells(trace, ABOUT | about)


def round_normal_nll(error: float, radius: float) -> float:
    """Of the round normal distribution that has nine in ten within the radius."""
    sigma = radius / 2.145966
    return float(np.log(2.0 * np.pi * sigma**2) + 0.5 * (error / sigma) ** 2)


def test_known_errors_fall_into_their_bins() -> None:
    cells = cells_of(known_errors())
    forecasts = STEPS + 1 - 2 * FRAMES
    assert all(tuple(cell) == CELL_COLUMNS for cell in cells)
    found = {(cell["distance"], cell["frames_seen"], cell["step"]): cell for cell in cells}
    assert set(found) == {
        (distance, frames, step)
        for distance, frames in (("0-2", "8-"), ("8-", "2-4"))
        for step in (1, 2, 3)
    }
    for (distance, _, step), cell in found.items():
        off = OFF[0] if distance == "0-2" else OFF[1]
        assert cell["seconds"] == pytest.approx(0.4 * step)
        assert cell["n"] == forecasts
        assert cell["error_sum"] == pytest.approx(off * forecasts)
        assert cell["within_radius"] == (forecasts if off < 0.2 else 0)
        assert cell["nll_n"] == forecasts
        assert cell["nll_sum"] == pytest.approx(forecasts * round_normal_nll(off, 0.2))


@pytest.mark.parametrize(
    ("gap", "expected"), [(0.0, "0-2"), (1.99, "0-2"), (2.01, "2-4"), (4.01, "4-8"), (8.01, "8-")]
)
def test_distance_is_surface_to_surface(gap: float, expected: str) -> None:
    robot = walk((0.0, 0.0), (0.0, 0.0), STEPS)
    person = walk((gap + 0.5, 0.0), (0.0, 0.0), STEPS)
    forecast = person[:, None, None].repeat(FRAMES, axis=2)
    trace = make_trace(
        robot, [person], forecast=forecast, forecast_ids=np.zeros((STEPS + 1, 1), np.int64)
    )
    assert {cell["distance"] for cell in cells_of(trace)} == {expected}


@pytest.mark.parametrize(
    ("frames", "expected"),
    [(1, "1"), (2, "2-4"), (4, "2-4"), (5, "5-7"), (7, "5-7"), (8, "8-"), (9, "8-")],
)
def test_every_length_of_history_has_its_bin(frames: int, expected: str) -> None:
    cells = cells_of(known_errors(frames_seen=(frames, frames)))
    assert {cell["frames_seen"] for cell in cells} == {expected}


def test_bins_add_up_to_the_row_of_the_episode() -> None:
    rng = np.random.default_rng(0)
    plain = known_errors()
    assert plain.forecast is not None
    noisy = plain.forecast + rng.normal(size=plain.forecast.shape)
    trace = make_trace(
        plain.robot_position,
        list(np.moveaxis(plain.position, 1, 0)),
        forecast=noisy,
        forecast_ids=plain.forecast_ids,
        forecast_frames_seen=rng.integers(1, 9, size=(STEPS + 1, 2)),
    )
    cells, row = cells_of(trace), navigation_metrics(trace)
    total, count = sum(cell["error_sum"] for cell in cells), sum(cell["n"] for cell in cells)
    assert count == row["forecast_count"] * FRAMES
    assert total / count == pytest.approx(row["forecast_ade"], rel=1e-12)
    last = [cell for cell in cells if cell["step"] == FRAMES]
    at_end = sum(cell["error_sum"] for cell in last) / sum(cell["n"] for cell in last)
    assert at_end == pytest.approx(row["forecast_fde"], rel=1e-12)


def test_an_episode_without_forecasts_has_no_cells() -> None:
    trace = make_trace(walk((0.0, 0.0), (1.0, 0.0), STEPS), [walk((0.0, 2.0), (0.0, 0.0), STEPS)])
    assert cells_of(trace) == []
    assert forecast_breakdown([]) == {}


def test_the_breakdown_pools_forecasts_and_scenarios() -> None:
    near = cells_of(known_errors())
    elsewhere = cells_of(known_errors(radius=1.0), scenario="t", seed=1)
    found = forecast_breakdown([*near, *elsewhere])
    assert list(found) == ["s", "t", "all"]
    alone, pooled = found["s"]["a"], found["all"]["a"]
    assert (alone["episodes"], pooled["episodes"]) == (1, 2)
    step = alone["by_step"][-1]
    assert step["seconds"] == pytest.approx(1.2)
    assert step["error"]["mean"] == pytest.approx(np.mean(OFF))
    assert step["error"]["low"] is None  # one episode tells nothing of others
    assert step["coverage"]["mean"] == pytest.approx(0.5)
    assert pooled["by_step"][-1]["coverage"]["mean"] == pytest.approx(0.75)
    densities = [round_normal_nll(off, 0.2) for off in OFF]
    assert step["nll"]["mean"] == pytest.approx(np.mean(densities))
    assert alone["by_distance"]["8-"]["nll"]["mean"] == pytest.approx(densities[1])
    assert list(alone["by_distance"]) == ["0-2", "8-"]
    assert alone["by_distance"]["8-"]["fde"]["mean"] == pytest.approx(OFF[1])
    assert alone["by_frames_seen"]["8-"]["ade"]["mean"] == pytest.approx(OFF[0])


def test_who_is_sure_of_everything_has_no_nll() -> None:
    found = forecast_breakdown(cells_of(known_errors(radius=0.0)))["s"]["a"]
    nothing = {"mean": None, "low": None, "high": None, "n": 0}
    assert all(step["nll"] == nothing for step in found["by_step"])
    assert found["by_step"][0]["coverage"]["mean"] == 0.0
    summary = {"arms": {"a": {}}, "forecast_errors": {"s": {"a": found}}}
    section = forecast_section(summary, {"a": "#123456"})
    assert 'nll [nat]</th><td class="missing">' in section


def test_an_interval_resamples_episodes_and_not_forecasts() -> None:
    # Two kinds of episodes with thousands of forecasts each: the interval stays wide.
    sums, counts = np.array([0.0, 1000.0] * 4), np.full(8, 1000.0)
    wide = mean_of_sums(sums, counts, np.random.default_rng(0))
    assert wide.mean == pytest.approx(0.5)
    assert wide.n == 8000
    assert wide.high - wide.low > 0.4
    # Episodes weigh as many forecasts as they hold.
    uneven = mean_of_sums(np.array([1.0, 0.0]), np.array([1.0, 3.0]), np.random.default_rng(0))
    assert uneven.mean == pytest.approx(0.25)
