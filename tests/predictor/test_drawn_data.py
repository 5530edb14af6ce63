"""Real crowds on drawn maps: the same people, and a ground that simulated maps could show."""

from pathlib import Path

import numpy as np
import pytest
from hand_made_crowds import walkers

from crowdsim.recordings import Picture, sdd_mask, sdd_picture, write_recordings
from crowdsim.recordings.drawn import drawn_picture
from crowdsim.recordings.surfaces import Surface
from predictor.config import ModelConfig
from predictor.datasets import read_tests, read_training, unit_of, usual_min_ped
from predictor.window_cache import cached_windows


def colors(picture: Picture) -> set[tuple[int, ...]]:
    packed = np.unique(picture.image.astype(np.uint32) @ np.array([65536, 256, 1], np.uint32))
    return {(c >> 16, c >> 8 & 255, c & 255) for c in packed.tolist()}


def test_drawn_maps_show_where_people_can_walk(data_root: Path) -> None:
    photographed, drawn = (
        read_tests(f"{data_root / 'eth_ucy'}:hotel{ending}")["hotel"][0]
        for ending in ("", "@drawn")
    )
    assert np.array_equal(photographed.positions, drawn.positions)
    assert photographed.picture is not None
    assert drawn.picture is not None
    assert colors(drawn.picture) == {Surface.PAVEMENT.color_rgb, Surface.BUILDING.color_rgb}
    assert drawn.picture.image.shape == photographed.picture.image.shape
    assert np.array_equal(drawn.picture.pixel_from_world, photographed.picture.pixel_from_world)


def test_drone_pictures_are_drawn_by_their_classes(data_root: Path) -> None:
    photograph, classes = (read(data_root, "quad_0") for read in (sdd_picture, sdd_mask))
    found = colors(drawn_picture(photograph, classes))
    assert found == {Surface(c).color_rgb for c in np.unique(classes).tolist()}
    assert len(found) >= 3


def test_a_place_without_a_picture_stays_without(data_root: Path) -> None:
    training, _ = read_training(f"{data_root / 'eth_ucy'}:zara1@drawn")
    unseen = [recording.name for recording in training if recording.picture is None]
    assert unseen == ["uni_examples_train"]


def test_the_ground_changes_no_window(data_root: Path, tmp_path: Path) -> None:
    config = ModelConfig(variant="patch")
    for ending in ("", "@drawn"):
        _, validation = read_training(f"{data_root / 'eth_ucy'}:univ{ending}")
        cached_windows(tmp_path, validation, config)
    assert len(list(tmp_path.iterdir())) == 1


def test_protocol_of_the_data_is_that_of_the_drawn_data(data_root: Path) -> None:
    assert (unit_of("sdd@drawn"), usual_min_ped("sdd@drawn")) == ("px", 0)
    assert (unit_of("eth_ucy:eth@drawn"), usual_min_ped("eth_ucy:eth@drawn")) == ("m", 1)


def test_simulated_maps_are_drawn_already(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    write_recordings(tmp_path / "crowds", [walkers(rng, name=f"{i}") for i in range(2)])
    with pytest.raises(ValueError, match="expected real data before @drawn"):
        read_training(f"{tmp_path / 'crowds'}@drawn")


def test_classes_that_are_no_surface_are_refused() -> None:
    picture = walkers(np.random.default_rng(0)).picture
    assert picture is not None
    with pytest.raises(ValueError, match=r"surfaces 1 to 7, got \[0\]"):
        drawn_picture(picture, np.zeros(picture.image.shape[:2], dtype=np.uint8))
    with pytest.raises(ValueError, match=r"\(100, 100\) like the picture, got \(2, 2\)"):
        drawn_picture(picture, np.ones((2, 2), dtype=np.uint8))
