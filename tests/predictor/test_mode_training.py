"""Training modes: with the network, or added to a trained one that stays as it is."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hand_made_crowds import walkers

from crowdsim.recordings import write_recordings
from predictor.checkpoint import load_checkpoint
from predictor.config import ModelConfig, TrainConfig, named_configuration
from predictor.metrics import displacement_errors
from predictor.modal_metrics import nll, region_mass
from predictor.model import IterativeAttention
from predictor.networks import Network, configuration
from predictor.train import TrainResult, train
from predictor.validation import validated, window_errors, window_modes
from predictor.windows import Windows, extract_windows

SMALL = ModelConfig(
    latents=2, width=24, time_code=8, blocks=1, heads=2, residual=True, path_rows="flatten"
)


def trained(folder: Path, out: str, model: ModelConfig, **changes: object) -> TrainResult:
    init = changes.pop("init", None)
    _, training = named_configuration("residual", epochs=2)
    return train(
        data=str(folder / "crowds"),
        out=folder / out,
        model=model,
        training=replace(training, **changes),
        init=init,
        progress=False,
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("modes")
    rng = np.random.default_rng(0)
    crowds = [walkers(rng, 12, 24, name=f"crowd_{i}") for i in range(12)]
    write_recordings(folder / "crowds", crowds)
    trained(folder, "plain", SMALL)
    return folder


def windows_and_network(checkpoint: Path) -> tuple[Windows, IterativeAttention]:
    network: Network = load_checkpoint(checkpoint)[0]
    assert isinstance(network, IterativeAttention)
    crowd = walkers(np.random.default_rng(9), 12, 24)
    return extract_windows([crowd], network.config), network


def test_modes_are_added_to_a_trained_network_that_stays_as_it_is(folder: Path) -> None:
    with_modes = replace(SMALL, modes=3)
    found = trained(
        folder, "added", with_modes, init=folder / "plain", train_only="modes", epochs=3
    )
    assert found.best_epoch == 3
    before, after = (load_checkpoint(folder / name)[0] for name in ("plain", "added"))
    weights = after.state_dict()
    for name, value in before.state_dict().items():
        assert value.equal(weights[name]), name
    windows, network = windows_and_network(folder / "added")
    plain = windows_and_network(folder / "plain")[1]
    np.testing.assert_array_equal(window_errors(network, windows), window_errors(plain, windows))


def test_modes_are_trained_together_with_the_network(folder: Path) -> None:
    found = trained(folder, "together", replace(SMALL, modes=2), train_only="all")
    about = json.loads((folder / "together" / "best.json").read_text())
    assert about["metrics"]["validation"]["nll"] == found.validation["nll"]
    assert len(about["calibration"]["temperature"]) == 12
    assert about["config"]["modes"] == 2


def test_validation_of_modes_is_that_of_the_path_and_calibrates(folder: Path) -> None:
    windows, network = windows_and_network(folder / "together")
    forecast, future = window_modes(network, windows)
    errors = window_errors(network, windows)
    np.testing.assert_array_equal(displacement_errors(forecast.path, future).T, errors)
    found, calibration = validated(network, windows)
    assert found["nll"] == pytest.approx(nll(forecast, future).mean())
    factors = np.array(calibration["temperature"])[:, None, None, None]
    calibrated = replace(forecast, covariance=forecast.covariance * factors)
    held = (region_mass(calibrated, future) <= 0.9).mean(axis=1)
    np.testing.assert_allclose(held, 0.9, atol=0.08)


def test_only_a_network_with_modes_can_train_only_those(folder: Path) -> None:
    with pytest.raises(ValueError, match="expected a network with modes"):
        trained(folder, "none", SMALL, train_only="modes")
    with pytest.raises(ValueError, match="train_only must be"):
        TrainConfig(train_only="goal")
    with pytest.raises(ValueError, match="modes must be 0 for lstm"):
        configuration("lstm", "residual", modes=6)
