"""The weights that come with the package."""

import hashlib
from dataclasses import replace

import numpy as np
import pytest
from hand_made_crowds import walkers
from safetensors.torch import save

from predictor.checkpoint import load_checkpoint
from predictor.config import named_configuration
from predictor.forecaster import BUNDLED_WEIGHTS, make_forecaster
from predictor.scenes import scenes

CONFIGURATION = {"iterative_attention": "residual", "fast": "fast"}


@pytest.fixture(params=BUNDLED_WEIGHTS)
def bundled(request: pytest.FixtureRequest) -> str:
    """Name of their forecaster."""
    name: str = request.param
    return name


def test_they_say_how_they_were_made_and_beat_constant_velocity_there(bundled: str) -> None:
    model, about = load_checkpoint(BUNDLED_WEIGHTS[bundled])
    config, _ = named_configuration(CONFIGURATION[bundled], variant="patch")
    assert model.config == replace(config, modes=6)
    assert "crowdnav generate" in about["command"]
    assert "crowdnav train-predictor" in about["command"]
    metrics = about["metrics"]
    for key in ("ade", "fde"):
        assert metrics["validation"][key] < metrics["constant_velocity"][key]


def test_they_are_small(bundled: str) -> None:
    files = BUNDLED_WEIGHTS[bundled], BUNDLED_WEIGHTS[bundled].with_suffix(".json")
    assert sum(file.stat().st_size for file in files) < 4_000_000


def test_modes_were_added_to_weights_that_are_still_the_same(bundled: str) -> None:
    model, about = load_checkpoint(BUNDLED_WEIGHTS[bundled])
    weights = model.state_dict()
    point = {name: weights[name] for name in weights if not name.startswith("mode_decoder.")}
    assert len(point) < len(weights)
    assert hashlib.sha256(save(point)).hexdigest() == about["init"]["sha256"]


def test_they_let_a_straight_walker_walk_on(bundled: str) -> None:
    forecaster = make_forecaster(bundled)
    assert forecaster is not None
    history = np.arange(8.0)[:, None, None] * np.array([0.5, 0.0])
    path = forecaster.forecast(history, np.ones((8, 1), dtype=np.bool_))
    forward = path[:, 0, 0] - history[-1, 0, 0]
    assert (np.diff(forward) > 0.0).all()
    assert 2.0 < forward[-1] < 8.0


def test_they_stay_at_walking_speed_when_rolled_on(bundled: str) -> None:
    forecaster = make_forecaster(bundled, horizon=19.2)
    assert forecaster is not None
    crowd = walkers(np.random.default_rng(0), people=12)
    scene = next(scenes(crowd, history_steps=8, forecast_steps=12))
    path = forecaster.forecast(scene.history, scene.valid, crowd.map_image, crowd.pixel_from_world)
    speed = np.linalg.norm(np.diff(path, axis=0), axis=-1) / 0.4
    assert speed.max() < 4.0


def test_no_map_is_as_if_there_were_no_picture(bundled: str) -> None:
    seeing, blind = (make_forecaster(bundled + end) for end in ("", "@no_map"))
    assert seeing is not None
    assert blind is not None
    crowd = walkers(np.random.default_rng(0), people=12)
    scene = next(scenes(crowd, history_steps=8, forecast_steps=12))
    crowd_seen = scene.history, scene.valid
    picture = crowd.map_image, crowd.pixel_from_world
    unseen = seeing.forecast(*crowd_seen)
    np.testing.assert_array_equal(blind.forecast(*crowd_seen, *picture), unseen)
    assert not np.array_equal(seeing.forecast(*crowd_seen, *picture), unseen)
