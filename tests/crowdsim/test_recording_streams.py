"""Recordings longer than memory: stretches are what the whole is, and memory stays flat."""

import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from crowdsim.recordings import (
    Recording,
    iter_eth_ucy,
    iter_stretches,
    iter_trajnet,
    join,
    overlapping,
    read_eth_ucy,
    read_recordings,
    read_trajnet,
    tally,
    write_eth_ucy,
    write_recordings,
    write_trajnet,
)

ROOT = Path(__file__).parents[2]


@pytest.fixture
def crowd() -> Recording:
    """40 people who come and go within 200 rows, some of them empty."""
    rng = np.random.default_rng(3)
    first = rng.integers(0, 150, 40)
    row = np.arange(200)[:, None]
    valid = (first <= row) & (row < first + rng.integers(25, 60, 40))
    valid[90:93] = False
    walk = rng.uniform(-20.0, 20.0, (40, 2)) + np.multiply.outer(
        np.arange(200), rng.uniform(-0.5, 0.5, (40, 2))
    )
    return Recording(
        name="crowd",
        positions=np.where(valid[..., None], np.round(walk, 3), 0.0),
        valid=valid,
        ids=np.arange(40, dtype=np.int64),
        frames=10 * np.arange(200, dtype=np.int64),
    )


@pytest.fixture
def short_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Text in blocks of 300 rows, Parquet in row groups of about 400."""
    monkeypatch.setattr("crowdsim.recordings.text_table.BLOCK_ROWS", 300)
    monkeypatch.setattr("crowdsim.recordings.trajnet.BLOCK_ROWS", 300)
    monkeypatch.setattr("crowdsim.recordings.tracks.GROUP_ROWS", 400)


def stretches(recording: Recording, rows: int) -> list[Recording]:
    parts = np.split(np.arange(len(recording.frames)), range(rows, len(recording.frames), rows))
    return [
        replace(
            recording,
            positions=recording.positions[part],
            valid=recording.valid[part],
            frames=recording.frames[part],
        )
        for part in parts
    ]


def windows(recordings: list[Recording]) -> list[tuple[int, int, tuple[float, ...]]]:
    """Every agent of every window of 20 rows: first frame, person, path."""
    return sorted(
        (int(part.frames[row]), int(part.ids[column]), tuple(path.ravel()))
        for part in recordings
        for row in part.windows()
        for column in np.flatnonzero(part.valid[row : row + 20].all(axis=0))
        for path in [part.positions[row : row + 20, column]]
    )


def assert_same(found: Recording, expected: Recording) -> None:
    assert (found.name, found.dt) == (expected.name, expected.dt)
    np.testing.assert_array_equal(found.frames, expected.frames)
    np.testing.assert_array_equal(found.ids, expected.ids)
    np.testing.assert_array_equal(found.valid, expected.valid)
    np.testing.assert_allclose(found.positions, expected.positions, atol=1e-9)


@pytest.mark.usefixtures("short_blocks")
def test_a_long_recording_comes_back_in_stretches_and_whole(crowd, tmp_path):
    write_recordings(tmp_path, [*stretches(crowd, 37), replace(crowd, name="other")])
    parts = [part for part in iter_stretches(tmp_path) if part.name == "crowd"]
    assert len(parts) > 2
    assert all(a.frames[-1] < b.frames[0] for a, b in pairwise(parts))
    assert_same(join(parts), crowd)
    whole, other = read_recordings(tmp_path)
    assert_same(whole, crowd)
    assert_same(replace(other, name="crowd"), crowd)


@pytest.mark.usefixtures("short_blocks")
@pytest.mark.parametrize(
    ("file", "write", "iterate", "read"),
    [
        ("crowd.txt", write_eth_ucy, iter_eth_ucy, read_eth_ucy),
        ("crowd.ndjson", write_trajnet, iter_trajnet, lambda path: read_trajnet(path).recording),
    ],
)
def test_long_text_is_read_in_stretches(crowd, tmp_path, file, write, iterate, read):
    path = tmp_path / file
    write(path, stretches(crowd, 23))
    parts = list(iterate(path))
    assert len(parts) > 2
    seen = crowd.valid.any(axis=1)
    listed = replace(
        crowd, positions=crowd.positions[seen], valid=crowd.valid[seen], frames=crowd.frames[seen]
    )
    assert_same(join(parts), listed)
    assert_same(read(path), listed)


def test_scenes_across_stretches_are_those_of_the_whole(crowd, tmp_path):
    write_trajnet(tmp_path / "whole.ndjson", [crowd])
    write_trajnet(tmp_path / "parts.ndjson", stretches(crowd, 23))
    whole, parts = (read_trajnet(tmp_path / f"{name}.ndjson") for name in ("whole", "parts"))
    assert len(whole.scenes) > 20
    assert whole.scenes == parts.scenes


@pytest.mark.parametrize("rows", [1, 7, 30])
def test_overlapping_stretches_have_every_window_once(crowd, rows):
    assert windows(list(overlapping(stretches(crowd, rows), 19))) == windows([crowd])


@pytest.mark.usefixtures("short_blocks")
def test_long_text_that_is_not_sorted_by_frame_is_refused(crowd, tmp_path):
    path = tmp_path / "crowd.txt"
    write_eth_ucy(path, [crowd])
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join([*lines[len(lines) // 2 :], *lines[: len(lines) // 2]]))
    with pytest.raises(ValueError, match=r"crowd\.txt: expected .* sorted by frame"):
        read_eth_ucy(path)


def test_stretches_out_of_order_are_refused(crowd, tmp_path):
    with pytest.raises(ValueError, match="crowd: expected a stretch after frame 1990"):
        write_recordings(tmp_path, reversed(stretches(crowd, 100)))
    assert not list(tmp_path.glob("*.parquet")) + list(tmp_path.glob(".*"))


def test_names_that_come_back_are_refused(crowd, tmp_path):
    with pytest.raises(ValueError, match="names of recordings must be unique, got 'crowd'"):
        write_recordings(tmp_path, [crowd, replace(crowd, name="other"), crowd])


def test_counts_of_stretches_are_those_of_the_whole(crowd):
    whole, parts = tally(crowd), stretches(crowd, 50)
    counts = tally(parts[0])
    for part in parts[1:]:
        counts.add(part)
    assert (counts.rows, counts.positions, counts.ids) == (whole.rows, whole.positions, whole.ids)
    assert counts.mean_speed == pytest.approx(whole.mean_speed, rel=0.01)


STREAM = """
import sys
from pathlib import Path
import numpy as np
from crowdsim.recordings import Recording, iter_eth_ucy, iter_stretches, write_recordings
from crowdsim.recordings import text_table, tracks, write_eth_ucy

tracks.GROUP_ROWS, text_table.BLOCK_ROWS = 20_000, 5_000

def crowd(stretches):
    rng, ids = np.random.default_rng(0), np.arange(20)
    for number in range(stretches):
        walk = rng.uniform(-20, 20, (1, 20, 2)) + 0.4 * np.arange(1000)[:, None, None]
        frames = 1000 * number + np.arange(1000)
        yield Recording(name="crowd", positions=walk, valid=np.ones((1000, 20), dtype=bool),
                        ids=ids + 20 * number, frames=frames)

folder = Path(sys.argv[1])
write_recordings(folder / "set", crowd(int(sys.argv[2])))
write_eth_ucy(folder / "crowd.txt", iter_stretches(folder / "set"))
rows = sum(int(part.valid.sum()) for part in iter_eth_ucy(folder / "crowd.txt"))
status = Path("/proc/self/status").read_text()
print(rows, status.split("VmHWM:")[1].split()[0])
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs the peak of /proc")
def test_memory_stays_flat_in_both_directions(tmp_path):
    """Through the store and through text: six times the rows, 13 MB more as arrays."""
    peaks = []
    for count in (4, 24):
        command = [sys.executable, "-c", STREAM, tmp_path / str(count), str(count)]
        process = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        rows, peak = map(int, process.stdout.split())
        assert rows == 20_000 * count
        peaks.append(peak / 1024)
    assert peaks[1] - peaks[0] < 5.0, peaks
