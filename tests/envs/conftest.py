"""Scenarios and a network made for tests of the environments."""

from collections.abc import Callable

import numpy as np
import pytest
import torch

from crowdsim.map import Map
from crowdsim.pedestrians import Pedestrians
from crowdsim.scenario import Scenario
from crowdsim.scenarios import SCENARIOS
from predictor.checkpoint import save_checkpoint
from predictor.config import ModelConfig
from predictor.model import IterativeAttention

OPEN_GROUND = Map(bounds=(-20.0, -20.0, 20.0, 20.0))


@pytest.fixture(scope="session")
def checkpoint(tmp_path_factory: pytest.TempPathFactory) -> str:
    """An untrained network with a map: its forecasts are odd, but depend on all it is given."""
    path = tmp_path_factory.mktemp("network") / "untrained.safetensors"
    with torch.random.fork_rng():
        torch.manual_seed(0)
        model = IterativeAttention(ModelConfig(variant="patch", blocks=1, crop_px=32))
    save_checkpoint(path, model, {})
    return str(path)


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    """Registers a scenario set by hand and returns its name."""

    def register(**changes: object) -> str:
        monkeypatch.setitem(SCENARIOS, "by_hand", lambda rng: set_scene(rng, **changes))
        return "by_hand"

    return register


def set_scene(
    rng: np.random.Generator,
    *,
    people: object = (),
    goals: object = None,
    speed: float = 1.0,
    ground: Map = OPEN_GROUND,
    robot: tuple[float, float, float] = (0.0, 0.0, 0.0),
    goal: tuple[float, float] = (8.0, 0.0),
    time_limit: float = 10.0,
) -> Scenario:
    """People at `people` (N, 2) who walk to `goals` (N, 2), or stand, and a robot."""
    start = np.array(people, dtype=np.float64).reshape(-1, 2)
    stands = goals is None
    return Scenario(
        name="by_hand",
        map=ground,
        pedestrians=Pedestrians.draw(
            rng,
            position=start,
            waypoints=start if stands else np.array(goals, dtype=np.float64).reshape(-1, 2),
            desired_speed=0.0 if stands else speed,
            radius=0.25,
        ),
        robot_start=robot,
        robot_goal=goal,
        time_limit=time_limit,
    )
