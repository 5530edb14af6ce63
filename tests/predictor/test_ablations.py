"""What a network is not shown, or shown wrongly, by the ending of its name."""

from collections.abc import Callable

import numpy as np
import pytest
from hand_made_crowds import network, noise_picture, walkers

from predictor.ablation import ENDINGS, EVERYTHING, Ablation, ablated, split_endings
from predictor.config import ModelConfig
from predictor.forecaster import make_forecaster
from predictor.inputs import AgentInputs, build_inputs
from predictor.network_forecaster import NetworkForecaster
from predictor.scenes import scenes

PATCH = ModelConfig(variant="patch")
Shown = Callable[[Ablation], AgentInputs]


@pytest.fixture
def shown() -> Shown:
    """The inputs of four people as an ablation shows them."""
    recording = walkers(np.random.default_rng(0))
    scene = next(scenes(recording, history_steps=8, forecast_steps=12))
    agents, picture = np.arange(4), (recording.map_image, recording.pixel_from_world)
    inputs = build_inputs(scene.history, scene.valid, agents, *picture, PATCH)
    images, homographies = ([part] for part in picture)
    return lambda ablation: ablated(
        inputs, ablation, np.zeros(4, dtype=np.int64), images, homographies, PATCH
    )


def test_endings_add_up() -> None:
    assert split_endings("runs/a@b") == ("runs/a@b", EVERYTHING)
    assert split_endings("x@no_map@no_neighbors") == ("x", Ablation(ground="none", neighbors=False))
    assert split_endings("x@no_history") == ("x", Ablation(history=False))
    with pytest.raises(ValueError, match="one ending about the same"):
        split_endings("x@no_map@wrong_map")


def test_an_unknown_ending_is_named() -> None:
    with pytest.raises(ValueError, match=r"@no_map.*got 'iterative_attention@no_mpa'"):
        make_forecaster("iterative_attention@no_mpa")


def test_each_ending_changes_the_forecast_and_nothing_does_not() -> None:
    recording, seeing = walkers(np.random.default_rng(1), people=9), network("patch")
    scene = next(scenes(recording, history_steps=8, forecast_steps=12))
    given = scene.history, scene.valid, recording.map_image, recording.pixel_from_world
    plain = NetworkForecaster(seeing).forecast(*given)
    assert np.array_equal(NetworkForecaster(seeing, ablation=EVERYTHING).forecast(*given), plain)
    for ending in ENDINGS:
        ablation = split_endings(ending)[1]
        changed = NetworkForecaster(seeing, ablation=ablation).forecast(*given)
        assert np.abs(changed - plain).max() > 1e-3, ending


def test_an_ablation_of_one_agent_does_not_depend_on_who_else_is_asked_for() -> None:
    recording = walkers(np.random.default_rng(1), people=9)
    scene = next(scenes(recording, history_steps=8, forecast_steps=12))
    given = scene.history, scene.valid, recording.map_image, recording.pixel_from_world
    for ending in ENDINGS:
        forecaster = NetworkForecaster(network("patch"), ablation=split_endings(ending)[1])
        alone = forecaster.forecast(*given, np.arange(9) == 5)
        assert np.array_equal(alone[:, 5], forecaster.forecast(*given)[:, 5]), ending


def test_without_history_the_last_step_is_left(shown: Shown) -> None:
    inputs, plain = shown(Ablation(history=False)), shown(EVERYTHING)
    assert inputs.history_valid.tolist() == [[False] * 6 + [True] * 2] * 4
    assert not inputs.history[:, :6].any()
    assert np.array_equal(inputs.history[:, 6:], plain.history[:, 6:])
    assert np.array_equal(inputs.last_step, plain.last_step)
    assert np.array_equal(inputs.neighbors, plain.neighbors)


def test_without_neighbors_nobody_is_there(shown: Shown) -> None:
    inputs = shown(Ablation(neighbors=False))
    assert not inputs.neighbors_valid.any()
    assert not inputs.neighbors.any()
    assert np.array_equal(inputs.history, shown(EVERYTHING).history)


def test_blank_ground_is_that_under_the_feet(shown: Shown) -> None:
    blank, plain = shown(Ablation(ground="blank")).crop, shown(EVERYTHING).crop
    assert blank is not None
    assert plain is not None
    assert (blank == plain[:, 32:33, 16:17]).all()


def test_rotated_ground_turns_about_the_agent(shown: Shown) -> None:
    """What lay ahead of the agent lies to its right; the agent is at row 31.5, column 15.5."""
    turned, plain = shown(Ablation(ground="rotated")).crop, shown(EVERYTHING).crop
    assert turned is not None
    assert plain is not None
    ahead, left = np.meshgrid(np.arange(48), np.arange(48))
    expected = plain[:, 47 - left, ahead].swapaxes(1, 2).astype(np.int64)
    assert np.abs(turned[:, 16:, :48] - expected).mean() < 1.0
    assert np.abs(plain[:, 16:, :48] - expected).mean() > 10.0


def test_wrong_ground_is_that_half_a_picture_away() -> None:
    picture = noise_picture(np.random.default_rng(3))
    track = np.arange(8.0)[:, None, None] * np.array([0.5, 0.0])
    valid = np.ones((8, 1), dtype=np.bool_)

    def crop(history: np.ndarray, ablation: Ablation) -> np.ndarray:
        images, homographies = [picture.image], [picture.pixel_from_world]
        agents = np.array([0])
        inputs = build_inputs(history, valid, agents, images[0], homographies[0], PATCH)
        found = ablated(inputs, ablation, agents, images, homographies, PATCH).crop
        assert found is not None
        return found

    wrong, away = Ablation(ground="wrong"), np.array([-10.0, -10.0])
    assert np.array_equal(crop(track, wrong), crop(track + away, EVERYTHING))
    beyond_two_edges = crop(track + away, wrong)
    assert np.array_equal(beyond_two_edges, crop(track, EVERYTHING))


def test_mirrored_forecast_is_the_same_for_both_sides() -> None:
    """Of a network that is not: the forecast of the mirrored scene is the mirrored forecast."""
    recording, seeing = walkers(np.random.default_rng(1), people=9), network("patch")
    scene = next(scenes(recording, history_steps=8, forecast_steps=12))
    mirror = np.diag([1.0, -1.0, 1.0])
    assert recording.pixel_from_world is not None
    for ablation, least, most in ((EVERYTHING, 0.01, np.inf), (Ablation(mirrored=True), 0.0, 1e-3)):
        forecaster = NetworkForecaster(seeing, ablation=ablation)
        there, here = (
            forecaster.forecast(
                scene.history @ side[:2, :2],
                scene.valid,
                recording.map_image,
                recording.pixel_from_world @ side,
            )
            for side in (mirror, np.eye(3))
        )
        assert least <= np.abs(there @ mirror[:2, :2] - here).max() <= most
