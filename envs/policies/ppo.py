"""A trained PPO policy as JSON and safetensors: kept, checked and loaded without pickle.

Stable-Baselines3's own files run code when they are opened. Here the folder holds

* `policy.json`: the spaces, the architecture, how it was trained, and the checksum of the weights;
* `policy.safetensors`: the weights of the actor and the critic.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray
from safetensors.torch import load, save
from stable_baselines3 import PPO
from stable_baselines3.common.policies import ActorCriticPolicy, MultiInputActorCriticPolicy

from crowdsim.recordings.store import write_atomic
from envs.config import CrowdNavConfig, make_config
from envs.observation import observation_space
from envs.policies.crowd_features import CrowdFeatures
from envs.policies.policy import Observation, Policy

DESCRIPTION = "policy.json"
WEIGHTS = "policy.safetensors"
FORMAT = "crowdnav-ppo-1"
SHARED = "features_extractor."
ALIASES = ("pi_features_extractor.", "vf_features_extractor.")
"""The actor and the critic share their features, which the network lists once for each."""

LAYERS = (64, 64)
"""Widths of the hidden layers of the actor and of the critic, where nothing else is said."""

LARGEST_LAYER = 4096
LARGEST_KEY = 1_000_000
"""Values that one observation key may hold: a damaged description must not fill the memory."""

ROW_MULTIPLE = 8
"""Float32 matrix products have bit-equal rows when their number is a multiple of this."""


def policy_keywords(layers: tuple[int, ...] = LAYERS) -> dict[str, Any]:
    """Returns the `policy_kwargs` with which `PPO("MultiInputPolicy", …)` must be made."""
    return {
        "features_extractor_class": CrowdFeatures,
        "net_arch": {"pi": list(layers), "vf": list(layers)},
        "activation_fn": torch.nn.Tanh,
    }


def save_ppo(
    model: PPO, folder: Path, *, config: CrowdNavConfig, training: Mapping[str, Any]
) -> None:
    """Writes a model made with `policy_keywords` so that `PPOPolicy` can load it.

    The description comes last and each file is written whole or not at all: a folder with a
    description holds a complete policy.

    Args:
        model: The trained model.
        folder: Where to write; made if need be.
        config: Configuration of the environment that it was trained in.
        training: What made it (steps, seed, …), for the record; JSON-able.
    """
    folder.mkdir(parents=True, exist_ok=True)
    network = model.policy
    weights = save(own_weights(network))
    description = {
        "format": FORMAT,
        "environment": dataclasses.asdict(config),
        "observation_space": {key: box_to_json(box) for key, box in _boxes(network).items()},
        "action_space": box_to_json(cast(spaces.Box, network.action_space)),
        "layers": cast(dict[str, list[int]], network.net_arch)["pi"],
        "training": dict(training),
        "sha256": hashlib.sha256(weights).hexdigest(),
    }
    write_atomic(folder / WEIGHTS, weights)
    write_atomic(folder / DESCRIPTION, (json.dumps(description, indent=2) + "\n").encode())


class PPOPolicy(Policy):
    """A policy that `save_ppo` wrote; it takes the mean of the action distribution.

    Args:
        folder: Where `save_ppo` wrote to.
        config: Configuration of the environment that it will act in; None skips the comparison
            with the one that it was trained in.

    Raises:
        ValueError: The folder holds no such policy, it is damaged, or it does not fit `config`.
    """

    name = "ppo"

    def __init__(self, folder: Path, config: CrowdNavConfig | None = None) -> None:
        self.description = read_description(folder)
        if config is not None:
            check_fits(self.description, config, folder)
        self._network = make_network(self.description)
        load_weights(self._network, folder / WEIGHTS, self.description["sha256"])

    def act_batch(self, observation: Observation) -> NDArray[np.float32]:
        """Returns (W, A) mean actions; see `Policy.act`.

        Raises:
            ValueError: A key that the policy was trained with is missing.
        """
        keys = _boxes(self._network)
        missing = sorted(set(keys) - set(observation))
        if missing:
            raise ValueError(
                f"the policy was trained with {', '.join(missing)}; "
                f"the observation has only {', '.join(observation)}"
            )
        worlds = len(observation["robot"])
        spare = -worlds % ROW_MULTIPLE
        batch = {key: _padded(observation[key], spare) for key in keys}
        actions, _ = self._network.predict(batch, deterministic=True)
        return np.asarray(actions[:worlds], np.float32)


def own_weights(network: ActorCriticPolicy) -> dict[str, torch.Tensor]:
    """Returns the weights without the second and third name of the shared features."""
    return {
        name: value.contiguous()
        for name, value in network.state_dict().items()
        if not name.startswith(ALIASES)
    }


def read_description(folder: Path) -> dict[str, Any]:
    """Returns the JSON that `save_ppo` wrote.

    Raises:
        ValueError: It is missing or is not such a description.
    """
    path = folder / DESCRIPTION
    if not path.is_file():
        raise ValueError(f"expected the folder of a trained PPO policy, found no {path}")
    try:
        description = json.loads(path.read_text())
    except ValueError as error:
        raise ValueError(f"expected JSON in {path}: {error}") from error
    found = description.get("format") if isinstance(description, dict) else None
    if found != FORMAT:
        raise ValueError(f"expected a description of format {FORMAT!r} in {path}, found {found!r}")
    return dict(description)


def make_network(description: Mapping[str, Any]) -> ActorCriticPolicy:
    """Builds the network that a description describes, with random weights.

    Raises:
        ValueError: A space or a layer is malformed or implausibly large.
    """
    layers = tuple(description["layers"])
    if not all(isinstance(width, int) and 0 < width <= LARGEST_LAYER for width in layers):
        raise ValueError(f"layers must be whole numbers up to {LARGEST_LAYER}, got {layers}")
    keys = description["observation_space"]
    return MultiInputActorCriticPolicy(
        spaces.Dict({key: box_from_json(key, box) for key, box in keys.items()}),
        box_from_json("action", description["action_space"]),
        lambda _: 0.0,  # the learning rate, which acting does not need
        **policy_keywords(layers),
    )


def load_weights(network: ActorCriticPolicy, path: Path, sha256: str) -> None:
    """Loads safetensors into a network.

    Raises:
        ValueError: The file is missing, is not the one described, or does not fit the network.
    """
    if not path.is_file():
        raise ValueError(f"expected the weights of a PPO policy, found no {path}")
    content = path.read_bytes()
    found = hashlib.sha256(content).hexdigest()
    if found != sha256:
        raise ValueError(f"{path} is damaged: expected SHA-256 {sha256}, found {found}")
    weights = load(content)
    shared = {name: value for name, value in weights.items() if name.startswith(SHARED)}
    for prefix in ALIASES:
        weights.update({prefix + name.removeprefix(SHARED): shared[name] for name in shared})
    if not all(bool(torch.isfinite(value).all()) for value in weights.values()):
        raise ValueError(f"{path} holds weights that are not finite")
    try:
        network.load_state_dict(weights)
    except RuntimeError as error:
        raise ValueError(f"{path} does not fit its description: {error}") from error


def check_fits(description: Mapping[str, Any], config: CrowdNavConfig, folder: Path) -> None:
    """Compares the environment that a policy was trained in with another.

    Raises:
        ValueError: The robot is another, or the observation has other keys or shapes.
    """
    trained = make_config(**description["environment"])
    if trained.robot != config.robot:
        raise ValueError(
            f"{folder} was trained for a {trained.robot} robot, "
            f"the environment has a {config.robot} one"
        )
    expected, found = _shapes(trained), _shapes(config)
    if expected != found:
        raise ValueError(
            f"{folder} was trained with the observation {expected}, the environment gives {found}"
        )


def box_to_json(box: spaces.Box) -> dict[str, Any]:
    """Returns shape, dtype and bounds; a bound that is the same everywhere becomes one number."""

    def bound(values: NDArray[Any]) -> Any:
        return values.flat[0].item() if (values == values.flat[0]).all() else values.tolist()

    return {
        "shape": list(box.shape),
        "dtype": str(box.dtype),
        "low": bound(box.low),
        "high": bound(box.high),
    }


def box_from_json(name: str, description: Mapping[str, Any]) -> spaces.Box:
    """Returns the Box that `box_to_json` described.

    Raises:
        ValueError: It is malformed or implausibly large.
    """
    try:
        shape = tuple(int(length) for length in description["shape"])
        if not 0 < math.prod(shape) <= LARGEST_KEY:
            raise ValueError(f"shape {shape} is empty or larger than {LARGEST_KEY} values")
        dtype = np.dtype(description["dtype"]).type
        low, high = (np.broadcast_to(description[key], shape) for key in ("low", "high"))
        return spaces.Box(low.astype(dtype), high.astype(dtype), dtype=dtype)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"the space {name!r} of the policy is malformed: {error}") from error


def _boxes(network: ActorCriticPolicy) -> dict[str, Any]:
    """Returns the Box of every key that the network takes."""
    return dict(network.observation_space.items())  # type: ignore[attr-defined]


def _shapes(config: CrowdNavConfig) -> dict[str, tuple[int, ...] | None]:
    return {key: box.shape for key, box in observation_space(config).items()}


def _padded(values: NDArray[Any], rows: int) -> NDArray[Any]:
    return np.concatenate((values, np.zeros((rows, *values.shape[1:]), values.dtype)))
