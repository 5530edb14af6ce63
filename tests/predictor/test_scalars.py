"""Scalars for TensorBoard."""

import sys
from pathlib import Path

import pytest

from predictor.scalars import scalar_writer


def test_scalars_come_back(tmp_path: Path) -> None:
    accumulator = pytest.importorskip("tensorboard.backend.event_processing.event_accumulator")
    with scalar_writer(tmp_path, 0) as write:
        write(20, {"train/loss": 0.5})
        write(40, {"train/loss": 0.25})
    with scalar_writer(tmp_path, 30) as write:
        write(40, {"train/loss": 0.125})
    events = accumulator.EventAccumulator(str(tmp_path)).Reload()
    assert [(e.step, e.value) for e in events.Scalars("train/loss")] == [(20, 0.5), (40, 0.125)]


def test_nothing_is_written_where_nothing_is_asked_for(tmp_path: Path) -> None:
    with scalar_writer(None, 0) as write:
        write(1, {"train/loss": 0.5})
    assert list(tmp_path.iterdir()) == []


def test_a_missing_package_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torch.utils.tensorboard", None)
    with (
        pytest.raises(ValueError, match=r"pip install 'crowdnav-testbed\[tensorboard\]'"),
        scalar_writer(tmp_path, 0),
    ):
        pass
