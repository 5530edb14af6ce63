"""Crowds and networks that the predictor's tests share."""

import numpy as np
import torch

from crowdsim.recordings import Picture, Recording
from predictor.baselines.history_mlp import HistoryMlp
from predictor.config import ModelName, Variant, named_configuration
from predictor.model import IterativeAttention
from predictor.networks import Network, build_network, configuration

BASELINES: tuple[ModelName, ...] = ("history_mlp", "lstm", "social_lstm")


def walkers(
    rng: np.random.Generator,
    people: int = 6,
    frames: int = 20,
    name: str = "walkers",
    bend: float = 0.15,
) -> Recording:
    """People who turn by up to `bend` a frame, over a picture of noise, 20 m x 20 m."""
    speed, heading = rng.uniform(0.3, 0.7, people), rng.uniform(-np.pi, np.pi, people)
    turn = rng.uniform(-bend, bend, people)
    headings = heading + turn * np.arange(frames)[:, None]
    steps = speed[:, None] * np.stack([np.cos(headings), np.sin(headings)], axis=-1)
    return Recording(
        name=name,
        positions=rng.uniform(-4.0, 4.0, (people, 2)) + np.cumsum(steps, axis=0),
        valid=np.ones((frames, people), dtype=np.bool_),
        ids=np.arange(people, dtype=np.int64),
        frames=np.arange(frames, dtype=np.int64),
        picture=noise_picture(rng),
    )


def noise_picture(rng: np.random.Generator) -> Picture:
    """Smooth colours at 5 px/m around the world's origin."""
    coarse = rng.integers(0, 256, (10, 10, 3), dtype=np.uint8)
    pixel_from_world = np.array([[5.0, 0.0, 49.5], [0.0, -5.0, 49.5], [0.0, 0.0, 1.0]])
    return Picture(np.kron(coarse, np.ones((10, 10, 1), dtype=np.uint8)), pixel_from_world)


def network(
    variant: Variant, configuration: str = "residual", seed: int = 0, loudness: float = 10.0
) -> IterativeAttention:
    """A fresh network whose decoders shout, so that no input goes unnoticed in the forecast."""
    config, _ = named_configuration(configuration, variant=variant)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        model = IterativeAttention(config)
    with torch.no_grad():
        for decoder in (model.goal_decoder, model.trajectory_decoder):
            decoder[-1].weight.mul_(loudness)
    return model.eval()


def baseline(name: ModelName, config_name: str = "residual", seed: int = 0) -> Network:
    """A fresh baseline whose last layer shouts."""
    config, _ = configuration(name, config_name)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        model = build_network(config)
    last = model.layers[-1] if isinstance(model, HistoryMlp) else model.displacement
    with torch.no_grad():
        last.weight.mul_(10.0)
    return model.eval()
