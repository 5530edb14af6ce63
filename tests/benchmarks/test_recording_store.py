"""Ten million positions through the store: `pytest tests/benchmarks/test_recording_store.py`."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from pytest_benchmark.fixture import BenchmarkFixture

from crowdsim.recordings import Recording, iter_recordings, write_recordings

RECORDINGS, ROWS, PEOPLE = 1000, 500, 20


def crowds() -> Iterator[Recording]:
    """People who walk at their own pace and sway by a few centimetres; ten different crowds."""
    rng = np.random.default_rng(0)
    different = []
    for _ in range(10):
        step = 0.4 * rng.normal(0.0, 0.9, (PEOPLE, 2)) + rng.normal(0.0, 0.03, (ROWS, PEOPLE, 2))
        different.append(
            Recording(
                name="crowd",
                positions=rng.uniform(-20.0, 20.0, (PEOPLE, 2)) + np.cumsum(step, axis=0),
                valid=np.ones((ROWS, PEOPLE), dtype=np.bool_),
                ids=np.arange(PEOPLE),
                frames=np.arange(ROWS),
            )
        )
    for number in range(RECORDINGS):
        yield replace(different[number % len(different)], name=f"crowd-{number}")


def read(folder: Path) -> int:
    return sum(int(recording.valid.sum()) for recording in iter_recordings(folder))


def test_writing(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    benchmark.pedantic(write_recordings, args=(tmp_path, crowds()), rounds=1)
    size = sum(path.stat().st_size for path in tmp_path.glob("*.parquet"))
    benchmark.extra_info["megabytes"] = size / 1e6
    assert size < 30e6


def test_reading(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    write_recordings(tmp_path, crowds())
    rows = benchmark.pedantic(read, args=(tmp_path,), rounds=3, warmup_rounds=1)
    assert rows == RECORDINGS * ROWS * PEOPLE
