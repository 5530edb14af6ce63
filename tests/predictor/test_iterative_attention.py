"""The network itself."""

import numpy as np
import pytest
import torch
from hand_made_crowds import network, walkers
from torch import nn

from predictor.config import ModelConfig, TrainConfig, Variant, named_configuration
from predictor.model import IterativeAttention, PatchEncoder, loss
from predictor.position_codes import sinusoidal_code
from predictor.tensors import tensors
from predictor.windows import Windows, extract_windows


def windows_of(config: ModelConfig) -> Windows:
    return extract_windows([walkers(np.random.default_rng(0), people=5)], config)


def arguments(model: IterativeAttention) -> dict[str, torch.Tensor]:
    return tensors(windows_of(model.config).batch(np.arange(5))[0])


def test_every_parameter_gets_a_gradient(variant: Variant, configuration: str) -> None:
    model = network(variant, configuration).train()
    goal, path = model(**arguments(model))
    loss(goal, path, torch.ones(5, 12, 2)).backward()
    without = [n for n, p in model.named_parameters() if p.grad is None or not p.grad.any()]
    assert without == []


def test_paper_is_the_model_of_the_design() -> None:
    config, training = named_configuration("paper")
    model = IterativeAttention(config)
    assert model.latents.shape == (12, 48)
    assert len(model.encoder_blocks) == 4

    def layers(decoder: nn.Sequential) -> list[tuple[int, int]]:
        return [(m.in_features, m.out_features) for m in decoder if isinstance(m, nn.Linear)]

    assert layers(model.goal_decoder) == [(576, 256), (256, 64), (64, 2)]
    assert layers(model.trajectory_decoder) == [(50, 256), (256, 64), (64, 24)]
    assert layers(model.pose_encoder.mlp) == [(2, 8), (8, 32)]
    assert training == TrainConfig(
        epochs=65, batch_size=32, schedule="step", learning_rate=5e-4, true_goal=True
    )


def test_time_code_is_the_usual_one() -> None:
    code = sinusoidal_code(8, 16)
    assert code.shape == (8, 16)
    np.testing.assert_allclose(code[3, :2], [np.sin(3.0), np.cos(3.0)], atol=1e-6)
    np.testing.assert_allclose(code[3, 2], np.sin(3.0 / 10000 ** (2 / 16)), atol=1e-6)


def test_each_stream_reaches_the_forecast_and_a_masked_one_does_not(
    variant: Variant, configuration: str
) -> None:
    model = network(variant, configuration)
    plain = arguments(model)
    edits = {"history": "history_valid", "neighbors": "neighbors_valid"}
    if variant == "patch":
        edits["crop"] = "crop_valid"
    for stream, mask in edits.items():
        hidden = {**plain, mask: torch.zeros_like(plain[mask])}
        edited = {**hidden, stream: torch.zeros_like(plain[stream])}
        with torch.inference_mode():
            seen, unseen = model(**plain)[1], model(**hidden)[1]
            assert torch.isfinite(unseen).all(), stream
            assert not torch.allclose(seen, unseen, atol=1e-4), stream
            assert torch.equal(unseen, model(**edited)[1]), stream


def test_patch_tokens_are_the_linear_map_of_centred_pixels() -> None:
    encoder = PatchEncoder(ModelConfig(variant="patch", crop_px=4, patch_px=2))
    crop = torch.randint(0, 256, (3, 4, 4, 3), dtype=torch.uint8)
    upper_right = crop[:, :2, 2:].flatten(1) / 255.0 - 0.5
    expected = encoder.linear(upper_right) + encoder.position_code[1]
    torch.testing.assert_close(encoder(crop)[:, 1], expected)


def test_residual_path_is_constant_velocity_where_the_decoders_are_silent() -> None:
    model = network("none")
    with torch.no_grad():
        for decoder in (model.goal_decoder, model.trajectory_decoder):
            decoder[-1].weight.zero_()
            decoder[-1].bias.zero_()
        inputs = arguments(model)
        goal, path = model(**inputs)
    torch.testing.assert_close(path[:, 2], 3.0 * inputs["last_step"])
    torch.testing.assert_close(goal, 12.0 * inputs["last_step"])


def test_path_follows_the_goal_that_is_given(configuration: str) -> None:
    model = network("none", configuration)
    with torch.inference_mode():
        goal, path = model(**arguments(model))
        same_goal, other_path = model(**arguments(model), true_goal=goal + 5.0)
    assert torch.equal(goal, same_goal)
    assert not torch.allclose(path, other_path, atol=1e-3)


def test_loss_by_hand() -> None:
    future = torch.zeros(1, 2, 2)
    path = torch.tensor([[[3.0, 4.0], [0.0, 1.0]]])
    assert loss(torch.tensor([[0.0, 2.0]]), path, future).item() == pytest.approx(3.0 + 0.5 * 2.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"heads": 7}, "heads must divide width"),
        ({"variant": "resnet"}, "variant must be one of"),
        ({"patch_px": 48}, "patch_px must divide crop_px"),
        ({"dropout": 1.0}, "dropout"),
        ({"tokens": "word"}, "tokens must be 'frame' or 'track', got 'word'"),
        ({"kernel": 3}, "unknown model keys"),
    ],
)
def test_bad_configuration_is_named(change: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ModelConfig.from_dict(change)
