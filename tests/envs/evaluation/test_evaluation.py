import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

import envs.evaluation.evaluate
import envs.evaluation.finished_tasks
from envs.config import make_config
from envs.evaluation.comparison import Arm, EvaluationConfig, ScenarioChoice, cross, variants
from envs.evaluation.episode_rows import Measured, Row, read_rows
from envs.evaluation.evaluate import Evaluation, Task, evaluate, write_evaluation
from envs.evaluation.finished_tasks import FinishedTasks
from envs.evaluation.metric_table import METRICS
from envs.evaluation.runs import run_episode, run_episodes
from envs.evaluation.summary import ALL_SCENARIOS, summarize

FEW = ScenarioChoice(scenario="circular_crossing", parameters={"pedestrians": 4})
DOOR = ScenarioChoice(scenario="narrow_doorway", parameters={"pedestrians": 4}, title="door")


def small_config(**changes: Any) -> EvaluationConfig:
    fields: dict[str, Any] = {
        "arms": (Arm(policy="straight"), Arm(policy="straight", forecaster="constant_velocity")),
        "scenarios": (FEW, DOOR),
        "seeds": (0, 1, 2),
        "environment": {"time_limit": 6.0},
    }
    return EvaluationConfig(**(fields | changes))


@pytest.fixture(scope="module")
def evaluation() -> Evaluation:
    return evaluate(small_config(), command="crowdnav evaluate")


def comparable(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows without wall-clock time, and with NaN equal to itself."""
    return [
        {key: str(value) for key, value in sorted(row.items()) if key != "forecast_ms"}
        for row in rows
    ]


def test_one_row_per_episode_with_every_metric(evaluation: Evaluation) -> None:
    assert len(evaluation.rows) == 2 * 2 * 3
    assert all(set(METRICS) <= set(row) for row in evaluation.rows)
    keys = [(row["scenario"], row["arm"], row["seed"]) for row in evaluation.rows]
    assert keys[:4] == [
        ("circular_crossing", "straight/none", 0),
        ("circular_crossing", "straight/none", 1),
        ("circular_crossing", "straight/none", 2),
        ("circular_crossing", "straight/constant_velocity", 0),
    ]
    for row in evaluation.rows:
        ends = ("success", "collision_pedestrian", "collision_wall", "timeout")
        assert sum(bool(row[end]) for end in ends) == 1


def test_arms_meet_the_same_episodes(evaluation: Evaluation) -> None:
    # The straight policy ignores forecasts: with and without them its episodes are the same.
    forecast_columns = {"arm", "forecaster", "forecast_ade", "forecast_fde", "forecast_count"}
    with_, without = (
        [
            {key: value for key, value in row.items() if key not in forecast_columns}
            for row in comparable(evaluation.rows)
            if row["arm"] == arm
        ]
        for arm in ("straight/none", "straight/constant_velocity")
    )
    assert with_ == without


def test_workers_and_width_change_nothing(evaluation: Evaluation) -> None:
    counts: list[tuple[int, int]] = []
    other = evaluate(
        small_config(workers=2, width=2), progress=lambda done, of: counts.append((done, of))
    )
    assert comparable(other.rows) == comparable(evaluation.rows)
    for name, group in evaluation.summary["scenarios"].items():
        ours = group["arms"]["straight/none"]["metrics"]["clearance_min"]
        assert (
            other.summary["scenarios"][name]["arms"]["straight/none"]["metrics"]["clearance_min"]
            == ours
        )
    assert counts[-1] == (12, 12)
    assert counts == sorted(counts)


def test_an_episode_does_not_depend_on_those_beside_it() -> None:
    config = make_config(
        scenario="circular_crossing",
        scenario_parameters={"pedestrians": 4},
        forecaster="constant_velocity",
        time_limit=5.0,
    )
    together = dict(run_episodes(config, "mppi", [3, 4, 5, 6, 7], width=2))
    assert sorted(together) == [3, 4, 5, 6, 7]
    alone = run_episode(config, "mppi", 6)
    np.testing.assert_array_equal(together[6].robot_position, alone.robot_position)
    np.testing.assert_array_equal(together[6].position, alone.position)
    np.testing.assert_array_equal(together[6].forecast, alone.forecast)


def test_an_interrupted_evaluation_goes_on_where_it_stopped(
    evaluation: Evaluation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(envs.evaluation.finished_tasks, "source_revision", lambda: "the same one")
    finished = FinishedTasks(tmp_path / "finished")

    def stop_after(done: int, of: int) -> None:
        if done == 7:
            raise KeyboardInterrupt

    config = small_config(width=3)
    with pytest.raises(KeyboardInterrupt):
        evaluate(config, progress=stop_after, finished=finished)
    assert len(list(finished.folder.glob("*.cells.parquet"))) == 2

    simulated = []

    def watched(environment: Any, *arguments: Any, **options: Any) -> Any:
        simulated.append((environment.scenario, environment.forecaster))
        return run_episodes(environment, *arguments, **options)

    monkeypatch.setattr(envs.evaluation.evaluate, "run_episodes", watched)
    resumed = evaluate(config, finished=finished)
    assert comparable(resumed.rows) == comparable(evaluation.rows)
    assert resumed.cells == evaluation.cells
    measured, replayed = simulated[:2], simulated[2:]
    assert sorted(measured) == [("circular_crossing", "none"), ("narrow_doorway", "none")]
    assert len(replayed) == 4


def test_other_tasks_are_not_taken_for_finished(tmp_path: Path) -> None:
    policy = tmp_path / "policy"
    policy.mkdir()
    (policy / "weights").write_bytes(b"1")
    finished = FinishedTasks(tmp_path / "finished")
    config = small_config(arms=(Arm(policy=str(policy)),), seeds=(0, 1))
    choice = config.scenarios[0]

    def task(**changes: Any) -> Task:
        fields = {
            "scenario": choice.name,
            "place": choice.place,
            "arm": "a",
            "policy": str(policy),
            "width": 1,
        }
        environment = config.environment_of(config.arms[0], choice)
        return Task(**(fields | {"environment": environment, "seeds": (0, 1)} | changes))

    row: Row = {"scenario": "s", "seed": 3, "success": True, "time_to_goal": np.nan}
    finished.keep(task(), Measured(rows=[row], cells=[]))
    assert str(finished.measured(task())) == str(Measured(rows=[row], cells=[]))
    assert finished.measured(task(seeds=(0, 2))) is None
    (policy / "weights").write_bytes(b"2")
    assert finished.measured(task()) is None


def test_the_crowd_is_compared_with_its_twin(evaluation: Evaluation) -> None:
    moved = [float(row["pedestrian_displacement"] or 0) for row in evaluation.rows]
    assert all(np.isfinite(moved))
    assert max(moved) > 0.01
    assert min(moved) >= 0.0


def test_an_invisible_robot_displaces_nobody_it_does_not_touch() -> None:
    result = evaluate(
        small_config(
            arms=(Arm(policy="straight"),),
            scenarios=(ScenarioChoice(scenario="parallel_traffic", parameters={"pedestrians": 4}),),
            seeds=tuple(range(6)),
            environment={"time_limit": 6.0, "robot_visible": False},
        )
    )
    untouched = [row for row in result.rows if not row["collision_pedestrian"]]
    assert untouched
    for row in untouched:
        assert row["pedestrian_displacement"] == pytest.approx(0.0, abs=1e-9)


def test_a_replay_cannot_react_and_says_so(data_root: Path) -> None:
    choice = ScenarioChoice(
        scenario="replay",
        parameters={"data": str(data_root / "eth_ucy"), "scene": "crowds_zara01"},
        title="zara",
    )
    result = evaluate(small_config(scenarios=(choice,), arms=(Arm(policy="straight"),)))
    assert all(np.isnan(float(row["pedestrian_delay"] or 0)) for row in result.rows)
    entry = result.summary["scenarios"]["zara"]["arms"]["straight/none"]["metrics"]
    assert entry["pedestrian_delay"] == {"mean": None, "low": None, "high": None, "n": 0}


def test_written_results_read_back(evaluation: Evaluation, tmp_path: Path) -> None:
    write_evaluation(evaluation, tmp_path / "out")
    table = pq.read_table(tmp_path / "out" / "episodes.parquet")
    assert table.num_rows == 12
    assert str(table.schema.field("success").type) == "bool"
    assert str(table.schema.field("collision_role").type) == "string"
    goals = table.column("time_to_goal").to_pylist()
    assert [time is not None for time in goals] == table.column("success").to_pylist()
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["run"]["command"] == "crowdnav evaluate"
    assert summary["scenarios"]["door"]["arms"]["straight/none"]["n"] == 3
    assert summary["scenarios"][ALL_SCENARIOS]["arms"]["straight/none"]["n"] == 6
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "episodes.parquet",
        "forecast_errors.parquet",
        "summary.json",
    ]


def test_written_forecast_errors_add_up_to_the_rows(evaluation: Evaluation, tmp_path: Path) -> None:
    write_evaluation(evaluation, tmp_path / "out")
    cells = read_rows(tmp_path / "out" / "forecast_errors.parquet")
    assert cells == evaluation.cells
    judged = [row for row in evaluation.rows if row["forecast_count"]]
    assert judged
    for row in judged:
        own = [
            cell
            for cell in cells
            if all(cell[key] == row[key] for key in ("scenario", "arm", "seed"))
        ]
        last = max(int(cell["step"]) for cell in own)
        ends = [cell for cell in own if cell["step"] == last]
        assert sum(cell["n"] for cell in ends) == row["forecast_count"]
        total = sum(cell["error_sum"] for cell in ends)
        assert total / row["forecast_count"] == pytest.approx(row["forecast_fde"])
    assert {cell["arm"] for cell in cells} == {"straight/constant_velocity"}


def test_replays_are_of_all_arms_from_one_seed(evaluation: Evaluation) -> None:
    for scenario in ("circular_crossing", "door"):
        kept = [item for item in evaluation.recorded if item.scenario == scenario]
        assert [item.arm for item in kept] == ["straight/none", "straight/constant_velocity"]
        assert len({item.seed for item in kept}) == 1


def test_a_summary_pairs_by_seed_and_not_by_order() -> None:
    def row(arm: str, seed: int, clearance: float) -> dict[str, Any]:
        missing = {key: metric.kind == "share" or np.nan for key, metric in METRICS.items()}
        about = {"scenario": "s", "arm": arm, "policy": arm, "forecaster": "none", "horizon": 4.8}
        return {**missing, **about, "seed": seed, "clearance_min": clearance}

    rows = [row("a", seed, seed) for seed in (0, 1, 2, 3)]
    rows += [row("b", seed, seed + 1) for seed in (3, 1, 0, 2)]
    summary = summarize(rows, reference="a")
    difference = summary["scenarios"]["s"]["differences"]["b"]["clearance_min"]
    assert (difference["mean"], difference["low"], difference["high"]) == (1.0, 1.0, 1.0)
    assert difference["verdict"] == "better"
    with pytest.raises(ValueError, match="same seeds"):
        summarize(rows[:-1], reference="a")


def test_an_interval_does_not_depend_on_what_else_is_measured() -> None:
    def clearance(path_length: Callable[[int], float]) -> Any:
        missing = {key: metric.kind == "share" or np.nan for key, metric in METRICS.items()}
        rows = [
            {
                **missing,
                "scenario": "s",
                "arm": "a",
                "policy": "a",
                "forecaster": "none",
                "horizon": 4.8,
                "seed": seed,
                "path_length": path_length(seed),
                "clearance_min": seed**0.5,
            }
            for seed in range(8)
        ]
        return summarize(rows, reference="a")["scenarios"]["s"]["arms"]["a"]["metrics"][
            "clearance_min"
        ]

    assert clearance(lambda _: np.nan) == clearance(float)


def test_names_of_arms() -> None:
    assert Arm(policy="runs/ppo", forecaster="models/fast").name == "ppo/fast"
    assert [arm.name for arm in cross(["mppi"], ["none", "constant_velocity"])] == [
        "mppi/none",
        "mppi/constant_velocity",
    ]


def test_a_policy_without_forecasts_has_no_horizon() -> None:
    arms = cross(["mppi@9.6", "orca:none"], ["fast"], horizons=[0.0, 0.4, 4.8])
    assert [(arm.name, arm.settings) for arm in arms] == [
        ("mppi@9.6/none", {}),
        ("mppi@9.6/fast 0.4 s", {"horizon": 0.4}),
        ("mppi@9.6/fast 4.8 s", {"horizon": 4.8}),
        ("orca/none", {}),
    ]


def test_a_scenario_is_varied_by_model_and_visibility() -> None:
    assert variants(FEW) == (FEW,)
    varied = variants(DOOR, ["orca", "social_force"], [True, False])
    assert [choice.name for choice in varied] == [
        "door, orca, visible",
        "door, orca, invisible",
        "door, social_force, visible",
        "door, social_force, invisible",
    ]
    assert {choice.place for choice in varied} == {"door"}
    assert varied[1].settings == {"robot_visible": False}
    assert varied[1].parameters == {"pedestrians": 4, "model": "orca"}


def test_every_row_says_what_was_varied() -> None:
    result = evaluate(
        small_config(
            arms=cross(["straight"], ["constant_velocity"], [0.4, 1.2]),
            scenarios=variants(FEW, ["orca", "social_force"], [True, False]),
            seeds=(0, 1),
        )
    )
    keys = ("place", "model", "robot_visible", "horizon", "seed")
    assert len({tuple(row[key] for key in keys) for row in result.rows}) == len(result.rows) == 16
    settings = result.summary["settings"]
    lines = {setting: list(found) for setting, found in settings.items()}
    arms = ["straight/constant_velocity 0.4 s", "straight/constant_velocity 1.2 s"]
    assert lines == {
        "horizon": ["straight/constant_velocity"],
        "robot_visible": arms,
        "model": arms,
    }
    near, far = settings["horizon"]["straight/constant_velocity"]
    assert near["n"] == far["n"] == 8
    assert far["change"]["forecast_fde"]["mean"] > 0.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"arms": ()}, "arms"),
        ({"seeds": (1, 1)}, "seeds"),
        ({"scenarios": (FEW, FEW)}, "scenarios"),
        ({"reference": "mppi/none"}, "straight/none"),
        ({"workers": 0}, "workers"),
        ({"scenarios": (ScenarioChoice(scenario="x", title="all"),)}, "all"),
    ],
)
def test_a_senseless_comparison_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        small_config(**changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"scenarios": (FEW, ScenarioChoice(scenario="moon"))}, "circular_crossing"),
        ({"arms": (Arm(policy="straight"), Arm(policy="clever"))}, "mppi"),
        ({"arms": (Arm(policy="straight", forecaster="crystal_ball"),)}, "constant_velocity"),
        ({"environment": {"speed": 1.0}}, "max_speed"),
    ],
)
def test_a_bad_name_fails_before_anything_runs(changes: dict[str, Any], message: str) -> None:
    counts: list[int] = []
    with pytest.raises((ValueError, FileNotFoundError), match=message):
        evaluate(small_config(**changes), progress=lambda done, of: counts.append(done))
    assert counts == []
