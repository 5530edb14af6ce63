"""Training: windows, augmentation, learnability, reproducibility."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from hand_made_crowds import walkers

from crowdsim.recordings import Recording, write_recordings
from predictor.augment import augmented_batch, recolor
from predictor.config import ModelConfig, TrainConfig, named_configuration
from predictor.datasets import read_training
from predictor.inputs import build_inputs
from predictor.model import IterativeAttention
from predictor.scenes import scenes
from predictor.train import TrainResult, chosen_device, fit, train
from predictor.windows import extract_windows

PATCH = ModelConfig(variant="patch")
SMALL = ModelConfig(latents=2, width=24, time_code=8, blocks=1, heads=2, crop_px=16)


def crowds(count: int, people: int = 4, frames: int = 24) -> list[Recording]:
    rng = np.random.default_rng(0)
    return [walkers(rng, people, frames, name=f"crowd_{i}") for i in range(count)]


def small_training(folder: Path, out: str, **changes: object) -> TrainResult:
    _, training = named_configuration("residual", epochs=1)
    return train(
        data=str(folder / "crowds"),
        out=folder / out,
        model=SMALL,
        training=replace(training, **changes),
        progress=False,
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("training")
    write_recordings(folder / "crowds", crowds(4), metadata={"seed": 7})
    return folder


def test_windows_are_what_serving_builds() -> None:
    recording = crowds(1)[0]
    windows = extract_windows([recording], PATCH)
    found, future = windows.batch(np.arange(len(windows)))
    served = [
        build_inputs(
            scene.history,
            scene.valid,
            scene.agents,
            recording.map_image,
            recording.pixel_from_world,
            PATCH,
        )
        for scene in scenes(recording, history_steps=8, forecast_steps=12)
    ]
    assert len(served) == 5
    for name in ("history", "history_valid", "neighbors", "neighbors_valid", "last_step", "crop"):
        expected = np.concatenate([getattr(inputs, name) for inputs in served])
        assert np.array_equal(getattr(found, name), expected), name
    assert future.shape == (20, 12, 2)


def test_mirrored_window_is_the_window_of_the_mirrored_world() -> None:
    windows = extract_windows(crowds(1), PATCH)
    rows = np.arange(len(windows))
    plain, future = windows.batch(rows)
    mirrored, mirrored_future = windows.batch(rows, np.tile([1.0, -1.0], (len(rows), 1)))
    assert np.array_equal(mirrored.history, plain.history * np.float32([1, -1]))
    assert np.array_equal(mirrored_future, future * np.float32([1, -1]))
    assert plain.crop is not None
    assert mirrored.crop is not None
    difference = mirrored.crop.astype(np.int64) - plain.crop[:, ::-1]
    assert np.abs(difference).mean() < 1.0
    assert np.abs(mirrored.crop.astype(np.int64) - plain.crop).mean() > 10.0


def test_scaled_window_shows_the_map_at_the_same_scale() -> None:
    """Twice as large in metres, the same crop shows half as much of the world."""
    windows = extract_windows(crowds(1), PATCH)
    rows = np.arange(4)
    doubled, _ = windows.batch(rows, np.full((4, 2), 2.0))
    half = replace(windows, config=replace(PATCH, crop_side=PATCH.crop_side / 2))
    assert np.array_equal(doubled.crop, half.batch(rows)[0].crop)


def test_truncated_scenes_hide_the_first_frames_only() -> None:
    windows = extract_windows(crowds(20), SMALL)
    training, rows = TrainConfig(truncate=1.0), np.arange(len(windows))
    inputs, _ = augmented_batch(windows, rows, training, np.random.default_rng(0))
    valid = inputs.history_valid
    assert not inputs.history[~valid].any()
    assert not inputs.neighbors[~inputs.neighbors_valid].any()
    assert valid[:, -1].all()
    assert not valid[:, 0].any()
    assert (np.diff(valid.astype(np.int64), axis=1) >= 0).all()
    assert set(valid.sum(axis=1)) == set(range(1, 8))


def test_random_turns_change_no_moving_window() -> None:
    windows = extract_windows(crowds(1), PATCH)
    rows = np.arange(len(windows))
    one = windows.batch(rows)
    two = windows.batch(rows, undirected=np.tile([0.6, -0.8], (len(rows), 1)))
    np.testing.assert_allclose(one[0].history, two[0].history, atol=1e-5)
    np.testing.assert_allclose(one[1], two[1], atol=1e-5)
    assert one[0].crop is not None
    assert two[0].crop is not None
    assert np.abs(one[0].crop.astype(np.int64) - two[0].crop).mean() < 1.0


def test_validation_recordings_are_never_trained_on(folder: Path) -> None:
    training, validation = read_training(str(folder / "crowds"))
    names = {r.name for r in training}, {r.name for r in validation}
    assert names[0] | names[1] == {f"crowd_{i}" for i in range(4)}
    assert len(names[1]) == 1
    assert not names[0] & names[1]
    again = read_training(str(folder / "crowds"))[1]
    assert {r.name for r in again} == names[1]


def test_a_single_recording_cannot_validate(tmp_path: Path) -> None:
    write_recordings(tmp_path, crowds(1))
    with pytest.raises(ValueError, match="at least 2 recordings, found 1"):
        read_training(str(tmp_path))


@pytest.mark.parametrize("name", ["residual", "fast"])
def test_overfits_64_windows(tmp_path: Path, name: str) -> None:
    rng = np.random.default_rng(0)
    model, training = named_configuration(name, epochs=1)
    config = replace(model, blocks=1, neighbors=1, dropout=0.0)
    windows = extract_windows([walkers(rng, 8, name=f"{i}", bend=0.06) for i in range(8)], config)
    again = np.tile(np.arange(64), 200)
    repeated = replace(windows, tracks=windows.tracks.take(again))
    training = replace(training, batch_size=64, learning_rate=3e-3, mirror=False, scale=0.0)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        network = IterativeAttention(config)
        found = fit(network, repeated, windows, training, out=tmp_path, about={}, progress=False)
    assert found.constant_velocity["ade"] > 0.3
    assert found.validation["ade"] < 0.05


def test_same_seed_gives_the_same_weights(folder: Path) -> None:
    first, second = (small_training(folder, name, seed=3) for name in ("first", "second"))
    other = small_training(folder, "other", seed=4)
    assert first.checkpoint.read_bytes() == second.checkpoint.read_bytes()
    assert first.checkpoint.read_bytes() != other.checkpoint.read_bytes()


def test_training_leaves_torchs_generator_alone(folder: Path) -> None:
    state = torch.get_rng_state()
    small_training(folder, "quiet")
    assert torch.equal(state, torch.get_rng_state())


def test_checkpoint_says_where_it_comes_from(folder: Path) -> None:
    result = small_training(folder, "described")
    about = json.loads(result.checkpoint.with_suffix(".json").read_text())
    assert about["data"]["source"] == str(folder / "crowds")
    assert about["data"]["made_by"] == {"seed": 7}
    assert about["data"]["train_windows"] == result.windows == 3 * 4 * 5
    assert about["metrics"]["validation"] == result.validation
    assert about["metrics"]["constant_velocity"] == result.constant_velocity
    assert about["training"]["schedule"] == "one_cycle"
    assert (folder / "described" / "last.safetensors").exists()


def test_a_loss_that_is_not_finite_stops(tmp_path: Path) -> None:
    windows = extract_windows(crowds(1), SMALL)
    nowhere = np.full_like(windows.tracks.future, np.nan)
    broken = replace(windows, tracks=replace(windows.tracks, future=nowhere))
    with pytest.raises(FloatingPointError, match="finite loss, found nan in epoch 1"):
        fit(
            IterativeAttention(SMALL),
            broken,
            windows,
            TrainConfig(epochs=1),
            out=tmp_path,
            about={},
            progress=False,
        )
    assert list(tmp_path.iterdir()) == []


def test_a_device_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    monkeypatch.setattr(torch.mps, "is_available", lambda: False)
    assert chosen_device("auto") == torch.device("cpu")
    with pytest.raises(ValueError, match="device cuda, found none"):
        chosen_device("cuda")
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    assert chosen_device("auto") == torch.device("cuda")


def test_recolored_map_keeps_its_shapes_and_its_edge() -> None:
    rng = np.random.default_rng(0)
    crop = np.zeros((20, 16, 16, 3), dtype=np.uint8)
    crop[:, :, 4:10], crop[:, :, 10:] = (200, 60, 30), (40, 180, 90)
    other = recolor(crop, rng)
    assert not other[:, :, :4].any()
    for side in (slice(4, 10), slice(10, 16)):
        assert (other[:, :, side] == other[:, :1, side.start : side.start + 1]).all()
        assert (other[:, 0, side.start].std(axis=0) > 20.0).all()


def test_hidden_maps_and_palettes_follow_the_configuration() -> None:
    windows = extract_windows(crowds(8), PATCH)
    rows = np.arange(len(windows))
    plain = windows.batch(rows)[0]
    kept = augmented_batch(windows, rows, TrainConfig(truncate=0.0), np.random.default_rng(0))[0]
    assert np.array_equal(kept.crop, plain.crop)
    assert kept.crop_valid.all()
    changing = TrainConfig(hide_map=0.25, recolor=0.5, truncate=0.0)
    changed = augmented_batch(windows, rows, changing, np.random.default_rng(0))[0]
    assert changed.crop is not None
    assert plain.crop is not None
    assert 0.15 < (~changed.crop_valid).mean() < 0.35
    assert 0.35 < (changed.crop != plain.crop).any(axis=(1, 2, 3)).mean() < 0.65
