import json
from pathlib import Path
from typing import Any

import cv2
import pytest

from envs.crowd_nav import CrowdNav
from envs.evaluation.comparison import ScenarioChoice
from envs.evaluation.knobs import KNOBS, turned
from envs.evaluation.replays import instructive_failure
from envs.evaluation.stress import Stress, StressConfig, stress
from envs.report import build_stress_report, write_stress
from envs.report.stress_files import stress_table

FEW = ScenarioChoice(scenario="circular_crossing", parameters={"pedestrians": 3})


def small_config(**changes: Any) -> StressConfig:
    fields: dict[str, Any] = {
        "knobs": ("horizon",),
        "values": (0.4, 2.4),
        "policies": ("straight",),
        "forecasters": ("none", "constant_velocity"),
        "scenario": FEW,
        "seeds": (0, 1),
        "environment": {"time_limit": 8.0},
    }
    return StressConfig(**(fields | changes))


@pytest.fixture(scope="module")
def result() -> Stress:
    return stress(small_config())


def test_every_value_runs_the_same_seeds(result: Stress) -> None:
    assert len(result.rows) == 2 * 2 * 2
    points = result.table["knobs"]["horizon"]["curves"]["straight/constant_velocity"]
    assert [point["value"] for point in points] == [0.4, 2.4]
    assert all(point["n"] == 2 for point in points)
    horizons = {row["scenario"]: row["horizon"] for row in result.rows}
    assert horizons == {"horizon=0.4": 0.4, "horizon=2.4": 2.4}


def test_forecasts_err_more_the_farther_they_reach(result: Stress) -> None:
    near, far = (
        point["metrics"]["forecast_fde"]["mean"]
        for point in result.table["knobs"]["horizon"]["curves"]["straight/constant_velocity"]
    )
    assert 0.0 < near < far


def test_the_files_of_a_stress_test(result: Stress, tmp_path: Path) -> None:
    write_stress(result, tmp_path)
    assert json.loads((tmp_path / "stress.json").read_text()) == result.table
    image = cv2.imread(str(tmp_path / "horizon.png"))
    assert image is not None
    assert image.std() > 5
    assert (tmp_path / "horizon.svg").read_text().count("<svg") == 1
    lines = (tmp_path / "stress.md").read_text().splitlines()
    assert len(lines) == 2 + 2 * 2
    assert {line.count("|") for line in lines} == {8}


def test_a_stress_report_shows_each_knob_and_its_failures(tmp_path: Path) -> None:
    two = stress(small_config(knobs=("awareness", "occlusion"), values=(), seeds=(0, 1, 2)))
    assert len({row["scenario"] for row in two.rows}) == 5 + 2
    failed = {(row["scenario"], row["arm"], row["seed"]) for row in two.rows if not row["success"]}
    shown = {(episode.scenario, episode.arm, episode.seed) for episode in two.recorded}
    assert failed
    for knob in ("awareness", "occlusion"):
        of_knob = {episode for episode in failed if str(episode[0]).startswith(knob)}
        assert {arm for _, arm, _ in of_knob} == {arm for _, arm, _ in of_knob & shown}
    text = build_stress_report(two, tmp_path / "report.html").read_text()
    assert text.count('<h2 id="awareness">') == text.count('<h2 id="occlusion">') == 1
    for entry in two.table["knobs"].values():
        assert all(sentence in text for sentence in entry["findings"])
    assert "Success over every knob" in text
    write_stress(two, tmp_path)
    assert (tmp_path / "overview.png").is_file()


def failures(*points: str) -> list[list[dict[str, Any]]]:
    """Episodes at every value of a knob, seeds from 0: + succeeds, - fails."""
    return [
        [{"seed": seed, "success": sign == "+", "at": at} for seed, sign in enumerate(signs)]
        for at, signs in enumerate(points)
    ]


def test_a_failure_is_shown_where_success_falls_most() -> None:
    found = instructive_failure(failures("-+++", "++-+", "-+--", "----"))
    assert found is not None
    assert (found["at"], found["seed"]) == (2, 0)
    # The seed that was mastered at the milder value is the more instructive one.
    found = instructive_failure(failures("-+++", "----"))
    assert found is not None
    assert (found["at"], found["seed"]) == (1, 1)


def test_who_fails_everywhere_is_shown_at_the_first_value() -> None:
    found = instructive_failure(failures("--", "-+"))
    assert found is not None
    assert found["at"] == 0
    assert instructive_failure(failures("++", "++")) is None


def test_a_table_says_where_nothing_is_known(result: Stress) -> None:
    without = stress_table(result.table).splitlines()[2]
    assert without.startswith("| straight/none | 0.4 | 2 |")
    assert without.endswith("| – |")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"knobs": ("gravity",)}, "horizon, density"),
        ({"values": (0.4, 0.4)}, "values"),
        ({"knobs": ("horizon", "density")}, "single knob"),
        ({"knobs": ("horizon", "horizon"), "values": ()}, "each once"),
    ],
)
def test_a_senseless_stress_test_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        small_config(**changes)


def start_of(choice: ScenarioChoice) -> CrowdNav:
    env = CrowdNav(
        scenario=choice.scenario, scenario_parameters=dict(choice.parameters), **choice.settings
    )
    env.reset(seed=0)
    return env


@pytest.mark.parametrize("knob", KNOBS)
def test_every_knob_changes_the_environment_at_every_value(knob: str) -> None:
    choice = ScenarioChoice(scenario="circular_crossing")
    points = [turned(choice, knob, value) for value in KNOBS[knob].values]
    assert len({point.name for point in points}) == len(points)
    assert len({str((point.parameters, point.settings)) for point in points}) == len(points)
    for point in points:
        start_of(point)


def test_a_density_is_that_of_the_ground() -> None:
    people = start_of(turned(ScenarioChoice(scenario="circular_crossing"), "density", 0.1))
    x_min, y_min, x_max, y_max = people.episodes.scenarios[0].map.bounds
    count = people.episodes.worlds.crowd.valid.sum()
    assert count == pytest.approx(0.1 * (x_max - x_min) * (y_max - y_min), abs=0.5)


def test_a_hurried_crowd_wants_to_walk_faster() -> None:
    choice = ScenarioChoice(scenario="circular_crossing")
    usual, fast = (start_of(turned(choice, "crowd_speed", value)) for value in (1.0, 2.0))
    slow_speed, fast_speed = (
        env.episodes.scenarios[0].pedestrians.desired_speed for env in (usual, fast)
    )
    assert fast_speed == pytest.approx(2.0 * slow_speed)


def test_what_is_forgotten_is_not_in_the_history() -> None:
    env = start_of(turned(ScenarioChoice(scenario="circular_crossing"), "history", 3))
    for _ in range(30):
        observation = env.step(env.action_space.sample() * 0.0)[0]
    seen = observation["neighbors_valid"] > 0
    assert not observation["history_valid"][:, :-3].any()
    assert observation["history_valid"][seen][:, -1].all()
    assert not observation["history"][:, :-3].any()
