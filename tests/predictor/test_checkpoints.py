"""Checkpoints come back as they were, or not at all."""

import hashlib
import json
from pathlib import Path

import pytest
import torch
from hand_made_crowds import network

from predictor.checkpoint import load_checkpoint, save_checkpoint
from predictor.config import Variant
from predictor.forecaster import make_forecaster


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    path = tmp_path / "best.safetensors"
    save_checkpoint(path, network("none"), {"metrics": {"ade": 0.5}})
    return path


def edit_description(path: Path, **changes: object) -> None:
    beside = path.with_suffix(".json")
    beside.write_text(json.dumps({**json.loads(beside.read_text()), **changes}))


def test_round_trip(tmp_path: Path, variant: Variant) -> None:
    model = network(variant)
    save_checkpoint(tmp_path / "best.safetensors", model, {"metrics": {"ade": 0.5}})
    state = torch.get_rng_state()
    loaded, about = load_checkpoint(tmp_path)
    assert torch.equal(state, torch.get_rng_state())
    assert about["metrics"] == {"ade": 0.5}
    assert loaded.config == model.config
    for name, tensor in model.state_dict().items():
        assert torch.equal(tensor, loaded.state_dict()[name])
    assert [p.name for p in tmp_path.iterdir() if p.name.startswith(".")] == []


@pytest.mark.parametrize("position", [40, -5])
def test_a_flipped_bit_is_refused(saved: Path, position: int) -> None:
    content = bytearray(saved.read_bytes())
    content[position] ^= 1
    saved.write_bytes(content)
    with pytest.raises(ValueError, match="damaged, expected SHA-256"):
        load_checkpoint(saved)


def test_a_torn_description_is_refused(saved: Path) -> None:
    beside = saved.with_suffix(".json")
    beside.write_text(beside.read_text()[:100])
    with pytest.raises(ValueError, match="expected JSON"):
        load_checkpoint(saved)


def test_weights_that_do_not_fit_the_config_are_refused(saved: Path) -> None:
    config = json.loads(saved.with_suffix(".json").read_text())["config"]
    edit_description(saved, config={**config, "latents": 6})
    with pytest.raises(ValueError, match="must be"):
        load_checkpoint(saved)
    edit_description(saved, config={**config, "variant": "patch"})
    with pytest.raises(ValueError, match="differ in"):
        load_checkpoint(saved)


def test_nan_weights_are_refused(tmp_path: Path) -> None:
    model = network("none")
    with torch.no_grad():
        model.latents[0, 0] = torch.nan
    save_checkpoint(tmp_path / "best.safetensors", model, {})
    with pytest.raises(ValueError, match="latents must be finite"):
        load_checkpoint(tmp_path)


def test_not_safetensors_is_refused(saved: Path) -> None:
    saved.write_bytes(b"not weights")
    edit_description(saved, sha256=hashlib.sha256(b"not weights").hexdigest())
    with pytest.raises(ValueError, match="safetensors"):
        load_checkpoint(saved)


def test_make_forecaster_takes_a_folder_or_a_file(saved: Path) -> None:
    for spec in (saved, saved.parent):
        forecaster = make_forecaster(str(spec), horizon=9.6)
        assert forecaster is not None
        assert forecaster.forecast_steps == 24
    saved.with_suffix(".json").unlink()
    with pytest.raises(FileNotFoundError):
        make_forecaster(str(saved))
