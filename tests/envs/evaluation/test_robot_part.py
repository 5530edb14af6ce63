"""Forecast errors split by twins: into the model's own part and what the robot caused."""

import html
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hand_made_traces import make_trace, make_twin, walk

from envs.config import make_config
from envs.evaluation.branches import INTERVAL
from envs.evaluation.forecast_breakdown import forecast_breakdown
from envs.evaluation.forecast_cells import forecast_cells
from envs.evaluation.forecast_scores import scored_forecasts
from envs.evaluation.robot_part import robot_part
from envs.evaluation.runs import run_episodes
from envs.report.forecast_section import forecast_section
from envs.trace import Branch, Trace

STEPS, FRAMES = 25, 3
ABOUT = {"scenario": "s", "arm": "a", "policy": "p", "forecaster": "f", "horizon": 1.2, "seed": 0}


def branched(**changes: Any) -> Trace:
    """Somebody who stood at (2, 2), of whom (2, 2.5) was forecast; the twins say otherwise."""
    robot = walk((2.0, 0.0), (0.0, 0.0), STEPS)
    person = walk((2.0, 2.0), (0.0, 0.0), STEPS)
    twins = {
        name: make_twin([np.tile([2.0, y], (FRAMES, 1))], **changes)
        for name, y in (("absent", 2.4), ("standing", 2.1))
    }
    forecast = np.tile([2.0, 2.5], (STEPS + 1, 1, FRAMES, 1))
    return make_trace(
        robot,
        [person],
        forecast=forecast,
        forecast_ids=np.zeros((STEPS + 1, 1), np.int64),
        branches=(Branch(row=4, **twins),),
    )


def test_an_error_is_split_by_the_twin_without_a_robot() -> None:
    trace = branched()
    scored = scored_forecasts(trace)
    part = robot_part(trace, scored)
    np.testing.assert_array_equal(np.flatnonzero(part.known), np.flatnonzero(scored.row == 4))
    np.testing.assert_allclose(scored.error[part.known], 0.5)
    np.testing.assert_allclose(part.model_error[part.known], 0.1)
    np.testing.assert_allclose(part.displacement[part.known], 0.4)
    np.testing.assert_allclose(part.standing_displacement[part.known], 0.3)
    steps = forecast_breakdown(forecast_cells(trace, ABOUT))["s"]["a"]["robot_part"]
    assert [step["error"]["n"] for step in steps] == [1] * FRAMES
    assert steps[-1]["caused"]["mean"] == pytest.approx(0.4)


def test_somebody_who_leaves_in_a_twin_is_not_compared() -> None:
    trace = branched(ids=np.array([[0], [0], [7]]))
    assert not robot_part(trace, scored_forecasts(trace)).known.any()


def test_the_report_tells_the_parts_apart() -> None:
    cells = forecast_cells(branched(), ABOUT)
    summary = {"arms": {"a": {}}, "forecast_errors": forecast_breakdown(cells)}
    section = forecast_section(summary, {"a": "#123456"})
    shown = section[section.index("What the robot itself caused") :]
    assert "model's own error" in html.unescape(shown)
    assert "<td>0.10<small>no interval, n 1</small></td>" in shown
    assert "<td>0.40<small>no interval, n 1</small></td>" in shown


def episode_of(scene: Callable[..., str], people: Any, goals: Any, **settings: Any) -> Trace:
    config = make_config(
        scenario=scene(people=people, goals=goals, goal=(19.0, 0.0), time_limit=12.6),
        forecaster="constant_velocity",
        **settings,
    )
    return next(run_episodes(config, "straight", [0], 1, branched=True))[1]


def test_a_robot_that_is_invisible_and_far_away_displaces_nobody(scene: Callable[..., str]) -> None:
    people, goals = [[-9.0, 9.0], [-9.0, 12.0]], [[-9.0, 18.0], [-9.0, -18.0]]
    trace = episode_of(scene, people, goals, robot_visible=False, sensor_range=30.0)
    first, stride = round(7 * trace.frame_dt / trace.dt), round(INTERVAL / trace.dt)
    assert [branch.row for branch in trace.branches][:2] == [first, first + stride]
    scored = scored_forecasts(trace)
    part = robot_part(trace, scored)
    assert part.known.sum() == 4  # two people at two moments
    assert (part.displacement == 0.0).all()
    assert (part.standing_displacement == 0.0).all()
    np.testing.assert_array_equal(part.model_error[part.known], scored.error[part.known])
    assert part.model_error.max() > 0.0


def test_a_robot_in_the_way_displaces_people_within_the_triangle(scene: Callable[..., str]) -> None:
    trace = episode_of(scene, [[12.0, 0.6]], [[-18.0, 0.6]], sensor_range=30.0)
    scored = scored_forecasts(trace)
    part = robot_part(trace, scored)
    assert part.known.any()
    assert part.displacement.max() > 0.1
    error = scored.error[part.known]
    bound = part.model_error[part.known] + part.displacement[part.known]
    assert (error <= bound + 1e-12).all()


def test_branches_change_nothing_of_what_happens(scene: Callable[..., str]) -> None:
    config = make_config(
        scenario=scene(people=[[12.0, 0.6]], goals=[[-18.0, 0.6]], goal=(18.0, 0.0)),
        forecaster="constant_velocity",
    )
    with_, without = (
        dict(run_episodes(config, "straight", [0, 1, 2], 2, branched=branched))
        for branched in (True, False)
    )
    for seed, trace in without.items():
        assert trace.branches == ()
        assert with_[seed].branches
        np.testing.assert_array_equal(with_[seed].position, trace.position)
        np.testing.assert_array_equal(with_[seed].robot_position, trace.robot_position)
