"""What a format is given comes back from it, and files that are something else are refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crowdsim.recordings import (
    Recording,
    find_data,
    format_of_input,
    format_of_output,
    iter_format,
    iter_sdd_snippets,
    join,
    read_eth_ucy,
    read_obsmat,
    read_scene,
    read_sdd_boxes,
    tally,
    write_format,
    write_obsmat,
)

FRAME_STEPS = {"eth_ucy": (1, 6, 10, 12), "obsmat": (6, 10), "trajnet": (1, 6, 10), "sdd": (12,)}
FILES = {"eth_ucy": "crowd.txt", "obsmat": "obsmat.txt", "trajnet": "crowd.ndjson", "sdd": "c.csv"}
RESOLUTION = {"eth_ucy": 5e-4, "obsmat": 5e-6, "trajnet": 5e-4, "sdd": 5e-4 * 0.04}


@st.composite
def crowds(draw: st.DrawFn, frame_step: int) -> Recording:
    """People who walk somewhere at 0.5-2 m/s, come late and leave early."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    people, steps = draw(st.integers(1, 6)), draw(st.integers(2, 30))
    direction = rng.uniform(-np.pi, np.pi, people)
    velocity = np.column_stack([np.cos(direction), np.sin(direction)])
    velocity *= rng.uniform(0.5, 2.0, (people, 1))
    positions = rng.uniform(-50.0, 50.0, (people, 2)) + np.multiply.outer(
        0.4 * np.arange(steps), velocity
    )
    first = rng.integers(0, steps - 1, people)
    last = rng.integers(first + 1, steps)
    row = np.arange(steps)[:, None]
    valid = (first <= row) & (row <= last)
    return Recording(
        name="crowd",
        positions=np.where(valid[..., None], positions, 0.0),
        valid=valid,
        ids=np.sort(rng.choice(10**6, people, replace=False)),
        frames=frame_step * np.arange(steps) + int(rng.integers(0, 1000)) * frame_step,
    )


@pytest.mark.parametrize("ending", ["", ".gz"])
@pytest.mark.parametrize("form", FRAME_STEPS)
@settings(max_examples=12, deadline=None)
@given(data=st.data())
def test_formats_give_back_what_they_were_given(tmp_path_factory, form, ending, data):
    original = data.draw(crowds(data.draw(st.sampled_from(FRAME_STEPS[form]))))
    path = tmp_path_factory.mktemp("crowd") / (FILES[form] + ending)
    write_format(path, form, [original], metres_per_px=0.04)
    assert format_of_input(path) == form
    found = join(iter_format(path, form, metres_per_px=0.04))
    seen = original.valid.any(axis=1)
    assert found.dt == 0.4
    np.testing.assert_array_equal(found.frames, original.frames[seen])
    np.testing.assert_array_equal(found.ids, original.ids)
    np.testing.assert_array_equal(found.valid, original.valid[seen])
    assert np.abs(found.positions - original.positions[seen]).max() <= RESOLUTION[form] + 1e-9


@pytest.mark.parametrize(
    ("file", "form"),
    [
        ("eth_ucy/splits/all/students003.txt", "eth_ucy"),
        ("eth_ucy/scenes/biwi_hotel/obsmat.txt.gz", "obsmat"),
        ("sdd/standard_test.csv.gz", "sdd"),
        ("sdd/full_tracks_2p5hz/nexus_3.csv.gz", "sdd"),
    ],
)
def test_real_files_are_told_by_their_contents(data_root, file, form):
    assert format_of_input(data_root / file) == form
    part = next(iter(iter_format(data_root / file, form)))
    assert (part.dt, len(part.ids) > 10) == (0.4, True)


def test_a_summary_says_what_was_read(data_root):
    text = str(tally(read_scene(data_root, "crowds_zara01")))
    assert text == (
        "crowds_zara01: 148 people, 5153 positions in 872 rows of 0.4 s (10 frames), "
        "mean speed 1.07 m/s, x -0.1 to 15.5 m, y -0.4 to 12.4 m"
    )
    assert "(faster than people walk)" in str(tally(read_scene(data_root, "biwi_eth")))


def test_written_velocities_are_those_of_the_annotation(data_root, tmp_path):
    path = find_data(data_root) / "scenes" / "biwi_eth" / "obsmat.txt.gz"
    write_obsmat(tmp_path / "obsmat.txt", [read_obsmat(path)])
    expected, found = np.loadtxt(path), np.loadtxt(tmp_path / "obsmat.txt")
    expected = expected[np.lexsort((expected[:, 1], expected[:, 0]))]
    np.testing.assert_array_equal(found[:, :2], expected[:, :2])
    assert np.quantile(np.abs(found[:, [5, 7]] - expected[:, [5, 7]]), 0.99) < 1e-4


def test_names_tell_the_format_to_write(tmp_path):
    names = ("set", "a.txt", "a.txt.gz", "obsmat.txt", "a.ndjson", "a.csv.gz")
    forms = ["dataset", "eth_ucy", "eth_ucy", "obsmat", "trajnet", "sdd"]
    assert [format_of_output(tmp_path / name) for name in names] == forms
    with pytest.raises(ValueError, match=r"\.txt, \.ndjson, \.csv"):
        format_of_output(tmp_path / "a.mat")


BOXES = "track,frame,xmin,ymin,xmax,ymax,lost,occluded,generated,label\n"


def test_boxes_become_the_centres_of_pedestrians_every_twelfth_frame(tmp_path):
    path = tmp_path / "annotations.txt"
    rows = [f"3 {x} 10 {x + 10} 30 {x} 0 1 1" for x in range(25)]
    rows += [f"4 {x} 10 {x + 10} 30 {x} 1 0 0" for x in range(25)]
    labels = ['"Pedestrian"'] * 50
    rows += ["5 0 0 4 4 12 0 0 0"]
    labels += ['"Biker"']
    path.write_text("".join(f"{row} {label}\n" for row, label in zip(rows, labels, strict=True)))
    recording = read_sdd_boxes(path, 0.04)
    np.testing.assert_array_equal(recording.frames, [0, 12, 24])
    np.testing.assert_array_equal(recording.ids, [3])
    np.testing.assert_allclose(recording.positions[:, 0], [[0.2, -0.8], [0.68, -0.8], [1.16, -0.8]])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("video,frame,track,x_px\n", "line 1: expected 'video,frame,track,x_px,y_px'"),
        ("video,frame,track,x_px,y_px\na,0,1,2\n", "line 2: expected 5 columns"),
        ("video,frame,track,x_px,y_px\na,0,1,2,inf\n", "line 2: .*inf"),
        ("video,frame,track,x_px,y_px\na,0,1,2,3\n", "a: expected two frames"),
        ("video,frame,track,x_px,y_px\nb,0,1,2,3\n", "metres per pixel of video 'b'"),
        (
            "video,frame,track,x_px,y_px\na,0,1,0,0\na,6,1,5,0\n",
            r"crowd\.csv, a: frames 6 apart imply a time step of 0\.2 s \(at 30 fps\)",
        ),
    ],
)
def test_snippets_that_are_something_else_are_refused(tmp_path, content, message):
    path = tmp_path / "crowd.csv"
    path.write_text(content)
    with pytest.raises(ValueError, match=message):
        list(iter_sdd_snippets(path, {"a": 0.04}))


def test_a_video_in_two_places_is_refused(tmp_path):
    path = tmp_path / "crowd.csv"
    walk = "{0},0,1,0,0\n{0},12,1,9,0\n"
    text = "video,frame,track,x_px,y_px\n" + "".join(walk.format(video) for video in "aba")
    path.write_text(text)
    with pytest.raises(ValueError, match="rows of video 'a' in one place"):
        list(iter_sdd_snippets(path, 0.04))


def test_boxes_without_anybody_are_refused(tmp_path):
    path = tmp_path / "crowd.csv"
    path.write_text(BOXES + "1,0,0,0,1,1,1,0,0,Pedestrian\n")
    with pytest.raises(ValueError, match=r"crowd\.csv.*at least one row"):
        read_sdd_boxes(path, 0.04)


@pytest.mark.parametrize("form", FRAME_STEPS)
@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_damage_is_refused_with_the_name_of_the_file(tmp_path_factory, form, data):
    folder = tmp_path_factory.mktemp("crowd")
    path = folder / FILES[form]
    write_format(path, form, [data.draw(crowds(FRAME_STEPS[form][-1]))], metres_per_px=0.04)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.integers(0, len(content) - 1))
        content[place : place + data.draw(st.integers(0, 30))] = data.draw(st.binary(max_size=4))
    path.write_bytes(content)
    refusal = path.name
    try:
        list(iter_format(path, form, metres_per_px=0.04))
    except ValueError as error:
        refusal = str(error)
    assert path.name in refusal


def test_a_damaged_gzip_file_is_named(tmp_path):
    path = tmp_path / "crowd.txt.gz"
    for content in (b"0 1 0.0 0.0\n", b"\x1f\x8b\x08\x00"):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r"crowd\.txt\.gz: damaged gzip"):
            read_eth_ucy(path)


def test_a_stated_time_step_wins_over_the_frame_numbers(tmp_path):
    path = tmp_path / "crowd.txt"
    path.write_text("".join(f"{7 * i} 1 {0.3 * i} 0.0\n" for i in range(9)))
    with pytest.raises(ValueError, match="frames 7 apart"):
        read_eth_ucy(path)
    recording = read_eth_ucy(path, dt=0.28)
    assert recording.dt == 0.28
    assert recording.mean_speed == pytest.approx(0.3 / 0.28)


def test_files_of_one_recording_do_not_take_two(tmp_path, data_root):
    crowd = read_scene(data_root, "crowds_zara01")
    other = read_scene(data_root, "crowds_zara02")
    with pytest.raises(ValueError, match="'crowds_zara01' and 'crowds_zara02'; name a folder"):
        write_format(tmp_path / "both.txt", "eth_ucy", [crowd, other])
    assert list(tmp_path.iterdir()) == []
    write_format(tmp_path / "both", "eth_ucy", [crowd, other])
    found = read_eth_ucy(tmp_path / "both" / "crowds_zara02.txt")
    np.testing.assert_array_equal(found.valid, other.valid)
