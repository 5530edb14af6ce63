"""Fixtures of the predictor's tests."""

import pytest
import torch
from hand_made_crowds import BASELINES

from predictor.config import CONFIGURATIONS, ModelName, Variant


@pytest.fixture(scope="session", autouse=True)
def _one_thread() -> None:
    torch.set_num_threads(1)


@pytest.fixture(params=["none", "patch"])
def variant(request: pytest.FixtureRequest) -> Variant:
    return request.param


@pytest.fixture(params=sorted(CONFIGURATIONS))
def configuration(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(params=BASELINES)
def baseline_name(request: pytest.FixtureRequest) -> ModelName:
    return request.param
