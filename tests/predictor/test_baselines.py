"""The networks that ours is measured against, and the registry that names them all."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from hand_made_crowds import baseline, walkers
from torch import Tensor

from predictor.baselines.social_lstm import SocialLstm, SocialLstmConfig
from predictor.checkpoint import load_checkpoint, save_checkpoint
from predictor.config import ConfigName, ModelName, TrainConfig
from predictor.forecaster import make_forecaster
from predictor.model import loss
from predictor.networks import NETWORKS, Network, config_from_dict, configuration, name_of
from predictor.tensors import tensors
from predictor.train import fit
from predictor.windows import extract_windows


def arguments(network: Network) -> dict[str, Tensor]:
    crowd = walkers(np.random.default_rng(0), people=5)
    return tensors(extract_windows([crowd], network.config).batch(np.arange(5))[0])


def test_a_checkpoint_of_any_network_comes_back(baseline_name: ModelName, tmp_path: Path) -> None:
    network = baseline(baseline_name)
    save_checkpoint(tmp_path / "best.safetensors", network, {})
    loaded, about = load_checkpoint(tmp_path)
    assert about["model"] == baseline_name == name_of(loaded.config)
    assert loaded.config == network.config
    given = arguments(network)
    with torch.inference_mode():
        assert torch.equal(network(**given)[1], loaded(**given)[1])
    forecaster = make_forecaster(str(tmp_path))
    assert forecaster is not None
    assert forecaster.name == baseline_name


def test_every_parameter_gets_a_gradient(baseline_name: ModelName) -> None:
    network = baseline(baseline_name).train()
    goal, path = network(**arguments(network))
    loss(goal, path, torch.ones(5, 12, 2)).backward()
    without = [n for n, p in network.named_parameters() if p.grad is None or not p.grad.any()]
    assert without == []


@pytest.mark.parametrize("config_name", ["residual", "paper"])
def test_silent_baseline_is_constant_velocity_or_stands(
    baseline_name: ModelName, config_name: ConfigName
) -> None:
    network = baseline(baseline_name, config_name)
    last = list(network.children())[-1]
    last = last[-1] if isinstance(last, torch.nn.Sequential) else last
    with torch.no_grad():
        last.weight.zero_()
        last.bias.zero_()
        given = arguments(network)
        goal, path = network(**given)
    step = given["last_step"] if config_name == "residual" else torch.zeros(5, 2)
    torch.testing.assert_close(path[:, 2], 3.0 * step)
    assert torch.equal(goal, path[:, -1])


def test_learns_what_constant_velocity_misses(baseline_name: ModelName, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    config, training = configuration(baseline_name, "residual", epochs=1)
    config = replace(config, neighbors=1)
    windows = extract_windows([walkers(rng, 8, name=f"{i}", bend=0.06) for i in range(8)], config)
    again = replace(windows, tracks=windows.tracks.take(np.tile(np.arange(64), 100)))
    training = replace(
        training, batch_size=64, learning_rate=1e-2, mirror=False, scale=0.0, truncate=0.0
    )
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        network = NETWORKS[baseline_name].network(config)
    found = fit(network, again, windows, training, out=tmp_path, about={}, progress=False)
    assert found.validation["ade"] < 0.5 * found.constant_velocity["ade"]


def test_hidden_states_are_pooled_where_the_others_are() -> None:
    """Two others: one in the cell ahead on the left, one beyond the grid."""
    config = SocialLstmConfig(hidden=2, embedding=3, grid=4, cell_side=1.0)
    network = SocialLstm(config)
    position = torch.tensor([[[0.0, 0.0], [0.5, 1.5], [2.5, 0.0]]])
    hidden = torch.tensor([[[9.0, 9.0], [1.0, 2.0], [3.0, 4.0]]])
    there = torch.ones(1, 3, dtype=torch.bool)
    weight = network.pooling.weight.view(4, 4, 3, 2)  # row and column of the cell, E, D
    pooled = network._pool(position, there, hidden)
    torch.testing.assert_close(pooled[0, 0], weight[3, 2] @ hidden[0, 1])
    torch.testing.assert_close(pooled[0, 1], weight[0, 1] @ hidden[0, 0])
    there[0, 1] = False
    assert not network._pool(position, there, hidden)[0, 0].any()


def test_only_social_lstm_looks_at_neighbors(baseline_name: ModelName) -> None:
    network = baseline(baseline_name)
    plain = arguments(network)
    alone = {**plain, "neighbors_valid": torch.zeros_like(plain["neighbors_valid"])}
    with torch.inference_mode():
        same = torch.allclose(network(**plain)[1], network(**alone)[1], atol=1e-5)
    assert same == (baseline_name != "social_lstm")


def test_baselines_see_no_map_and_are_given_no_goal(baseline_name: ModelName) -> None:
    with pytest.raises(ValueError, match="variant must be 'none'"):
        configuration(baseline_name, "residual", variant="patch")
    assert not configuration(baseline_name, "paper")[1].true_goal
    assert configuration("iterative_attention", "paper")[1] == TrainConfig()


def test_unknown_network_is_named() -> None:
    with pytest.raises(ValueError, match="social_lstm, got 'transformer'"):
        config_from_dict("transformer", {})
