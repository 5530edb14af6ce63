"""Commands end to end, as small as they get; what they compute is tested beside the packages."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest
import yaml
from command_line import Crowdnav

from predictor.forecaster import BUNDLED_WEIGHTS
from scripts.demo import scenarios


def test_evaluation_leaves_report_rows_summary_and_configuration(
    crowdnav: Crowdnav, tmp_path: Path
) -> None:
    arguments = ["evaluate", "--policies", "straight,mppi", "--forecasters", "constant_velocity"]
    arguments += ["--scenarios", "circular_crossing", "--seeds", "2", "--seed", "5"]
    folder, copy = tmp_path / "results", tmp_path / "summary.json"
    assert crowdnav(*arguments, "--out", folder, "--json", copy).status == 0

    rows = pq.read_table(folder / "episodes.parquet").to_pylist()
    assert [(row["policy"], row["seed"]) for row in rows] == [
        ("straight", 5),
        ("straight", 6),
        ("mppi", 5),
        ("mppi", 6),
    ]
    assert json.loads(copy.read_text()) == json.loads((folder / "summary.json").read_text())
    assert "<html" in (folder / "report.html").read_text()
    again = crowdnav("evaluate", "--config", folder / "config.yaml", "--print_config").out
    assert yaml.safe_load(again)["policies"] == ["straight", "mppi"]


def test_an_evaluation_is_varied_from_the_command_line(crowdnav: Crowdnav, tmp_path: Path) -> None:
    arguments = ["evaluate", "--policies", "straight", "--forecasters", "constant_velocity"]
    arguments += ["--scenarios", "circular_crossing", "--seeds", "1", "--horizons", "[0,0.4,1.2]"]
    arguments += ["--models", "orca", "--robot_visible", "[true,false]", "--out", tmp_path]
    assert crowdnav(*arguments).status == 0
    rows = pq.read_table(tmp_path / "episodes.parquet").to_pylist()
    assert {row["arm"] for row in rows} == {
        "straight/none",
        "straight/constant_velocity 0.4 s",
        "straight/constant_velocity 1.2 s",
    }
    assert {(row["model"], row["robot_visible"]) for row in rows} == {
        ("orca", True),
        ("orca", False),
    }
    again = crowdnav("evaluate", "--config", tmp_path / "config.yaml", "--print_config").out
    assert yaml.safe_load(again)["horizons"] == [0, 0.4, 1.2]


def test_a_stress_test_leaves_a_report_on_every_knob(crowdnav: Crowdnav, tmp_path: Path) -> None:
    arguments = ["stress", "--knob", "awareness,occlusion", "--policies", "straight"]
    arguments += ["--forecasters", "constant_velocity", "--seeds", "1", "--out", tmp_path]
    assert crowdnav(*arguments).status == 0
    assert {path.name for path in tmp_path.iterdir()} == {
        "report.html",
        "stress.json",
        "stress.md",
        "episodes.parquet",
        "forecast_errors.parquet",
        "config.yaml",
        *(
            f"{plot}.{kind}"
            for plot in ("awareness", "occlusion", "overview")
            for kind in ("svg", "png")
        ),
    }
    assert list(json.loads((tmp_path / "stress.json").read_text())["knobs"]) == [
        "awareness",
        "occlusion",
    ]


def test_data_is_generated_learned_and_measured(crowdnav: Crowdnav, tmp_path: Path) -> None:
    data, weights, table = tmp_path / "data", tmp_path / "weights", tmp_path / "table.json"
    generate = ["generate", "--scenario", "circular_crossing", "--seconds", 12, "--hours", 0.01]
    assert crowdnav(*generate, "--out", data).status == 0
    train = ["train-predictor", "--data", data, "--epochs", 1, "--out", weights]
    assert crowdnav(*train).status == 0
    measure = ["evaluate-predictor", "--forecaster", weights, "--data", data, "--json", table]
    assert crowdnav(*measure).status == 0

    found = json.loads(table.read_text())
    assert set(found) >= {"folds", "mean", "protocol"}
    assert found["folds"]["data"]["n"] > 100
    assert yaml.safe_load((weights / "config.yaml").read_text())["epochs"] == 1


def test_the_same_crowds_are_not_generated_twice_into_a_folder(
    crowdnav: Crowdnav, tmp_path: Path
) -> None:
    generate = ["generate", "--scenario", "circular_crossing", "--seconds", 12, "--hours", 0.003]
    assert crowdnav(*generate, "--out", tmp_path).status == 0
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    outcome = crowdnav(*generate, "--seed", 1, "--out", tmp_path)
    assert outcome.status == 2
    assert outcome.err.count("\n") == 1
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_data_set_is_resumed_with_the_same_options_only(
    crowdnav: Crowdnav, tmp_path: Path
) -> None:
    generate = ["generate", "--scenario", "circular_crossing", "--seconds", 12, "--hours", 0.003]
    generate += ["--model", "orca", "--out", tmp_path, "--resume"]
    for _ in range(2):
        assert crowdnav(*generate).status == 0
    assert "model was" in crowdnav(*generate, "--model", "social_force").err


def test_a_scenario_file_is_evaluated_by_its_name(crowdnav: Crowdnav, tmp_path: Path) -> None:
    file = Path(__file__).parents[2] / "docs" / "plaza.yaml"
    arguments = ["--policies", "straight", "--forecasters", "none", "--seeds", 1]
    found = crowdnav("evaluate", "--scenarios", file, *arguments, "--out", tmp_path)
    assert found.status == 0, found.err
    assert json.loads((tmp_path / "summary.json").read_text())["scenarios"].keys() == {"plaza"}


@pytest.mark.parametrize("suffix", [".png", ".webm"])
def test_render_draws_an_episode(crowdnav: Crowdnav, tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"episode{suffix}"
    easy = ["--scenario_parameters", '{"pedestrians": 1}', "--forecaster", "constant_velocity"]
    assert crowdnav("render", "--scenario", "circular_crossing", *easy, "--out", file).status == 0
    assert file.stat().st_size > 1000
    assert yaml.safe_load(file.with_suffix(".yaml").read_text())["policy"] == "mppi"


def test_demo_takes_the_real_crowd_where_it_is_found(data_root: Path) -> None:
    assert scenarios(data_root)[-1].parameters["data"] == str(data_root / "eth_ucy")


def test_demo_does_without_the_real_crowd(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("CROWDNAV_DATA", str(tmp_path))
    assert "replay" not in [choice.scenario for choice in scenarios(None)]
    assert str(tmp_path) in capsys.readouterr().out


def test_the_predictor_of_the_demo_is_in_the_repository() -> None:
    assert BUNDLED_WEIGHTS["iterative_attention"].is_file()
