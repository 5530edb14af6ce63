"""The benchmark on settings so small that its figures mean nothing, but their shape does."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import Crowdnav

from crowdsim.motion import MODEL_NAMES
from scripts.benchmarks import collection, crowd, crowd_peers, environment, exported, start, timing
from scripts.benchmarks.child import answer_of
from scripts.benchmarks.peers import INSTALL, PEERS, Peer, installed_version


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(timing, "AT_LEAST", 0.0)
    monkeypatch.setattr(timing, "REPEATS", 3)
    monkeypatch.setattr(crowd, "COUNTS", (4, 6))
    monkeypatch.setattr(crowd, "SETTLE_STEPS", 2)


def measured(crowdnav: Crowdnav, sections: str, folder: Path) -> dict[str, Any]:
    file = folder / "figures.json"
    assert crowdnav("benchmark", "--only", sections, "--json", file).status == 0
    found: dict[str, Any] = json.loads(file.read_text())
    assert found.pop("machine")["threads"] == 1
    return found


@pytest.mark.usefixtures("quick")
def test_crowd_has_a_row_for_every_model_size_and_geometry(
    crowdnav: Crowdnav, tmp_path: Path
) -> None:
    found = measured(crowdnav, "crowd", tmp_path)
    assert set(found) == {"crowd"}
    rows = {(row["model"], row["walls"], row["n"]): row for row in found["crowd"]}
    assert set(rows) == {(m, w, n) for m in MODEL_NAMES for w in (False, True) for n in (4, 6)}
    for (_, _, n), row in rows.items():
        assert row["pedestrian_steps_per_s"] == pytest.approx(n * row["steps_per_s"], rel=1e-3)


@pytest.mark.usefixtures("quick")
def test_every_peer_has_rows_or_says_how_to_install_it(crowdnav: Crowdnav, tmp_path: Path) -> None:
    found = measured(crowdnav, "crowd,crowd_peers", tmp_path)
    assert list(found) == ["crowd", "crowd_peers", "crowd_ratios"]
    present = [name for name in PEERS if installed_version(name) is not None]
    for name in PEERS:
        rows = [row for row in found["crowd_peers"] if row["peer"] == name]
        if name in present:
            assert {(row["walls"], row["n"]) for row in rows} == {
                (walls, n) for walls in (False, True) for n in (4, 6)
            }
        else:
            assert rows == [{"peer": name, "missing": INSTALL}]
    assert len(found["crowd_ratios"]) == (4 if present else 0)
    assert all(row["ratio"] > 0 for row in found["crowd_ratios"])
    assert len(found["crowd"]) == 4 * len(MODEL_NAMES)


@pytest.mark.usefixtures("quick")
def test_without_peers_the_crowd_is_still_measured(
    crowdnav: Crowdnav, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(crowd_peers, "installed_version", lambda name: None)
    found = measured(crowdnav, "crowd_peers", tmp_path)
    assert found["crowd_peers"] == [{"peer": name, "missing": INSTALL} for name in PEERS]
    assert found["crowd_ratios"] == []
    assert len(found["crowd"]) == 4 * len(MODEL_NAMES)


@pytest.fixture(params=PEERS)
def peer(request: pytest.FixtureRequest) -> Peer:
    package, kind = PEERS[request.param]
    pytest.importorskip(package)
    return kind(crowd.counterflow(12, True, "social_force", 0))


def test_a_peer_walks_back_and_forth_between_its_walls(peer: Peer) -> None:
    start_at, _ = peer.step()
    x_min, y_min, x_max, y_max = crowd.counterflow(12, True, "social_force", 0).map.bounds
    rows, furthest = start_at[:, 1] // crowd.ROW_HEIGHT, np.zeros(12)
    for _ in range(round(30.0 / peer.dt)):
        positions, velocities = peer.step()
        furthest = np.maximum(furthest, np.abs(positions[:, 0] - start_at[:, 0]))
        # The walls between rows keep everybody in the row of the start.
        assert np.array_equal(positions[:, 1] // crowd.ROW_HEIGHT, rows)
    assert ((positions > (x_min, y_min)) & (positions < (x_max, y_max))).all()
    assert furthest.mean() > 1.0
    assert 0.2 < np.linalg.norm(velocities, axis=1).mean() < 2.5


def test_a_peer_reads_back_velocities_of_its_own_steps(peer: Peer) -> None:
    before, _ = peer.step()
    after, velocities = peer.step()
    assert (after - before) / peer.dt == pytest.approx(velocities, abs=1e-3)


def test_a_crowd_that_stands_still_is_not_timed() -> None:
    class Frozen:
        dt = 0.05

        def step(self) -> tuple[np.ndarray, np.ndarray]:
            return np.zeros((3, 2)), np.ones((3, 2))

    with pytest.raises(RuntimeError, match=r"Frozen.*0\.00 m/s"):
        crowd_peers.mean_speed(Frozen())


def test_the_ratio_is_of_times_taken_together() -> None:
    ours = np.array([1.0, 8.0, 2.0])  # the machine was slow in the second round
    theirs = {"slow": 9.0 * ours, "fast": 3.0 * ours}
    (row,) = crowd_peers.ratios(10, True, ours, theirs)
    assert row == {"n": 10, "walls": True, "fastest_peer": "fast", "ratio": 3.0}


@pytest.mark.usefixtures("quick")
def test_works_are_timed_in_turn() -> None:
    calls: list[str] = []
    seconds = timing.seconds_in_turn([lambda: calls.append("a"), lambda: calls.append("b")])
    assert "".join(calls) == "aabb" + 3 * "ab"
    assert seconds.shape == (2, 3)


@pytest.mark.usefixtures("quick")
def test_pictures_name_what_was_drawn_of_whom(crowdnav: Crowdnav, tmp_path: Path) -> None:
    rows = measured(crowdnav, "pictures", tmp_path)["pictures"]
    assert {(row["what"], row["agents"]) for row in rows} >= {
        ("crops", 50),
        ("inputs", 200),
        ("render_frame", 50),
        ("render_map square", 0),
    }
    assert all(row["ms"] > 0 for row in rows)


def test_start_parts_the_time_of_a_first_step() -> None:
    seconds = start.start_once(0)
    assert list(seconds) == ["import_s", "world_s", "first_step_s"]
    assert min(seconds.values()) >= 0


def test_memory_is_that_of_a_process_of_its_own() -> None:
    (before,) = answer_of("scripts.benchmarks.memory", 1, 0).values()
    ballast = np.ones(2**27)  # 1 GiB in this process is none of the child's
    (mib,) = answer_of("scripts.benchmarks.memory", 1, 0).values()
    assert ballast.all()
    assert 50 < mib < 900
    assert mib == pytest.approx(before, rel=0.1)


def test_a_child_that_fails_says_why() -> None:
    with pytest.raises(RuntimeError, match="IndexError"):
        answer_of("scripts.benchmarks.memory")


@pytest.mark.usefixtures("quick")
def test_environment_has_a_row_for_every_forecaster_and_width(
    crowdnav: Crowdnav, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(environment, "ENVIRONMENTS", (1, 2))
    rows = measured(crowdnav, "environment", tmp_path)["environment"]
    known = environment.forecasters(tmp_path, 0)
    assert [(row["forecaster"], row["environments"]) for row in rows] == [
        (name, width) for name in known for width in (1, 2)
    ]
    assert all(row["steps_per_s"] > 0 for row in rows)


@pytest.mark.usefixtures("quick")
def test_collection_compares_every_way_with_the_vector(
    crowdnav: Crowdnav, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(collection, "ENVIRONMENTS", 2)
    rows = measured(crowdnav, "collection", tmp_path)["collection"]
    assert [row["way"] for row in rows] == ["vector", "adapter", "PPO", "PPO alone"]
    assert rows[0]["ratio"] == 1.0
    assert all(row["ratio"] > 0 for row in rows)


@pytest.mark.usefixtures("quick")
def test_exported_networks_are_timed_beside_torch(
    crowdnav: Crowdnav, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("onnxscript")
    pytest.importorskip("onnxruntime")
    monkeypatch.setattr(exported, "NETWORKS", (("fast", "none"),))
    monkeypatch.setattr(exported, "AGENTS", (1, 3))
    rows = measured(crowdnav, "exported", tmp_path)["exported"]
    assert [(row["configuration"], row["agents"]) for row in rows] == [("fast", 1), ("fast", 3)]
    assert all(row["ratio"] > 0 for row in rows)
