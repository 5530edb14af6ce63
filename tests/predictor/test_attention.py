"""The read-out of attention: it is what the network computes with."""

from dataclasses import replace
from typing import Any

import numpy as np
import torch
from hand_made_crowds import network, walkers

from predictor.attention import attended, attention_weights
from predictor.config import Variant
from predictor.inputs import AgentInputs
from predictor.model import IterativeAttention
from predictor.tensors import tensors
from predictor.windows import extract_windows


def inputs_of(model: IterativeAttention) -> AgentInputs:
    windows = extract_windows([walkers(np.random.default_rng(0), people=5)], model.config)
    return windows.batch(np.arange(5))[0]


def test_weights_times_values_are_what_each_cross_attention_reads(variant: Variant) -> None:
    model = network(variant)
    inputs = inputs_of(model)
    inputs.neighbors_valid[0] = False
    seen: dict[tuple[str, int], tuple[Any, ...]] = {}
    for number, block in enumerate(model.encoder_blocks):
        for name, module in block.streams.items():
            module.register_forward_hook(
                lambda module, given, read, key=(name, number): seen.update({key: (*given, read)})
            )
    weights = attention_weights(model, inputs)
    assert set(weights) == {"history", "neighbors"} | ({"map"} if variant == "patch" else set())
    for (name, number), (latents, stream, read) in seen.items():
        module = model.encoder_blocks[number].streams[name]
        with torch.inference_mode():
            _, _, value = module.attention.project(module.norm(latents), stream.tokens)
            mixed = torch.from_numpy(weights[name][:, number]) @ value
            plain = module.attention.output(mixed.transpose(1, 2).flatten(2))
            expected = latents + plain * stream.any_valid
        torch.testing.assert_close(expected, read, atol=1e-5, rtol=1e-5)


def test_reading_out_leaves_the_network_as_it_was() -> None:
    model = network("patch")
    inputs = inputs_of(model)
    with torch.inference_mode():
        before = model(**tensors(inputs))[1]
        attention_weights(model, inputs)
        assert torch.equal(model(**tensors(inputs))[1], before)
    hooks = [module._forward_pre_hooks for module in model.modules()]
    assert not any(hooks)


def test_weights_add_up_to_one_over_what_is_valid() -> None:
    model = network("patch")
    inputs = inputs_of(model)
    inputs.history_valid[0, :5], inputs.neighbors_valid[0, 1] = False, False
    inputs.neighbors_valid[1], inputs.crop_valid[2] = False, False
    found = attended(model, inputs)
    assert found.history is not None
    assert found.ground is not None
    assert found.history.shape == (5, 8)
    assert found.neighbors.shape == (5, 8)
    assert found.ground.shape == (5, 4, 4)
    np.testing.assert_allclose(found.history.sum(axis=1), 1.0, rtol=1e-5)
    np.testing.assert_allclose(found.neighbors.sum(axis=1), [1.0, 0.0, 1.0, 1.0, 1.0], rtol=1e-5)
    np.testing.assert_allclose(found.ground.sum(axis=(1, 2)), [1.0, 1.0, 0.0, 1.0, 1.0], rtol=1e-5)
    assert not found.history[0, :5].any()
    assert found.neighbors[0, 1] == 0.0


def test_neighbors_who_cannot_be_told_apart_get_the_same_weight() -> None:
    model = network("patch")
    inputs = inputs_of(model)
    twice = replace(inputs, neighbors=np.repeat(inputs.neighbors[:, :1], 8, axis=1))
    twice.neighbors_valid[:] = False
    twice.neighbors_valid[:, :2] = True
    np.testing.assert_allclose(attended(model, twice).neighbors[:, :2], 0.5, atol=1e-6)


def test_a_network_that_reads_whole_tracks_has_one_weight_for_each_neighbor() -> None:
    model = network("patch", "fast")
    inputs = inputs_of(model)
    weights, found = attention_weights(model, inputs), attended(model, inputs)
    assert set(weights) == {"neighbors", "map"}
    assert weights["neighbors"].shape[-1] == model.config.neighbors
    assert found.history is None
    np.testing.assert_allclose(found.neighbors.sum(axis=1), 1.0, rtol=1e-5)
