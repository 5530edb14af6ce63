"""The table of several forecasters."""

from pathlib import Path

import numpy as np
import pytest
from hand_made_crowds import baseline, walkers

from crowdsim.recordings import write_recordings
from predictor.checkpoint import save_checkpoint
from predictor.comparison import compare
from predictor.evaluate import evaluate
from predictor.forecaster import make_forecaster


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    rng = np.random.default_rng(0)
    write_recordings(tmp_path / "crowds", [walkers(rng, 4, 21, "one"), walkers(rng, 3, 20, "two")])
    for seed in (3, 4, 5):
        path = tmp_path / f"mlp-crowds-{seed}" / "best.safetensors"
        save_checkpoint(path, baseline("history_mlp", seed=seed), {})
    return tmp_path


def test_columns_are_what_each_forecaster_gives_alone(folder: Path) -> None:
    spec, data = str(folder / "mlp-{fold}-{seed}"), str(folder / "crowds")
    found = compare([spec], data, seeds=[3, 4, 5]).table
    assert list(found["columns"]) == ["constant_velocity", spec]
    tables = {}
    for name in ("constant_velocity", *(str(folder / f"mlp-crowds-{s}") for s in (3, 4, 5))):
        forecaster = make_forecaster(name)
        assert forecaster is not None
        tables[name] = evaluate(forecaster, data)
    baseline_row, *rows = (table["folds"]["crowds"] for table in tables.values())
    assert found["columns"]["constant_velocity"]["folds"]["crowds"] == baseline_row
    row = found["folds"]["crowds"]
    assert row["fde"] == pytest.approx(np.mean([r["fde"] for r in rows]))
    assert row["fde_sd"] == pytest.approx(np.std([r["fde"] for r in rows], ddof=1))
    assert row["moving"]["ade"] == pytest.approx(np.mean([r["moving"]["ade"] for r in rows]))
    assert row["n"] == rows[0]["n"]
    assert found["seeds"] == [3, 4, 5]
    assert found["protocol"] == tables[str(folder / "mlp-crowds-3")]["protocol"]
    assert list(found["by_seed"]) == ["3", "4", "5"]


def test_a_missing_checkpoint_is_told_before_the_data_is_read(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="mlp-crowds-0"):
        compare([str(tmp_path / "mlp-{fold}-{seed}")], str(tmp_path / "crowds"))
    with pytest.raises(ValueError, match="forecasts, found 'none'"):
        compare(["none"], str(tmp_path / "crowds"))
