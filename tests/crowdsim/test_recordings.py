"""What a recording is, and that its store gives back what it was given."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crowdsim.recordings import (
    Picture,
    Recording,
    check_rate,
    read_recordings,
    write_recordings,
)


def walkers(
    name: str = "walkers", people: int = 3, steps: int = 25, speed: float = 1.2
) -> Recording:
    """People who walk along +x side by side; the last one is absent in the first five rows."""
    time = 0.4 * np.arange(steps)
    positions = np.zeros((steps, people, 2))
    positions[..., 0] = speed * time[:, None]
    positions[..., 1] = np.arange(people)
    valid = np.ones((steps, people), dtype=np.bool_)
    valid[:5, -1] = False
    positions[~valid] = 0.0
    return Recording(
        name=name,
        positions=positions,
        valid=valid,
        ids=np.arange(people, dtype=np.int64) + 7,
        frames=10 * np.arange(steps, dtype=np.int64),
    )


def picture(gray: int = 90) -> Picture:
    return Picture(np.full((4, 6, 3), gray, dtype=np.uint8), np.diag([10.0, -10.0, 1.0]))


def test_rows_in_any_order_give_the_same_recording():
    rng = np.random.default_rng(0)
    expected = walkers()
    row, person = np.nonzero(expected.valid)
    order = rng.permutation(len(row))
    row, person = row[order], person[order]
    found = Recording.from_rows(
        "walkers", expected.frames[row], expected.ids[person], expected.positions[row, person]
    )
    np.testing.assert_array_equal(found.positions, expected.positions)
    np.testing.assert_array_equal(found.valid, expected.valid)
    np.testing.assert_array_equal(found.ids, expected.ids)


def test_a_person_cannot_be_twice_in_a_frame():
    with pytest.raises(ValueError, match="repeat a person"):
        Recording.from_rows("twice", np.array([0, 0]), np.array([1, 1]), np.zeros((2, 2)))


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("positions", np.zeros((25, 3)), r"positions must be \(25, 3, 2\)"),
        ("valid", np.ones((25, 3)), "valid must be .* bool"),
        ("positions", np.full((25, 3, 2), np.nan), "finite"),
        ("positions", np.ones((25, 3, 2)), "0 where not valid"),
        ("frames", np.zeros(25, dtype=np.int64), "increase"),
        ("ids", np.zeros(3, dtype=np.int64), "unique"),
        ("dt", 0.0, "dt must be positive"),
    ],
)
def test_contradictions_are_named(field, value, message):
    with pytest.raises(ValueError, match=message):
        replace(walkers(), **{field: value})


def test_windows_are_consecutive_listed_rows():
    recording = walkers(steps=25)
    assert list(recording.windows()) == [0, 1, 2, 3, 4, 5]
    assert list(recording.windows(stride=2)) == [0, 2, 4]
    assert list(recording.windows(history_steps=20, forecast_steps=6)) == []


def test_regular_puts_unlisted_frames_back():
    full = walkers(steps=8)
    listed = [0, 1, 4, 5, 7]
    gaps = replace(
        full, positions=full.positions[listed], valid=full.valid[listed], frames=full.frames[listed]
    )
    regular = gaps.regular()
    np.testing.assert_array_equal(regular.frames, full.frames)
    np.testing.assert_array_equal(regular.positions[listed], gaps.positions)
    assert not regular.valid[[2, 3, 6]].any()


def test_mean_speed_leaves_gaps_out():
    recording = walkers(speed=1.2)
    assert recording.mean_speed == pytest.approx(1.2)
    listed = [0, 1, 10, 11]
    jump = replace(
        recording,
        positions=recording.positions[listed],
        valid=recording.valid[listed],
        frames=recording.frames[listed],
    )
    assert jump.mean_speed == pytest.approx(1.2)


def test_a_time_step_that_the_speeds_contradict_is_refused():
    check_rate(walkers())
    with pytest.raises(ValueError, match=r"12\.00 m/s"):
        check_rate(replace(walkers(), dt=0.04))
    frames = np.cumsum(np.r_[0, np.tile([10, 25], 12)]).astype(np.int64)
    with pytest.raises(ValueError, match="10 frames apart"):
        check_rate(replace(walkers(), frames=frames))


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.integers(1, 30))
def test_store_is_exact_to_half_a_millimetre(tmp_path_factory, seed, people, steps):
    rng = np.random.default_rng(seed)
    valid = rng.random((steps, people)) < 0.7
    valid[0] = True  # people who are never seen are not stored
    positions = np.where(valid[..., None], rng.uniform(-500.0, 500.0, (steps, people, 2)), 0.0)
    original = Recording(
        name="random",
        positions=positions,
        valid=valid,
        ids=np.sort(rng.choice(10**9, people, replace=False)),
        frames=np.cumsum(rng.integers(1, 50, steps)),
        dt=0.25,
    )
    folder = tmp_path_factory.mktemp("store")
    write_recordings(folder, [original])
    (found,) = read_recordings(folder)
    assert (found.name, found.dt, found.picture) == ("random", 0.25, None)
    np.testing.assert_array_equal(found.ids, original.ids)
    np.testing.assert_array_equal(found.frames, original.frames)
    np.testing.assert_array_equal(found.valid, original.valid)
    assert np.abs(found.positions - original.positions).max() <= 0.0005 + 1e-12


def test_rows_without_anybody_survive_the_store(tmp_path):
    recording = walkers()
    valid, positions = recording.valid.copy(), recording.positions.copy()
    valid[10:14], positions[10:14] = False, 0.0
    write_recordings(tmp_path / "set", [replace(recording, valid=valid, positions=positions)])
    (found,) = read_recordings(tmp_path / "set")
    np.testing.assert_array_equal(found.valid, valid)


def test_maps_are_stored_once_and_exactly(tmp_path):
    recordings = [
        replace(walkers("a"), picture=picture(90)),
        replace(walkers("b"), picture=picture(90)),
        replace(walkers("c"), picture=picture(200)),
    ]
    write_recordings(tmp_path / "set", recordings)
    assert len(list((tmp_path / "set").glob("map-*.png"))) == 2
    for found, original in zip(read_recordings(tmp_path / "set"), recordings, strict=True):
        np.testing.assert_array_equal(found.map_image, original.map_image)
        np.testing.assert_array_equal(found.pixel_from_world, original.pixel_from_world)


def test_the_same_recordings_give_the_same_bytes(tmp_path):
    for folder in ("one", "two"):
        write_recordings(tmp_path / folder, [replace(walkers(), picture=picture())])
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes()


def test_damage_is_noticed(tmp_path):
    write_recordings(tmp_path, [walkers()])
    shard = tmp_path / "tracks-00000.parquet"
    content = bytearray(shard.read_bytes())
    content[len(content) // 2] ^= 1
    shard.write_bytes(content)
    with pytest.raises(ValueError, match=r"tracks-00000.*damaged"):
        read_recordings(tmp_path)


def test_a_data_set_is_not_overwritten_and_not_guessed(tmp_path):
    write_recordings(tmp_path, [walkers()])
    with pytest.raises(FileExistsError, match=r"manifest\.json"):
        write_recordings(tmp_path, [walkers()])
    with pytest.raises(FileNotFoundError, match="expected a data set"):
        read_recordings(tmp_path / "elsewhere")
    manifest = tmp_path / "manifest.json"
    manifest.write_text(json.dumps({**json.loads(manifest.read_text()), "version": 99}))
    with pytest.raises(ValueError, match="version 1, found"):
        read_recordings(tmp_path)


def test_a_set_without_anybody_is_refused(tmp_path: Path):
    empty = walkers()
    empty = replace(
        empty, valid=np.zeros_like(empty.valid), positions=np.zeros_like(empty.positions)
    )
    with pytest.raises(ValueError, match="found nobody"):
        write_recordings(tmp_path, [empty])
    assert not (tmp_path / "manifest.json").exists()


def test_recordings_need_no_simulator():
    code = """
import importlib, pkgutil, sys
import crowdsim.recordings as package
for module in pkgutil.iter_modules(package.__path__, package.__name__ + "."):
    importlib.import_module(module.name)
print(*sys.modules)
"""
    process = subprocess.run(
        [sys.executable, "-c", code],
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        check=True,
    )
    loaded = set(process.stdout.split())
    assert not loaded & {"pymunk", "torch", "numba", "shapely", "gymnasium", "predictor", "envs"}
    ours = {name for name in loaded if name.startswith("crowdsim.")}
    assert all(name.startswith("crowdsim.recordings") for name in ours)
