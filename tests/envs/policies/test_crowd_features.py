import numpy as np
import pytest
import torch
from hand_made_observations import add_person, empty_observation, stack

from envs.config import CrowdNavConfig
from envs.observation import observation_space
from envs.policies.crowd_features import CrowdFeatures

CONFIG = CrowdNavConfig(pedestrians_observed=4, modes_observed=2)
OF_PEOPLE = (
    "history",
    "history_valid",
    "neighbors_radius",
    "forecast",
    "forecast_radius",
    "forecast_modes",
    "forecast_probabilities",
)


@pytest.fixture
def features():
    torch.manual_seed(0)
    return CrowdFeatures(observation_space(CONFIG))


def crowd(people, config=CONFIG, worlds=5):
    """Observations of so many people in the first places, every one of whose keys is filled."""
    rng = np.random.default_rng(0)
    observations = []
    for _ in range(worlds):
        one = empty_observation(config, goal=rng.uniform(-8, 8, 2))
        one["lidar"][:] = rng.uniform(1.0, 8.0, one["lidar"].shape)
        for place in range(people):
            add_person(one, config, place, rng.uniform(-4, 4, 2), rng.uniform(-1, 1, 2))
            for key in ("forecast_radius", "forecast_modes", "forecast_probabilities"):
                if key in one:
                    one[key][place] = rng.uniform(0.1, 1.0, one[key][place].shape)
        observations.append(one)
    return {key: torch.as_tensor(values) for key, values in stack(observations).items()}


def test_the_order_of_people_does_not_matter(features):
    observation = crowd(4)
    shuffled = {
        key: values[:, [3, 1, 0, 2]] if key in OF_PEOPLE else values
        for key, values in observation.items()
    }
    torch.testing.assert_close(features(shuffled), features(observation))


def test_an_empty_crowd_gives_finite_features_and_gradients(features):
    result = features(crowd(0))
    result.sum().backward()
    assert torch.isfinite(result).all()
    assert all(torch.isfinite(weights.grad).all() for weights in features.parameters())


@pytest.mark.parametrize("key", OF_PEOPLE)
def test_what_stands_in_empty_places_is_not_looked_at(features, key):
    observation = crowd(3)
    expected = features(observation)
    observation[key][:, 3] = 7.0
    torch.testing.assert_close(features(observation), expected, rtol=0.0, atol=0.0)


@pytest.mark.parametrize("key", sorted(observation_space(CONFIG)))
def test_every_key_matters(features, key):
    observation = crowd(3)
    before = features(observation)
    # All that there is changes sign, place or size: a person goes, a radius grows.
    observation[key] = 0.5 * observation[key]
    assert (features(observation) - before).abs().amax() > 1e-4


def test_a_crowd_is_more_than_its_nearest_person(features):
    one, two = crowd(1), crowd(2)
    assert (features(one) - features(two)).abs().amax() > 1e-3


@pytest.mark.parametrize(
    "config",
    [
        CONFIG,
        CrowdNavConfig(forecaster="none"),
        CrowdNavConfig(forecaster="none", history_steps=1, pedestrians_observed=1, lidar_rays=1),
    ],
)
def test_gradients_reach_all_weights(config):
    features = CrowdFeatures(observation_space(config))
    (features(crowd(1, config)) ** 2).sum().backward()
    idle = [name for name, weights in features.named_parameters() if not weights.grad.any()]
    assert not idle
