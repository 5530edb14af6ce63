import json
from pathlib import Path

import cv2
import pytest

from envs.comparison import ScenarioChoice
from envs.stress import Stress, StressConfig, stress, stress_table, write_stress

FEW = ScenarioChoice(scenario="circular_crossing", parameters={"pedestrians": 3})


@pytest.fixture(scope="module")
def result() -> Stress:
    return stress(
        StressConfig(
            forecasters=("constant_velocity",),
            scenario=FEW,
            seeds=(0, 1),
            horizons=(0.4, 2.4),
            environment={"time_limit": 8.0},
        )
    )


def test_every_horizon_runs_the_same_seeds(result: Stress) -> None:
    assert len(result.rows) == 3 * 2
    points = result.table["curves"]["constant_velocity"]
    assert [point["horizon"] for point in points] == [0.4, 2.4]
    assert all(point["n"] == 2 for point in points)
    assert result.table["without"]["n"] == 2
    horizons = {row["arm"]: row["horizon"] for row in result.rows}
    assert horizons["constant_velocity@2.4s"] == 2.4


def test_forecasts_err_more_the_farther_they_reach(result: Stress) -> None:
    near, far = (
        point["metrics"]["forecast_fde"]["mean"]
        for point in result.table["curves"]["constant_velocity"]
    )
    assert 0.0 < near < far


def test_the_files_of_a_stress_test(result: Stress, tmp_path: Path) -> None:
    write_stress(result, tmp_path)
    assert json.loads((tmp_path / "stress.json").read_text()) == result.table
    image = cv2.imread(str(tmp_path / "stress.png"))
    assert image is not None
    assert image.std() > 5
    assert (tmp_path / "stress.svg").read_text().count("<svg") == 1
    lines = (tmp_path / "stress.md").read_text().splitlines()
    assert len(lines) == 2 + 1 + 2
    assert {line.count("|") for line in lines} == {8}


def test_a_table_says_where_nothing_is_known(result: Stress) -> None:
    without = stress_table(result.table).splitlines()[2]
    assert without.startswith("| none | – | 2 |")
    assert without.endswith("| – |")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"horizons": ()}, "horizons"),
        ({"forecasters": ("none",)}, "none"),
        ({"horizons": (0.4, 0.4)}, "horizons"),
    ],
)
def test_a_senseless_stress_test_is_refused(
    changes: dict[str, tuple[object, ...]], message: str
) -> None:
    fields = {"forecasters": ("constant_velocity",), "scenario": FEW, "seeds": (0,)} | changes
    with pytest.raises(ValueError, match=message):
        StressConfig(**fields)
