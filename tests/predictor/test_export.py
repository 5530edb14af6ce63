"""Exported networks: the same forecasts from other programs."""

import json
import sys
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
import torch
from hand_made_crowds import walkers

from predictor.checkpoint import load_checkpoint
from predictor.config import NetworkConfig
from predictor.export import DESCRIPTION, export_network
from predictor.forecaster import BUNDLED_WEIGHTS, make_forecaster
from predictor.model import IterativeAttention
from predictor.network_forecaster import NetworkForecaster
from predictor.networks import Network, build_network, config_from_dict
from predictor.onnx_network import load_onnx
from predictor.scenes import scenes

SIZES = [(1, 3), (7, 1), (64, 8)]
"""Agents and neighbors."""
SMALL = {"latents": 2, "width": 24, "time_code": 8, "blocks": 1, "heads": 2, "residual": True}
SHORT = {"history_steps": 3, "forecast_steps": 2}


def random_inputs(config: NetworkConfig, agents: int, neighbors: int) -> dict[str, torch.Tensor]:
    rng, steps, side = np.random.default_rng(agents), config.history_steps, config.crop_px
    inputs = {
        "history": rng.normal(size=(agents, steps, 2)).astype(np.float32),
        "history_valid": rng.random((agents, steps)) < 0.8,
        "neighbors": rng.normal(0.0, 4.0, (agents, neighbors, steps, 2)).astype(np.float32),
        "neighbors_valid": rng.random((agents, neighbors, steps)) < 0.7,
        "last_step": rng.normal(size=(agents, 2)).astype(np.float32),
    }
    inputs["neighbors_valid"][0] = False
    if config.variant != "none":
        inputs["crop"] = rng.integers(0, 256, (agents, side, side, 3), dtype=np.uint8)
        inputs["crop_valid"] = rng.random(agents) < 0.7
    return {name: torch.from_numpy(array) for name, array in inputs.items()}


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bundled weights as ONNX."""
    pytest.importorskip("onnxscript")
    pytest.importorskip("onnxruntime")
    out = tmp_path_factory.mktemp("exported") / "bundled.onnx"
    export_network(*load_checkpoint(BUNDLED_WEIGHTS["iterative_attention"]), out)
    return out


def test_onnx_gives_what_torch_gives_for_any_number_of_agents_and_neighbors(
    exported: Path,
) -> None:
    network, about = load_checkpoint(BUNDLED_WEIGHTS["iterative_attention"])
    onnx, kept = load_onnx(exported)
    assert kept == about
    assert onnx.config == network.config
    for agents, neighbors in SIZES:
        inputs = random_inputs(network.config, agents, neighbors)
        with torch.inference_mode():
            expected = network(**inputs)
        for found, of_torch in zip(onnx(**inputs), expected, strict=True):
            torch.testing.assert_close(found, of_torch, atol=1e-5, rtol=0.0)


@pytest.mark.parametrize("horizon", [4.8, 9.6])
def test_onnx_is_a_forecaster(exported: Path, horizon: float) -> None:
    ours = make_forecaster("iterative_attention", horizon=horizon)
    other = make_forecaster(f"{exported}", horizon=horizon)
    assert isinstance(ours, NetworkForecaster)
    assert isinstance(other, NetworkForecaster)
    crowd = walkers(np.random.default_rng(0), people=11)
    scene = next(scenes(crowd, history_steps=8, forecast_steps=12))
    seen = scene.history, scene.valid, crowd.map_image, crowd.pixel_from_world
    np.testing.assert_allclose(other.forecast(*seen), ours.forecast(*seen), atol=1e-4)
    assert np.array_equal(other.radius, ours.radius) or horizon > 4.8


@pytest.mark.parametrize("name", ["iterative_attention", "history_mlp", "lstm", "social_lstm"])
def test_every_network_is_exported_by_torch(tmp_path: Path, name: str) -> None:
    sizes = {**SMALL, "modes": 3} if name == "iterative_attention" else SHORT
    config = config_from_dict(name, sizes)
    network = built(config)
    export_network(network, {"model": name}, tmp_path / "network.pt2")
    program = torch.export.load(tmp_path / "network.pt2").module()
    for agents, neighbors in SIZES:
        inputs = random_inputs(config, agents, neighbors)
        with torch.inference_mode():
            expected, found = network(**inputs), program(**inputs)
        assert len(found) == (5 if name == "iterative_attention" else 2)
        for mine, theirs in zip(expected, found[:2], strict=True):
            torch.testing.assert_close(mine, theirs, atol=1e-5, rtol=0.0)
    with ZipFile(tmp_path / "network.pt2") as archive:
        kept = next(file for file in archive.namelist() if file.endswith(DESCRIPTION))
        assert json.loads(archive.read(kept)) == {"model": name}


def built(config: NetworkConfig) -> Network:
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        return build_network(config).eval()


def test_modes_survive(tmp_path: Path) -> None:
    pytest.importorskip("onnxscript")
    pytest.importorskip("onnxruntime")
    config = config_from_dict("iterative_attention", {**SMALL, "modes": 3})
    network = built(config)
    assert isinstance(network, IterativeAttention)
    about = {"model": "iterative_attention", "config": vars(config)}
    export_network(network, about, tmp_path / "modes.onnx")
    onnx, _ = load_onnx(tmp_path / "modes.onnx")
    crowd = walkers(np.random.default_rng(0), people=5)
    scene = next(scenes(crowd, history_steps=8, forecast_steps=12))
    mine, theirs = (
        NetworkForecaster(n).forecast_modes(scene.history, scene.valid) for n in (network, onnx)
    )
    for field in ("path", "position", "probability", "covariance"):
        np.testing.assert_allclose(getattr(theirs, field), getattr(mine, field), atol=1e-5)


def test_what_cannot_be_written_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    network = built(config_from_dict("history_mlp", {}))
    with pytest.raises(ValueError, match=r"named \.onnx or \.pt2, found 'network\.pb'"):
        export_network(network, {}, tmp_path / "network.pb")
    monkeypatch.setattr("predictor.export.find_spec", lambda name: None)
    with pytest.raises(ValueError, match=r"pip install 'crowdnav-testbed\[onnx\]'"):
        export_network(network, {}, tmp_path / "network.onnx")
    assert list(tmp_path.iterdir()) == []


def test_what_is_no_exported_network_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("onnxruntime")
    (tmp_path / "broken.onnx").write_bytes(b"not a network")
    with pytest.raises(ValueError, match=r"broken\.onnx: expected ONNX"):
        make_forecaster(str(tmp_path / "broken.onnx"))


def test_a_missing_runtime_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    (tmp_path / "network.onnx").write_bytes(b"")
    with pytest.raises(ValueError, match=r"onnxruntime.*pip install 'crowdnav-testbed\[onnx\]'"):
        load_onnx(tmp_path / "network.onnx")
