"""Several futures of each agent: what must hold of them whatever was learned."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from hand_made_crowds import network, walkers
from torch import Tensor

from predictor.config import RESIDUAL
from predictor.forecaster import Forecaster, ModalForecaster
from predictor.model import IterativeAttention
from predictor.modes import LEAST_DEVIATION, ModeDecoder, Modes, mode_loss
from predictor.network_forecaster import NetworkForecaster
from predictor.networks import has_modes
from predictor.scenes import scenes
from predictor.tensors import tensors
from predictor.windows import extract_windows


def modal_network(modes: int = 6) -> IterativeAttention:
    """A fresh network whose modes shout as its decoders do."""
    plain = network("patch")
    config = replace(plain.config, modes=modes)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        modal = IterativeAttention(config)
    modal.load_state_dict(plain.state_dict(), strict=False)
    assert modal.mode_decoder is not None
    with torch.no_grad():
        for layer in (modal.mode_decoder.path, modal.mode_decoder.logits):
            layer.weight.mul_(10.0)
    return modal.eval()


def arguments(model: IterativeAttention) -> tuple[dict[str, Tensor], Tensor]:
    windows = extract_windows([walkers(np.random.default_rng(0), people=5)], model.config)
    inputs, future = windows.batch(np.arange(5))
    return tensors(inputs), torch.from_numpy(future)


def crowd() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    recording = walkers(np.random.default_rng(0), people=6)
    scene = next(scenes(recording, history_steps=8, forecast_steps=12))
    assert recording.picture is not None
    return scene.history, scene.valid, recording.picture.image, recording.picture.pixel_from_world


def test_modes_leave_the_point_forecast_as_it_is() -> None:
    plain, modal = network("patch"), modal_network()
    inputs, _ = arguments(plain)
    with torch.inference_mode():
        expected, found = plain(**inputs), modal(**inputs)
        goal, path, _ = modal.forward_modes(**inputs)
    for a, b, c in zip(expected, found, (goal, path), strict=True):
        assert torch.equal(a, b)
        assert torch.equal(a, c)
    history, valid, image, homography = crowd()
    forecaster = NetworkForecaster(modal)
    path_alone = forecaster.forecast(history, valid, image, homography)
    np.testing.assert_array_equal(
        forecaster.forecast_modes(history, valid, image, homography).path, path_alone
    )


def test_covariances_are_positive_definite_and_probabilities_sum_to_one() -> None:
    factor = torch.tensor([[0.0, 0.0, 0.0], [0.0, 9.0, 0.0], [5.0, -90.0, 1e-6], [-3.0, 1.0, 2.0]])
    modes = Modes(path=torch.zeros(1, 1, 4, 2), logits=torch.zeros(1, 1), factor=factor[None, None])
    least = np.linalg.eigvalsh(modes.covariance().double().numpy())[..., 0]
    assert (least > 0.9 * LEAST_DEVIATION**2).all()
    normal = torch.distributions.MultivariateNormal(
        modes.path.double(), modes.covariance().double(), validate_args=False
    )
    future = torch.tensor([[[0.1, 0.2], [0.3, 4.0], [1.0, -18.0], [-2.0, 1.0]]])
    torch.testing.assert_close(
        modes.log_density(future).double(),
        normal.log_prob(future[:, None].double()),
        rtol=1e-3,
        atol=1e-2,
    )
    found = NetworkForecaster(modal_network()).forecast_modes(*crowd())
    assert found.position.shape == (6, 12, 6, 2)
    np.testing.assert_allclose(found.probability.sum(axis=0), 1.0)
    assert (np.diff(found.probability, axis=0) <= 0.0).all()
    assert (np.linalg.eigvalsh(found.covariance) > 0.0).all()


def test_modes_turn_and_move_with_the_scene() -> None:
    forecaster = NetworkForecaster(modal_network())
    history, valid, image, homography = crowd()
    angle, shift = 0.7, np.array([30.0, -20.0])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    world_from_moved = np.eye(3)
    world_from_moved[:2, :2], world_from_moved[:2, 2] = turn.T, -turn.T @ shift
    here = forecaster.forecast_modes(history, valid, image, homography)
    there = forecaster.forecast_modes(
        history @ turn.T + shift, valid, image, homography @ world_from_moved
    )
    np.testing.assert_allclose(there.position, here.position @ turn.T + shift, atol=2e-2)
    np.testing.assert_allclose(there.covariance, turn @ here.covariance @ turn.T, atol=2e-2)
    np.testing.assert_allclose(there.probability, here.probability, atol=2e-2)


def test_order_of_neighbors_and_size_of_the_batch_change_nothing() -> None:
    forecaster = NetworkForecaster(modal_network())
    history, valid, image, homography = crowd()
    order = np.array([3, 1, 5, 0, 4, 2])
    here = forecaster.forecast_modes(history, valid, image, homography)
    there = forecaster.forecast_modes(history[:, order], valid[:, order], image, homography)
    np.testing.assert_allclose(there.position, here.position[:, :, order], atol=1e-5)
    alone = forecaster.forecast_modes(history, valid, image, homography, select=np.arange(6) == 2)
    np.testing.assert_array_equal(alone.position[:, :, 2], here.position[:, :, 2])
    np.testing.assert_array_equal(alone.position[:, :, 4], history[-1, 4] + np.zeros((6, 12, 2)))
    assert not alone.covariance[:, :, 4].any()


def test_several_worlds_are_as_each_alone_and_a_shorter_horizon_is_cut_off() -> None:
    forecaster = NetworkForecaster(modal_network())
    history, valid, image, homography = crowd()
    both = forecaster.forecast_modes(
        np.stack([history, history + 1.0]), np.stack([valid] * 2), [image, None], [homography, None]
    )
    alone = forecaster.forecast_modes(history, valid, image, homography)
    np.testing.assert_array_equal(both.of_world(0).position, alone.position)
    brief = NetworkForecaster(modal_network(), forecast_steps=3)
    found = brief.forecast_modes(history, valid, image, homography)
    np.testing.assert_array_equal(found.covariance, alone.covariance[:, :3])


def test_there_are_no_modes_without_a_decoder_nor_beyond_its_horizon() -> None:
    history, valid, image, homography = crowd()
    for forecaster in (
        NetworkForecaster(network("patch")),
        NetworkForecaster(modal_network(), forecast_steps=13),
    ):
        plain: Forecaster = forecaster
        assert isinstance(plain, ModalForecaster)
        assert plain.modes == 0
        with pytest.raises(ValueError, match="expected a forecaster with modes"):
            forecaster.forecast_modes(history, valid, image, homography)


def test_temperature_scales_covariances() -> None:
    temperature = np.linspace(0.5, 2.0, 12)
    plain = NetworkForecaster(modal_network()).forecast_modes(*crowd())
    found = NetworkForecaster(modal_network(), temperature=temperature).forecast_modes(*crowd())
    np.testing.assert_allclose(
        found.covariance, plain.covariance * temperature[:, None, None, None]
    )


def test_gradients_reach_every_parameter_of_the_modes_and_no_other() -> None:
    model = modal_network().train()
    inputs, future = arguments(model)
    _, _, modes = model.forward_modes(**inputs)
    mode_loss(modes, future).backward()
    reached = {n for n, p in model.named_parameters() if p.grad is not None and p.grad.any()}
    assert reached == {n for n, _ in model.named_parameters() if n.startswith("mode_decoder.")}


def test_the_true_goal_is_not_told_to_the_modes() -> None:
    model = modal_network()
    inputs, _ = arguments(model)
    with torch.inference_mode():
        _, own, modes = model.forward_modes(**inputs)
        _, told, same = model.forward_modes(**inputs, true_goal=own[:, -1] + 5.0)
    assert not torch.allclose(own, told, atol=1e-3)
    assert torch.equal(modes.path, same.path)


def test_learns_that_people_turn_left_or_right() -> None:
    """From the same latents a third turns right and two thirds turn left."""
    ahead = torch.arange(1.0, 13.0)
    turn = torch.stack([0.4 * ahead, 0.02 * ahead**2], dim=-1)
    sides = torch.tensor([-1.0, 1.0, 1.0]).repeat(32)
    future = turn * torch.stack([torch.ones(96), sides], dim=-1)[:, None]
    latents, path = torch.zeros(96, 12, 48), torch.zeros(96, 12, 2)
    path[..., 0] = 0.4 * ahead
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        decoder = ModeDecoder(576, 2, 12)
        optimizer = torch.optim.AdamW(decoder.parameters(), lr=2e-3)
        for _ in range(400):
            optimizer.zero_grad()
            mode_loss(decoder(latents, path), future).backward()
            optimizer.step()
    with torch.inference_mode():
        modes = decoder(latents[:1], path[:1])
    right, left = modes.path[0, :, -1, 1].argsort().tolist()
    torch.testing.assert_close(modes.path[0, left], turn, atol=0.3, rtol=0.0)
    assert modes.path[0, right, -1, 1] < -2.0
    assert modes.logits.softmax(1)[0, left].item() == pytest.approx(2 / 3, abs=0.05)


def test_configuration_with_modes() -> None:
    assert not has_modes(network("none"))
    assert has_modes(modal_network(2))
    with pytest.raises(ValueError, match=r"modes must be in 0\.\.64"):
        replace(RESIDUAL[0], modes=-1)


def test_nobody_has_no_modes_and_who_has_just_come_has_finite_ones() -> None:
    forecaster = NetworkForecaster(modal_network())
    empty = forecaster.forecast_modes(np.zeros((8, 0, 2)), np.zeros((8, 0), dtype=np.bool_))
    assert empty.covariance.shape == (6, 12, 0, 2, 2)
    history, valid, image, homography = crowd()
    valid[:-1, 0] = False
    valid[-1, 1] = False
    found = forecaster.forecast_modes(history, valid, image, homography)
    for array in (found.path, found.position, found.probability, found.covariance):
        assert np.isfinite(array).all()
    assert not found.position[:, :, 1].any()
