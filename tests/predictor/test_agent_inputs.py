"""The inputs of the network: agent frame, neighbors, map crop."""

import numpy as np
import pytest
from hand_made_crowds import noise_picture, walkers

from predictor.config import ModelConfig
from predictor.inputs import (
    AgentInputs,
    agent_direction,
    build_inputs,
    last_step,
    to_world,
)
from predictor.neighbors import nearest
from predictor.scenes import scenes

PATCH = ModelConfig(variant="patch")
STRAIGHT = np.arange(8.0)[:, None] * np.array([0.0, 0.5])
"""Eight frames of walking along world +y."""


def track(*points: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """One person's last positions as (8, 1, 2) history with `valid`; unseen before."""
    history, valid = np.zeros((8, 1, 2)), np.zeros((8, 1), dtype=np.bool_)
    history[-len(points) :, 0], valid[-len(points) :] = points, True
    return history, valid


def inputs_of(history: np.ndarray, valid: np.ndarray, config: ModelConfig = PATCH) -> AgentInputs:
    return build_inputs(history, valid, np.array([0]), None, None, config)


def test_straight_ahead_is_plus_x_and_left_is_plus_y() -> None:
    ahead, left = np.array([0.0, 3.0]), np.array([-2.0, 0.0])
    history = np.stack([STRAIGHT, STRAIGHT + ahead, STRAIGHT + left], axis=1)
    inputs = inputs_of(history, np.ones((8, 3), dtype=np.bool_))
    nearer, farther = inputs.neighbors[0, :2, -1]
    np.testing.assert_allclose(nearer, [0.0, 2.0], atol=1e-6)
    np.testing.assert_allclose(farther, [3.0, 0.0], atol=1e-6)
    np.testing.assert_allclose(inputs.history[0, :, 0], 0.5 * np.arange(-7.0, 1.0), atol=1e-6)
    np.testing.assert_allclose(inputs.last_step, [[0.5, 0.0]], atol=1e-6)


def test_to_world_undoes_the_agent_frame() -> None:
    scene = next(scenes(walkers(np.random.default_rng(1)), history_steps=8, forecast_steps=12))
    inputs = build_inputs(scene.history, scene.valid, scene.agents, None, None, PATCH)
    back = to_world(inputs.history, inputs.world_from_agent)
    np.testing.assert_allclose(back.swapaxes(0, 1), scene.history, atol=1e-5)


@pytest.mark.parametrize(
    ("points", "direction"),
    [
        (((0, 0), (0, 1), (1, 1)), (1, 0)),
        (((0, 0), (0, 1), (0, 1)), (0, 1)),
        (((0, 0), (0, 0.02), (0.01, 0.02), (0, 0.02)), (0, 1)),
        (((3, 3), (3, 3)), (1, 0)),
        (((3, 3),), (1, 0)),
        (((0, 0), (5, 0), (0, 0.1)), (-5, 0.1)),
    ],
    ids=["walks", "stopped", "sways", "stands", "seen once", "turned back"],
)
def test_direction(points: tuple[tuple[float, float], ...], direction: tuple[float, float]) -> None:
    expected = np.array(direction) / np.hypot(*direction)
    np.testing.assert_allclose(agent_direction(*track(*points)), [expected], atol=1e-12)


def test_last_step_spans_a_gap() -> None:
    history, valid = track((0, 0), (9, 9), (9, 9), (3, 0))
    valid[-3:-1] = False
    step, known = last_step(history, valid)
    np.testing.assert_allclose(step, [[1.0, 0.0]])
    assert known.all()


def test_neighbors_are_the_nearest_who_are_seen_now() -> None:
    offsets = np.array([0.0, 5.0, 1.0, 2.0, 3.0, 4.0, 6.0, 7.0, 8.0, 9.0, 10.0])
    history = STRAIGHT[:, None] + np.stack([offsets, np.zeros(11)], axis=-1)
    valid = np.ones((8, 11), dtype=np.bool_)
    valid[-1, 2], valid[:3, 3] = False, False
    inputs = inputs_of(history, valid)
    distance = np.abs(inputs.neighbors[0, :, -1, 1])
    np.testing.assert_allclose(distance, [2, 3, 4, 5, 6, 7, 8, 9], atol=1e-6)
    assert inputs.neighbors_valid[0, 0].tolist() == [False] * 3 + [True] * 5
    assert (inputs.neighbors[0, 0, :3] == 0.0).all()


def test_nothing_is_read_where_not_valid() -> None:
    rng = np.random.default_rng(2)
    scene = next(scenes(walkers(rng), history_steps=8, forecast_steps=12))
    valid = scene.valid & (rng.random(scene.valid.shape) < 0.7)
    valid[-1, :3] = True
    other = np.where(valid[..., None], scene.history, 1e6)
    first = build_inputs(scene.history, valid, np.arange(3), None, None, PATCH)
    second = build_inputs(other, valid, np.arange(3), None, None, PATCH)
    for name in ("history", "neighbors", "last_step", "world_from_agent"):
        assert np.array_equal(getattr(first, name), getattr(second, name)), name


def test_crop_shows_what_lies_ahead_on_the_right_and_what_lies_left_on_top() -> None:
    """Red beyond y = 1, green beyond x = -1; the agent at 0, 0 walks along world +y."""
    image = np.zeros((200, 200, 3), dtype=np.uint8)
    pixel_from_world = np.array([[5.0, 0.0, 100.0], [0.0, -5.0, 100.0], [0.0, 0.0, 1.0]])
    image[:95, :, 0], image[:, :95, 1] = 255, 255
    history, valid = STRAIGHT[:, None] - STRAIGHT[-1], np.ones((8, 1), dtype=np.bool_)
    crop = build_inputs(history, valid, np.array([0]), image, pixel_from_world, PATCH).crop
    assert crop is not None
    behind_left, ahead_left = crop[0, 4, 4], crop[0, 4, 60]
    behind_right, ahead_right = crop[0, 60, 4], crop[0, 60, 60]
    assert behind_left.tolist() == [0, 255, 0]
    assert ahead_left.tolist() == [255, 255, 0]
    assert behind_right.tolist() == [0, 0, 0]
    assert ahead_right.tolist() == [255, 0, 0]
    # the agent is a quarter from the left: the red begins 1 m ahead of it
    first_red = int(np.argmax(crop[0, 40, :, 0] > 127))
    assert first_red == pytest.approx(64 / 4 + 64 / 12, abs=1)


def test_crop_obeys_the_full_homography() -> None:
    """A homography is defined up to a factor, and a tilted one is a tilted picture of the same."""
    picture = noise_picture(np.random.default_rng(3))
    history, valid = STRAIGHT[:, None] - STRAIGHT[-1], np.ones((8, 1), dtype=np.bool_)

    def crop(image: np.ndarray, pixel_from_world: np.ndarray) -> np.ndarray:
        agents = np.array([0])
        found = build_inputs(history, valid, agents, image, pixel_from_world, PATCH).crop
        assert found is not None
        return found.astype(np.int64)

    straight = crop(picture.image, picture.pixel_from_world)
    scaled = crop(picture.image, -3.0 * picture.pixel_from_world)
    assert np.array_equal(straight, scaled)
    swap = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1e-9, 1.0]])
    tilted = crop(picture.image.swapaxes(0, 1).copy(), swap @ picture.pixel_from_world)
    assert np.abs(straight - tilted).mean() < 2.0


def test_world_without_a_picture_is_marked() -> None:
    history, valid = STRAIGHT[:, None], np.ones((8, 1), dtype=np.bool_)
    inputs = inputs_of(history, valid)
    assert inputs.crop is not None
    assert not inputs.crop_valid.any()
    assert not inputs.crop.any()


def test_wrong_history_length_is_named() -> None:
    with pytest.raises(ValueError, match="8 frames, got 5"):
        inputs_of(np.zeros((5, 1, 2)), np.ones((5, 1), dtype=np.bool_))


def test_an_agent_that_is_not_there_is_refused() -> None:
    with pytest.raises(ValueError, match="last frame"):
        inputs_of(np.zeros((8, 1, 2)), np.zeros((8, 1), dtype=np.bool_))


def test_nearest_of_many_are_those_that_sorting_all_finds() -> None:
    """Also where people are equally far: they stand on a lattice, and some are not seen now."""
    rng = np.random.default_rng(4)
    lattice = np.stack(np.meshgrid(np.arange(7.0), np.arange(7.0)), axis=-1).reshape(1, -1, 2)
    history = np.repeat(lattice, 8, axis=0) + 0.001 * rng.integers(0, 2, (1, 49, 2))
    valid = rng.random((8, 49)) < 0.9
    agents = np.flatnonzero(valid[-1])
    tracks, seen = nearest(history[None], valid[None], np.zeros_like(agents), agents, 8)
    for agent, found, there in zip(agents, tracks, seen, strict=True):
        distance = np.square(history[-1] - history[-1, agent]).sum(axis=-1)
        distance[agent] = np.inf
        expected = np.sort(np.where(valid[-1], distance, np.inf))[:8]
        met = np.square(found[:, -1] - history[-1, agent]).sum(axis=-1)
        np.testing.assert_allclose(met, expected)
        assert there[:, -1].all()
