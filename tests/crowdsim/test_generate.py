"""Data sets of simulated crowds: reproducible, populated, and what the world did."""

import json
from pathlib import Path

import numpy as np
import pytest

from crowdsim.generate import PER_SHARD, Plan, generate_dataset
from crowdsim.record import PHYSICS_DT, record
from crowdsim.recordings import iter_recordings, read_recordings
from crowdsim.scenarios import make_scenario
from crowdsim.world import World


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_the_bytes_do_not_depend_on_the_workers(tmp_path):
    length = {"hours": (PER_SHARD + 1) * 10.0 / 3600.0, "seconds": 10.0, "warmup": 0.0}
    length["scenarios"] = ["urban_crossing", "narrow_doorway"]
    for workers in (1, 2):
        folder = tmp_path / str(workers)
        generate_dataset(folder, **length, seed=5, workers=workers, progress=False)
    assert files(tmp_path / "1") == files(tmp_path / "2")
    recordings = read_recordings(tmp_path / "1")
    assert len({recording.name for recording in recordings}) == PER_SHARD + 1


def test_a_recording_is_what_the_world_did():
    scenario = make_scenario("narrow_doorway", np.random.default_rng(1))
    recording = record(scenario, np.random.default_rng(2), name="doorway", seconds=10.0, warmup=1.0)
    world = World(scenario, rng=np.random.default_rng(2), physics_dt=PHYSICS_DT)
    for _ in range(20):
        world.step()
    for row in range(25):
        np.testing.assert_array_equal(recording.positions[row], world.positions)
        for _ in range(8):
            world.step()


def test_people_who_enter_are_new_people():
    scenario = make_scenario("parallel_traffic", np.random.default_rng(0), pedestrians=12)
    recording = record(scenario, np.random.default_rng(0), name="corridor", seconds=30.0)
    both = recording.valid[1:] & recording.valid[:-1]
    step = np.linalg.norm(np.diff(recording.positions, axis=0), axis=-1)[both]
    first_row = recording.valid.argmax(axis=0)
    newcomers = np.flatnonzero(first_row > 0)
    assert len(newcomers) > 0
    # They enter at an end of the corridor, not where the others started.
    entry_x = recording.positions[first_row[newcomers], newcomers, 0]
    assert np.abs(entry_x).min() > 11.0
    assert step.max() / recording.dt < 3.0  # nobody's history teleports


@pytest.mark.parametrize("seed", range(3))
def test_crowds_walk_at_a_human_pace_on_open_ground(seed):
    plan = Plan(scenarios=("mixed",), recordings=3, seconds=20.0, warmup=2.0, seed=seed)
    recording = plan.make(seed)
    assert 0.4 < recording.mean_speed < 1.8
    assert recording.map_image is not None


def test_a_crowd_of_nobody_is_refused():
    empty = make_scenario("circular_crossing", np.random.default_rng(0), pedestrians=0)
    with pytest.raises(ValueError, match="found no pedestrian"):
        record(empty, np.random.default_rng(0), name="empty", seconds=10.0)


def test_a_refused_call_writes_no_data_set(tmp_path):
    for wrong, message in (
        ({"scenarios": ["street"]}, "urban_crossing"),
        ({"hours": 0.0}, "at least one recording"),
        ({"seconds": 1.0}, "at least 8 s"),
        ({"workers": 0}, "workers"),
        ({"seed": -1}, "seed"),
        ({"model": "teleport"}, "social_force"),
        ({"model": {"orca": 0.5}}, "add up to 1"),
    ):
        with pytest.raises(ValueError, match=message):
            generate_dataset(tmp_path / "set", progress=False, **wrong)
    assert not (tmp_path / "set").exists()


def test_the_manifest_says_what_was_made(tmp_path):
    summary = generate_dataset(
        tmp_path,
        scenarios=["circular_crossing"],
        hours=20.0 / 3600.0,
        seconds=10.0,
        seed=3,
        progress=False,
    )
    metadata = json.loads((tmp_path / "manifest.json").read_text())["metadata"]
    assert metadata["plan"]["seed"] == 3
    assert metadata["summary"] == summary
    assert summary["recordings"] == len(list(iter_recordings(tmp_path))) == 2
    with pytest.raises(FileExistsError):
        generate_dataset(tmp_path, progress=False)


def test_people_move_by_the_model_that_is_asked_for():
    asked = {"scenarios": ("circular_crossing",), "recordings": 1, "seconds": 10.0, "warmup": 0.0}
    default, same, other = (
        Plan(**asked, seed=0, model=model).make(0).positions
        for model in (None, "social_force", {"orca": 1.0})
    )
    np.testing.assert_array_equal(default, same)
    np.testing.assert_array_equal(default[0], other[0])
    assert np.abs(default[-1] - other[-1]).max() > 0.5


def test_a_scenario_file_makes_a_data_set(tmp_path):
    file = tmp_path / "few.yaml"
    file.write_text("scenario: circular_crossing\nparameters: {pedestrians: 3}\n")
    few = {"scenarios": [str(file)], "hours": 10 / 3600, "seconds": 10.0, "progress": False}
    assert generate_dataset(tmp_path / "set", **few)["tracks"] == 3
    assert read_recordings(tmp_path / "set")[0].name == "few-00000"
    file.write_text("scenario: circular_crossing\nparameters: {pedestrians: 4}\n")
    with pytest.raises(ValueError, match=r"files was .*few\.yaml"):
        generate_dataset(tmp_path / "set", **few, resume=True)
