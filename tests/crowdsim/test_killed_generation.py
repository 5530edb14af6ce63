"""Data sets whose making was stopped, killed, damaged or asked for otherwise."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from crowdsim.generate import generate_dataset
from crowdsim.unfinished import PLAN

ROOT = Path(__file__).parents[2]
SHARDS = 16  # enough that they are not all there before anybody can interrupt
OPTIONS = {
    "scenarios": ["circular_crossing", "parallel_traffic"],
    "hours": SHARDS * 8 * 20.0 / 3600.0,
    "seconds": 20.0,
    "seed": 5,
    "progress": False,
}
COMMAND = ["generate", "--scenario", "circular_crossing,parallel_traffic", "--seconds", "20"]
COMMAND += ["--hours", str(OPTIONS["hours"]), "--seed", "5", "--workers", "2", "--resume"]


def files(folder: Path) -> dict[str, bytes]:
    """All but the command's own options, which tell how often it was run."""
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.name != "config.yaml"}


def start(folder: Path) -> subprocess.Popen[str]:
    """The command in a process group of its own, as a terminal would run it."""
    return subprocess.Popen(
        [sys.executable, "-m", "scripts", *COMMAND, "--out", str(folder)],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # A shell's background jobs ignore interrupts, and so would all that they start.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


def wait_for_shards(process: subprocess.Popen[str], folder: Path, count: int) -> None:
    while len(list(folder.glob("tracks-*.json"))) < count:
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.002)


def is_running(group: int) -> bool:
    """Whether a process of the group is left that is no zombie."""
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, of = stat.read_text().rpartition(")")[2].split()[:3]
        except OSError:
            continue
        if int(of) == group and state != "Z":
            return True
    return False


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """The data set as it comes out when nothing happens."""
    folder = tmp_path_factory.mktemp("whole")
    generate_dataset(folder, **OPTIONS)
    return folder


def test_killed_and_interrupted_and_resumed_makes_the_same_bytes(whole, tmp_path):
    killed = start(tmp_path)
    wait_for_shards(killed, tmp_path, 1)
    killed.kill()  # the parent alone: its workers have to notice
    killed.communicate()
    deadline = time.monotonic() + 10.0
    while is_running(killed.pid):
        assert time.monotonic() < deadline, "workers outlived their parent"
        time.sleep(0.01)
    assert not (tmp_path / "manifest.json").exists()

    interrupted = start(tmp_path)
    wait_for_shards(interrupted, tmp_path, len(list(tmp_path.glob("tracks-*.json"))) + 1)
    os.killpg(interrupted.pid, signal.SIGINT)
    before = time.monotonic()
    message = interrupted.communicate(timeout=20)[1].splitlines()[-1]
    assert time.monotonic() - before < 3.0
    assert interrupted.returncode == 130
    assert message.startswith("crowdnav: stopped: ")
    assert "--resume" in message
    assert not (tmp_path / "manifest.json").exists()

    generate_dataset(tmp_path, **OPTIONS, resume=True)
    assert files(tmp_path) == files(whole)


def unfinish(whole: Path, folder: Path, shards: int) -> None:
    """Leave what a run that was killed after some shards leaves."""
    manifest = json.loads((whole / "manifest.json").read_text())
    for path in whole.glob("map-*.png"):
        (folder / path.name).write_bytes(path.read_bytes())
    for entry in manifest["shards"][:shards]:
        (folder / entry["file"]).write_bytes((whole / entry["file"]).read_bytes())
        (folder / entry["file"]).with_suffix(".json").write_text(json.dumps(entry))
    (folder / PLAN).write_text(json.dumps(manifest["metadata"]["plan"]))


def inodes(folder: Path) -> dict[str, int]:
    """They change when a file is written anew."""
    return {path.name: path.stat().st_ino for path in folder.glob("tracks-*.parquet")}


def test_what_stands_is_kept_and_what_is_damaged_made_again(whole, tmp_path):
    unfinish(whole, tmp_path, 5)
    (tmp_path / "tracks-00001.parquet").write_bytes(b"torn")
    (tmp_path / "tracks-00002.json").write_text('{"file": "tra')
    (tmp_path / ".tracks-00006.parquet.41.part").write_bytes(b"half")
    before = inodes(tmp_path)
    generate_dataset(tmp_path, **OPTIONS, resume=True)
    assert files(tmp_path) == files(whole)
    after = inodes(tmp_path)
    kept = {name for name in before if after[name] == before[name]}
    assert kept == {f"tracks-0000{shard}.parquet" for shard in (0, 3, 4)}


def test_a_lost_map_comes_back(whole, tmp_path):
    unfinish(whole, tmp_path, SHARDS)
    next(tmp_path.glob("map-*.png")).unlink()
    generate_dataset(tmp_path, **OPTIONS, resume=True)
    assert files(tmp_path) == files(whole)


def test_a_complete_data_set_is_checked_and_left_as_it_is(whole, tmp_path):
    for name, content in files(whole).items():
        (tmp_path / name).write_bytes(content)
    before = inodes(tmp_path)
    generate_dataset(tmp_path, **OPTIONS, resume=True)
    assert inodes(tmp_path) == before
    assert files(tmp_path) == files(whole)


@pytest.mark.parametrize("shards", [3, SHARDS])
def test_another_plan_is_refused_and_said_what_differs(whole, tmp_path, shards):
    if shards == SHARDS:
        (tmp_path / "manifest.json").write_bytes((whole / "manifest.json").read_bytes())
    else:
        unfinish(whole, tmp_path, shards)
    before = files(tmp_path)
    with pytest.raises(ValueError, match=r"seed was 5, asked for is 6; model was null.*orca"):
        generate_dataset(tmp_path, **{**OPTIONS, "seed": 6}, model="orca", resume=True)
    assert files(tmp_path) == before


def test_what_was_begun_is_not_overwritten_unasked(whole, tmp_path):
    unfinish(whole, tmp_path, 1)
    with pytest.raises(FileExistsError, match="--resume"):
        generate_dataset(tmp_path, **OPTIONS)
