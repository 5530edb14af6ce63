"""The Stanford Drone Dataset gives the check values of the data's README."""

import numpy as np
import pytest

from crowdsim.recordings import (
    Recording,
    find_sdd,
    read_sdd,
    sdd_mask,
    sdd_part,
    sdd_picture,
    sdd_scales,
    sdd_walkable,
)
from crowdsim.recordings.sdd import WALKABLE_CLASSES
from crowdsim.recordings.surfaces import Surface


def snippets(recordings: list[Recording]) -> tuple[np.ndarray, np.ndarray]:
    """(S, 20, 2) tracks of the agents of all windows [m], and (S,) metres per pixel."""
    tracks, scales = [], []
    for recording in recordings:
        for row in recording.windows():
            present = recording.valid[row : row + 20].all(axis=0)
            tracks.append(recording.positions[row : row + 20][:, present].transpose(1, 0, 2))
            scales.append(np.full(present.sum(), 1.0 / recording.pixel_from_world[0, 0]))
    return np.concatenate(tracks), np.concatenate(scales)


def constant_velocity_errors(tracks: np.ndarray) -> np.ndarray:
    """(S, 12) distances after 8 observed points."""
    step = tracks[:, 7] - tracks[:, 6]
    forecast = tracks[:, 7, None] + np.arange(1, 13)[:, None] * step[:, None]
    return np.linalg.norm(forecast - tracks[:, 8:], axis=-1)


@pytest.mark.parametrize(
    ("part", "count", "videos", "ade_px", "fde_px"),
    [("test", 2829, 17, 19.74, 40.05), ("train", 8494, 30, 19.59, 39.62)],
)
def test_standard_parts_match_the_check_values(data_root, part, count, videos, ade_px, fde_px):
    recordings = sdd_part(data_root, part)
    tracks, scale = snippets(recordings)
    error = constant_velocity_errors(tracks)
    error_px = error / scale[:, None]
    assert (len(recordings), len(tracks)) == (videos, count)
    assert error_px.mean() == pytest.approx(ade_px, abs=5e-3)
    assert error_px[:, -1].mean() == pytest.approx(fde_px, abs=5e-3)
    if part == "test":
        assert error.mean() == pytest.approx(0.673, abs=5e-4)
        assert error[:, -1].mean() == pytest.approx(1.362, abs=5e-4)
        assert np.median(error_px[:, -1]) == pytest.approx(24.3, abs=0.05)


def test_whole_tracks_hold_the_snippets_of_the_standard_split(data_root):
    whole = read_sdd(data_root, "gates_2")
    (part,) = [part for part in sdd_part(data_root, "test") if part.name == "gates_2"]
    seen = {
        (int(frame), *np.round(position, 6))
        for frame, row in zip(whole.frames, whole.positions, strict=True)
        for position in row
    }
    row, person = np.nonzero(part.valid)
    found = [
        (int(part.frames[r]), *np.round(part.positions[r, p], 6)) in seen
        for r, p in zip(row, person, strict=True)
    ]
    assert np.mean(found) > 0.9


def test_people_of_the_split_walk_where_the_mask_says(data_root):
    on_walkable, points = 0, 0
    for recording in sdd_part(data_root, "test"):
        mask = sdd_walkable(data_root, recording.name)
        world = recording.positions[recording.valid]
        u, v = np.rint(world @ recording.pixel_from_world[:2, :2]).astype(int).T
        inside = (u >= 0) & (v >= 0) & (u < mask.shape[1]) & (v < mask.shape[0])
        assert inside.mean() > 0.99
        assert mask.shape == recording.map_image.shape[:2]
        on_walkable += mask[v[inside], u[inside]].sum()
        points += inside.sum()
    assert 0.8 < on_walkable / points < 0.95


def test_walkable_classes_are_those_of_the_surfaces():
    assert [c for c in range(1, 6) if Surface(c).walkable] == list(WALKABLE_CLASSES)


def test_what_a_video_lacks_is_said(data_root):
    assert len(sdd_scales(data_root)) == 54
    with pytest.raises(ValueError, match="metres per pixel of video 'hyang_13'"):
        sdd_picture(data_root, "hyang_13")
    with pytest.raises(ValueError, match="metres per pixel of video 'hyang_13'"):
        read_sdd(data_root, "hyang_13")
    with pytest.raises(FileNotFoundError, match=r"masks/hyang_12\.png"):
        sdd_mask(data_root, "hyang_12")
    with pytest.raises(FileNotFoundError, match="bookstore_0"):
        read_sdd(data_root, "bookstore_0")
    with pytest.raises(ValueError, match="train, test"):
        sdd_part(data_root, "val")


def test_missing_data_says_where_it_was_looked_for(tmp_path, monkeypatch):
    monkeypatch.setenv("CROWDNAV_DATA", str(tmp_path))
    with pytest.raises(FileNotFoundError, match=str(tmp_path)):
        find_sdd()
