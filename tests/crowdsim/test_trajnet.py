"""TrajNet++ files: what we write the official tools read, and the other way round."""

import json

import numpy as np
import pytest

from crowdsim.recordings import (
    Recording,
    TrajnetScene,
    iter_trajnet,
    read_scene,
    read_trajnet,
    write_trajnet,
)

trajnetplusplustools = pytest.importorskip("trajnetplusplustools", reason="in the extra `test`")
SceneRow, TrackRow = trajnetplusplustools.SceneRow, trajnetplusplustools.TrackRow


def tracks(recording: Recording) -> set[tuple[int, int, float, float]]:
    frame, person, position = recording.to_rows()
    rows = zip(frame.tolist(), person.tolist(), position.tolist(), strict=True)
    return {(f, p, round(x, 3), round(y, 3)) for f, p, (x, y) in rows}


def test_the_official_reader_finds_every_primary_and_its_neighbors(data_root, tmp_path):
    recording = read_scene(data_root, "crowds_zara01")
    write_trajnet(tmp_path / "zara.ndjson", [recording])
    reader = trajnetplusplustools.Reader(str(tmp_path / "zara.ndjson"), scene_type="paths")
    assert {row for rows in reader.tracks_by_frame.values() for row in rows} == {
        TrackRow(*row) for row in tracks(recording)
    }
    scenes = list(reader.scenes())
    # Whoever is there for n rows on end is the primary of n // 21 scenes.
    assert len(scenes) == sum(int(n) // 21 for n in recording.valid.sum(axis=0))
    for number, (primary, *_neighbors) in scenes:
        scene = reader.scenes_by_id[number]
        column = np.searchsorted(recording.ids, scene.pedestrian)
        start = np.searchsorted(recording.frames, scene.start)
        expected = recording.positions[start : start + 21, column]
        found = np.array([(row.x, row.y) for row in primary])
        np.testing.assert_allclose(found, expected, atol=5.1e-4)
        assert (scene.fps, scene.tag) == (2.5, [0, []])


def test_a_file_of_the_official_writer_is_read(tmp_path):
    rows = [TrackRow(6 * i, p, round(0.5 * i, 2), float(p)) for i in range(21) for p in (3, 8)]
    scenes = [SceneRow(0, 8, 0, 120, 2.5, [3, [1, 2]]), SceneRow(1, 3, 0, 120, 2.5, 2)]
    write = trajnetplusplustools.writers.trajnet
    path = tmp_path / "crowd.ndjson"
    path.write_text("".join(write(row) + "\n" for row in [*rows, *scenes]))
    recording, found = read_trajnet(path)
    assert tracks(recording) == {(row.frame, row.pedestrian, row.x, row.y) for row in rows}
    assert (recording.name, recording.dt, recording.frame_step) == ("crowd", 0.4, 6)
    assert found == (
        TrajnetScene(number=0, primary=8, start=0, end=120, fps=2.5, tag=3, subtags=(1, 2)),
        TrajnetScene(number=1, primary=3, start=0, end=120, fps=2.5, tag=2),
    )


def test_recording_and_scenes_come_back(data_root, tmp_path):
    recording = read_scene(data_root, "biwi_hotel")
    scenes = (
        TrajnetScene(number=4, primary=12, start=100, end=300, fps=2.5, tag=3, subtags=(3,)),
        TrajnetScene(number=9, primary=15, start=200, end=400, fps=2.5, tag=1),
    )
    path = tmp_path / "biwi_hotel.ndjson.gz"
    write_trajnet(path, [recording], scenes)
    found = read_trajnet(path)
    assert (found.scenes, found.recording.name) == (scenes, "biwi_hotel")
    assert tracks(found.recording) == tracks(recording)


def test_rows_per_second_of_the_scenes_are_the_time_step(tmp_path):
    path = tmp_path / "crowd.ndjson"
    scene = {"scene": {"id": 0, "p": 1, "s": 0, "e": 140, "fps": 4.0}}
    rows = [{"track": {"f": 7 * i, "p": 1, "x": 0.3 * i, "y": 0.0}} for i in range(21)]
    path.write_text("\n".join(json.dumps(line) for line in [*rows, scene]))
    assert read_trajnet(path).recording.dt == 0.25
    path.write_text("\n".join(json.dumps(line) for line in rows))
    with pytest.raises(ValueError, match="frames 7 apart imply"):
        read_trajnet(path)


TRACK = '{"track": {"f": 0, "p": 1, "x": 0.0, "y": 0.0}}\n'


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("{", "line 2: expected .*scene.*found '{'"),
        ("[1]", r"line 2: expected .*found '\[1\]'"),
        ('{"tracks": {}}', "line 2: expected"),
        ('{"track": {"f": 10, "p": 1, "x": 0.4}}', "line 2: expected a number 'y', found None"),
        ('{"track": {"f": 10, "p": 1, "x": NaN, "y": 0}}', "line 2: expected a number 'x'"),
        ('{"track": {"f": 1.5, "p": 1, "x": 0, "y": 0}}', "line 2: expected a whole number 'f'"),
        ('{"track": {"f": 1, "p": 1, "x": 0, "y": 0, "prediction_number": 0}}', "a prediction"),
        ('{"track": {"f": 1e99, "p": 1, "x": 0, "y": 0}}', "line 2: expected a whole number 'f'"),
        ('{"scene": {"id": 0, "p": 1, "s": 0, "e": 9, "tag": "x"}}', "line 2: expected a tag"),
        ('{"scene": {"id": 0, "p": 1, "s": 0, "e": 9, "fps": 0}}', "line 2: expected a positive"),
    ],
)
def test_lines_that_are_something_else_are_named(tmp_path, line, message):
    path = tmp_path / "crowd.ndjson"
    path.write_text(TRACK + line + "\n")
    with pytest.raises(ValueError, match=message):
        list(iter_trajnet(path))


def test_scenes_of_two_rates_are_refused(tmp_path):
    path = tmp_path / "crowd.ndjson"
    scenes = [{"scene": {"id": i, "p": 1, "s": 0, "e": 9, "fps": 2.5 + i}} for i in range(2)]
    path.write_text(TRACK + "\n".join(json.dumps(scene) for scene in scenes))
    with pytest.raises(ValueError, match="scenes of one rate"):
        read_trajnet(path)
