"""Windows on the disk are the windows in memory."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hand_made_crowds import walkers

from crowdsim.recordings import Recording
from predictor import window_cache
from predictor.config import ModelConfig
from predictor.window_cache import cached_windows
from predictor.windows import Tracks, cut, extract_windows

CONFIG = ModelConfig(variant="patch")


@pytest.fixture
def crowds() -> list[Recording]:
    rng = np.random.default_rng(0)
    return [walkers(rng, people, 24, name=f"{people}") for people in (3, 12)]


def test_mapped_windows_are_those_in_memory(crowds: list[Recording], tmp_path: Path) -> None:
    memory, mapped = extract_windows(crowds, CONFIG), cached_windows(tmp_path, crowds, CONFIG)
    for name, array in memory.tracks.arrays().items():
        found = mapped.tracks.arrays()[name]
        assert isinstance(found, np.memmap)
        assert found.dtype == array.dtype
        assert np.array_equal(found, array), name
    rows = np.array([7, 0, 3])
    (one, future), (other, other_future) = memory.batch(rows), mapped.batch(rows)
    assert np.array_equal(one.crop, other.crop)
    assert np.array_equal(future, other_future)


def test_cut_once_for_the_same_crowd_and_anew_for_another(
    crowds: list[Recording], tmp_path: Path
) -> None:
    cached_windows(tmp_path, crowds, CONFIG)
    written = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    cached_windows(tmp_path, crowds, replace(CONFIG, latents=6, variant="none"))
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")} == written
    moved = replace(crowds[0], positions=crowds[0].positions + 1.0)
    for others, config, stride in (
        ([moved, crowds[1]], CONFIG, 1),
        (crowds, replace(CONFIG, neighbors=4), 1),
        (crowds, CONFIG, 2),
    ):
        count = len(list(tmp_path.iterdir()))
        cached_windows(tmp_path, others, config, stride=stride)
        assert len(list(tmp_path.iterdir())) == count + 1


def test_another_run_may_cut_the_same_crowd_meanwhile(
    crowds: list[Recording], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def slow_cut(*arguments: Any) -> Iterator[Tracks]:
        monkeypatch.setattr(window_cache, "cut", cut)
        cached_windows(tmp_path, crowds, CONFIG)
        yield from cut(*arguments)

    monkeypatch.setattr(window_cache, "cut", slow_cut)
    found = cached_windows(tmp_path, crowds, CONFIG)
    assert len(found) == len(extract_windows(crowds, CONFIG))
    assert len(list(tmp_path.iterdir())) == 1


def test_nothing_is_left_where_nobody_stays(tmp_path: Path) -> None:
    short = walkers(np.random.default_rng(0), frames=12)
    with pytest.raises(ValueError, match="people who stay for 20 frames"):
        cached_windows(tmp_path, [short], CONFIG)
    assert list(tmp_path.iterdir()) == []


def test_a_torn_file_is_refused(crowds: list[Recording], tmp_path: Path) -> None:
    cached_windows(tmp_path, crowds, CONFIG)
    future = next(tmp_path.glob("*/future"))
    future.write_bytes(future.read_bytes()[:-8])
    with pytest.raises(ValueError, match=r"future: expected \d+ bytes"):
        cached_windows(tmp_path, crowds, CONFIG)
