import json

import gymnasium
import numpy as np
import pytest
from hand_made_observations import add_person, empty_observation, stack
from stable_baselines3 import PPO

from envs.config import CrowdNavConfig
from envs.observation import observation_space
from envs.policies import make_policy
from envs.policies.learned import LearnedPolicy
from envs.policies.networks import ALGORITHMS
from envs.policies.policy_files import DESCRIPTION, WEIGHTS, save_policy
from envs.policies.space_json import box_from_json
from envs.robots import action_space

CONFIG = CrowdNavConfig(pedestrians_observed=3)
MAP_CONFIG = CrowdNavConfig(pedestrians_observed=3, forecaster="none", observe_map=True)
NETWORKS = {
    "ppo": {"net_arch": {"pi": [16, 16], "vf": [16]}, "log_std_init": -0.5},
    "recurrent_ppo": {"net_arch": [16], "lstm_hidden_size": 24},
    "sac": {"net_arch": [16, 16]},
    "tqc": {"net_arch": [16], "n_quantiles": 5},
}


class Standstill(gymnasium.Env):
    """Spaces of the environment, and nothing behind them."""

    def __init__(self, config):
        self.observation_space = observation_space(config)
        self.action_space = action_space(config)


def untrained(config, algorithm="ppo"):
    chosen = ALGORITHMS[algorithm]
    smallest = {"buffer_size": 1} if chosen.actor else {"n_steps": 8, "batch_size": 8}
    keywords = smallest | {"policy_kwargs": NETWORKS[algorithm]}
    return chosen.model(chosen.network, Standstill(config), seed=0, device="cpu", **keywords)


def random_observations(config, count, seed=0):
    rng = np.random.default_rng(seed)
    observations = []
    for _ in range(count):
        one = empty_observation(config, goal=rng.uniform(-8, 8, 2))
        for slot in range(2):
            add_person(one, config, slot, rng.uniform(-4, 4, 2), rng.uniform(-1, 1, 2))
        if "map" in one:
            one["map"][:] = rng.integers(0, 256, one["map"].shape)
        observations.append(one)
    return stack(observations)


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    paths = {name: tmp_path_factory.mktemp(name) for name in ALGORITHMS}
    for name, path in paths.items():
        save_policy(untrained(CONFIG, name), path, config=CONFIG, training={"steps": 0})
    return paths


@pytest.fixture(params=ALGORITHMS)
def folder(request, folders):
    return folders[request.param]


@pytest.mark.parametrize("config", [CONFIG, MAP_CONFIG], ids=["forecast", "map"])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_saved_policy_acts_as_the_model_did(tmp_path, algorithm, config):
    model = untrained(config, algorithm)
    save_policy(model, tmp_path, config=config, training={})
    policy, state = make_policy(str(tmp_path), config), None
    assert policy.name == algorithm
    for seed in range(3):
        observations = random_observations(config, 8, seed)
        expected, state = model.predict(observations, state=state, deterministic=True)
        actions = policy.act(observations)
        assert np.ptp(actions) > 0.0
        np.testing.assert_array_equal(actions, expected)


def test_only_the_actor_of_sac_is_kept(folders):
    model = untrained(CONFIG, "sac")
    stored = (folders["sac"] / WEIGHTS).stat().st_size
    actor = sum(4 * weights.numel() for weights in model.actor.parameters())
    assert actor < stored < 1.5 * actor


def test_actions_do_not_depend_on_how_many_worlds_are_shown(folder):
    together, steps = LearnedPolicy(folder), [random_observations(CONFIG, 11, s) for s in range(3)]
    batches = [together.act(observations) for observations in steps]
    for world in range(11):
        alone = LearnedPolicy(folder)
        for observations, batch in zip(steps, batches, strict=True):
            single = {key: value[world] for key, value in observations.items()}
            np.testing.assert_array_equal(alone.act(single), batch[world])


def test_a_recurrent_policy_remembers_and_forgets_each_world_by_itself(folders):
    policy, observations = LearnedPolicy(folders["recurrent_ppo"]), random_observations(CONFIG, 3)
    first, second = policy.act(observations), policy.act(observations)
    assert (first != second).any(axis=1).all()
    policy.reset(np.array([False, True, False]))
    third = policy.act(observations)
    np.testing.assert_array_equal(third[1], first[1])
    assert (third[[0, 2]] != first[[0, 2]]).any(axis=1).all()
    policy.reset()
    np.testing.assert_array_equal(policy.act(observations), first)


def test_the_order_of_people_does_not_matter(folder):
    policy, observations = LearnedPolicy(folder), random_observations(CONFIG, 4)
    people = [key for key in observations if key.startswith(("history", "forecast", "neighbors"))]
    shuffled = observations | {key: observations[key][:, [2, 1, 0]] for key in people}
    expected = policy.act(observations)
    policy.reset()
    np.testing.assert_allclose(policy.act(shuffled), expected, atol=1e-6)


def test_a_place_without_people_gives_finite_actions(folder):
    assert np.isfinite(LearnedPolicy(folder).act(empty_observation(CONFIG))).all()


@pytest.fixture
def copy(folder, tmp_path):
    for name in (DESCRIPTION, WEIGHTS):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    return tmp_path


def test_damaged_weights_are_refused(copy):
    weights = bytearray((copy / WEIGHTS).read_bytes())
    weights[-7] ^= 1
    (copy / WEIGHTS).write_bytes(weights)
    with pytest.raises(ValueError, match="damaged: expected SHA-256"):
        LearnedPolicy(copy)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("format", "other", "crowdnav-policy"),
        ("algorithm", "other", "recurrent_ppo"),
        ("network", {"net_arch": [7, 7]}, "does not fit"),
        ("network", {"net_arch": [10**9]}, "numbers up to"),
        ("network", {"layers": [64]}, "malformed"),
        ("network", {"net_arch": "wide"}, "malformed"),
        ("network", [64, 64], "malformed"),
        ("action_space", {"shape": [2]}, "malformed"),
    ],
)
def test_a_wrong_description_is_refused(copy, key, value, message):
    description = json.loads((copy / DESCRIPTION).read_text())
    (copy / DESCRIPTION).write_text(json.dumps(description | {key: value}))
    with pytest.raises(ValueError, match=message):
        LearnedPolicy(copy)


def test_an_incomplete_description_is_refused(copy):
    description = json.loads((copy / DESCRIPTION).read_text())
    del description["action_space"]
    (copy / DESCRIPTION).write_text(json.dumps(description))
    with pytest.raises(ValueError, match="expected action_space in"):
        LearnedPolicy(copy)


def test_the_weights_of_another_algorithm_are_refused(folders, tmp_path):
    description = json.loads((folders["sac"] / DESCRIPTION).read_text())
    (tmp_path / WEIGHTS).write_bytes((folders["sac"] / WEIGHTS).read_bytes())
    (tmp_path / DESCRIPTION).write_text(
        json.dumps(description | {"algorithm": "ppo", "network": NETWORKS["ppo"]})
    )
    with pytest.raises(ValueError, match="does not fit"):
        LearnedPolicy(tmp_path)


def test_a_network_without_the_features_is_not_stored(tmp_path):
    model = PPO("MultiInputPolicy", Standstill(CONFIG), n_steps=8, batch_size=8, device="cpu")
    with pytest.raises(ValueError, match="found MultiInputActorCriticPolicy"):
        save_policy(model, tmp_path, config=CONFIG, training={})


def test_an_implausibly_large_space_is_refused_before_it_is_allocated():
    with pytest.raises(ValueError, match="larger than"):
        box_from_json("history", {"shape": [10**6] * 2, "dtype": "float32", "low": 0, "high": 1})


@pytest.mark.parametrize(
    "config",
    [
        CrowdNavConfig(pedestrians_observed=3, robot="holonomic"),
        CrowdNavConfig(pedestrians_observed=3, forecaster="none"),
        CrowdNavConfig(pedestrians_observed=3, horizon=9.6),
    ],
)
def test_a_policy_is_refused_where_it_does_not_fit(folders, config):
    with pytest.raises(ValueError, match="was trained"):
        make_policy(str(folders["ppo"]), config)


@pytest.fixture
def bundled(folders, tmp_path, monkeypatch):
    """One policy that comes with the package: constant velocity, training seed 2."""
    (tmp_path / "ppo").mkdir()
    (tmp_path / "ppo" / "constant_velocity-2").symlink_to(folders["ppo"])
    monkeypatch.setattr("envs.policies.bundled.BUNDLED", tmp_path)


@pytest.mark.usefixtures("bundled")
def test_a_bundled_policy_goes_by_its_name_and_the_forecaster():
    config = CrowdNavConfig(pedestrians_observed=3, forecaster="constant_velocity")
    assert make_policy("ppo@2", config).name == "ppo"


@pytest.mark.usefixtures("bundled")
@pytest.mark.parametrize(("spec", "wanted"), [("ppo", "fast-0"), ("ppo@2", "fast-2")])
def test_a_policy_that_is_not_bundled_says_which_are(spec, wanted):
    with pytest.raises(ValueError, match=f"bundled policy {wanted} .* constant_velocity-2"):
        make_policy(spec, CONFIG)


def test_a_missing_key_is_named(folders):
    observation = empty_observation(CONFIG)
    del observation["forecast"]
    with pytest.raises(ValueError, match="trained with forecast"):
        LearnedPolicy(folders["ppo"]).act(observation)
