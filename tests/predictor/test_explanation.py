"""One forecast laid open, and its picture."""

import cv2
import numpy as np
import pytest
from hand_made_crowds import network, walkers

from predictor.attention_picture import attention_picture
from predictor.config import Variant
from predictor.explanation import attentive_network, explain
from predictor.inputs import to_world
from predictor.network_forecaster import NetworkForecaster
from predictor.scenes import scenes


def test_it_lays_open_the_forecast_of_that_agent_in_that_scene(variant: Variant) -> None:
    crowds = [walkers(np.random.default_rng(seed), frames=22, name=f"{seed}") for seed in (0, 1)]
    found = explain(network(variant), crowds, scene=4, agent=2)
    scene = list(scenes(crowds[1], history_steps=8, forecast_steps=12))[1]
    picture = crowds[1].map_image, crowds[1].pixel_from_world
    forecast = NetworkForecaster(network(variant)).forecast(scene.history, scene.valid, *picture)
    frame = found.inputs.world_from_agent
    shown = to_world(found.forecasts["forecast"][None], frame)[0]
    np.testing.assert_allclose(shown, forecast[:, 2], atol=1e-4)
    np.testing.assert_allclose(to_world(found.future[None], frame)[0], scene.future[:, 2])
    assert ("without map" in found.forecasts) == (variant == "patch")
    assert (found.attended.ground is None) == (variant == "none")


def test_picture_is_drawn_with_and_without_a_map(variant: Variant) -> None:
    crowd = walkers(np.random.default_rng(0))
    drawn = attention_picture(explain(network(variant), [crowd], scene=0, agent=1))
    image = cv2.imdecode(np.frombuffer(drawn, dtype=np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    assert image.shape[1] > image.shape[0] > 500
    assert image.std() > 20.0


def test_what_cannot_be_explained_is_named() -> None:
    crowd = walkers(np.random.default_rng(0))
    with pytest.raises(ValueError, match="number of a scene in the data, got 7"):
        explain(network("none"), [crowd], scene=7, agent=0)
    with pytest.raises(ValueError, match="agent below 6 in the scene, got 6"):
        explain(network("none"), [crowd], scene=0, agent=6)
    with pytest.raises(ValueError, match="a network that attends"):
        attentive_network("constant_velocity")
