"""Scenarios and a network made for tests of the environments."""

from collections.abc import Callable

import pytest
import torch
from hand_made_scenes import set_scene

from crowdsim.scenarios import SCENARIOS
from predictor.checkpoint import save_checkpoint
from predictor.config import ModelConfig
from predictor.model import IterativeAttention


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
