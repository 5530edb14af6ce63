"""A trained policy as JSON and safetensors: kept, checked and loaded without pickle.

Stable-Baselines3's own files run code when they are opened. Here the folder holds

* `policy.json`: the algorithm, the spaces, the network's keywords, how it was trained, and the
  checksum of the weights;
* `policy.safetensors`: the weights of the actor, for `ppo` and `recurrent_ppo` also of the critic.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, cast

import torch
from gymnasium import spaces
from safetensors.torch import load, save
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import BasePolicy
from torch import nn

from crowdsim.recordings.store import write_atomic
from envs.config import CrowdNavConfig, make_config
from envs.observation import observation_space
from envs.policies.networks import ALGORITHMS
from envs.policies.space_json import box_from_json, box_to_json

DESCRIPTION: Final = "policy.json"
WEIGHTS: Final = "policy.safetensors"
FORMAT: Final = "crowdnav-policy-1"

KEYS: Final = {
    "algorithm",
    "network",
    "environment",
    "observation_space",
    "action_space",
    "sha256",
}
"""What a description must hold to be loaded."""

LARGEST_NUMBER: Final = 4096
"""Width of a layer that a network may have: a damaged description must not fill the memory."""


def save_policy(
    model: BaseAlgorithm, folder: Path, *, config: CrowdNavConfig, training: Mapping[str, Any]
) -> None:
    """Writes a model whose network is of `envs.policies.networks`, for `LearnedPolicy` to load.

    The description comes last and each file is written whole or not at all: a folder with a
    description holds a complete policy.

    Args:
        model: The trained model.
        folder: Where to write; made if need be.
        config: Configuration of the environment that it was trained in.
        training: What made it (steps, seed, …), for the record; JSON-able.

    Raises:
        ValueError: The network is another.
        TypeError: `policy_kwargs` of the model or `training` do not fit into JSON.
    """
    network = model.policy
    algorithm = _algorithm_of(network)
    weights = save(own_weights(acting_part(network, algorithm)))
    description = {
        "format": FORMAT,
        "algorithm": algorithm,
        "network": dict(model.policy_kwargs),
        "environment": dataclasses.asdict(config),
        "observation_space": {key: box_to_json(box) for key, box in boxes(network).items()},
        "action_space": box_to_json(cast(spaces.Box, network.action_space)),
        "training": dict(training),
        "sha256": hashlib.sha256(weights).hexdigest(),
    }
    text = json.dumps(description, indent=2, allow_nan=False) + "\n"
    folder.mkdir(parents=True, exist_ok=True)
    write_atomic(folder / WEIGHTS, weights)
    write_atomic(folder / DESCRIPTION, text.encode())


def read_description(folder: Path) -> dict[str, Any]:
    """Returns the JSON that `save_policy` wrote.

    Raises:
        ValueError: It is missing or is not such a description.
    """
    path = folder / DESCRIPTION
    if not path.is_file():
        raise ValueError(f"expected the folder of a trained policy, found no {path}")
    try:
        description = json.loads(path.read_text())
    except ValueError as error:
        raise ValueError(f"expected JSON in {path}: {error}") from error
    found = description.get("format") if isinstance(description, dict) else None
    if found != FORMAT:
        raise ValueError(f"expected a description of format {FORMAT!r} in {path}, found {found!r}")
    missing = sorted(KEYS - description.keys())
    if missing:
        raise ValueError(f"expected {', '.join(missing)} in {path}")
    if description["algorithm"] not in ALGORITHMS:
        raise ValueError(
            f"expected one of {', '.join(ALGORITHMS)} as the algorithm in {path}, "
            f"found {description['algorithm']!r}"
        )
    return dict(description)


def load_weights(network: BasePolicy, folder: Path, description: Mapping[str, Any]) -> None:
    """Loads the weights of a policy into a network; what was not stored stays as it is.

    Raises:
        ValueError: The weights are missing, not the ones described, not finite, or of another
            network.
    """
    path = folder / WEIGHTS
    weights = read_weights(path, description["sha256"])
    part = acting_part(network, description["algorithm"])
    expected = own_weights(part)
    if weights.keys() != expected.keys():
        differing = ", ".join(sorted(weights.keys() ^ expected.keys()))
        raise ValueError(f"{path} does not fit the network: {differing}")
    try:
        part.load_state_dict(weights, strict=False)  # other names of the same weights are missing
    except RuntimeError as error:
        raise ValueError(f"{path} does not fit the network: {error}") from error


def make_network(description: Mapping[str, Any]) -> BasePolicy:
    """Builds the network that a description describes, with random weights.

    Raises:
        ValueError: A space or the network is malformed or implausibly large.
    """
    keywords = description["network"]
    if not _plausible(keywords):
        raise ValueError(f"network must have numbers up to {LARGEST_NUMBER}, got {keywords}")
    keys = description["observation_space"]
    observed = spaces.Dict({key: box_from_json(key, box) for key, box in keys.items()})
    action = box_from_json("action", description["action_space"])
    network: Any = ALGORITHMS[description["algorithm"]].network
    try:
        # Acting does not need the third argument, the learning rate.
        return cast(BasePolicy, network(observed, action, lambda _: 0.0, **keywords))
    except (KeyError, TypeError, AttributeError, AssertionError, RuntimeError) as error:
        raise ValueError(f"the network {keywords} of the policy is malformed: {error}") from error


def read_weights(path: Path, sha256: str) -> dict[str, torch.Tensor]:
    """Reads safetensors of a known checksum.

    Raises:
        ValueError: The file is missing, is not the one described, or holds weights that are not
            finite.
    """
    if not path.is_file():
        raise ValueError(f"expected the weights of a policy, found no {path}")
    content = path.read_bytes()
    found = hashlib.sha256(content).hexdigest()
    if found != sha256:
        raise ValueError(f"{path} is damaged: expected SHA-256 {sha256}, found {found}")
    weights: dict[str, torch.Tensor] = load(content)
    if not all(bool(torch.isfinite(value).all()) for value in weights.values()):
        raise ValueError(f"{path} holds weights that are not finite")
    return weights


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


def acting_part(network: BasePolicy, algorithm: str) -> nn.Module:
    """Returns the part of a network that is kept."""
    return network.get_submodule(ALGORITHMS[algorithm].actor)


def own_weights(network: nn.Module) -> dict[str, torch.Tensor]:
    """Returns the state without the second and third names of weights that parts share."""
    own = dict(network.named_parameters()) | dict(network.named_buffers())
    state = network.state_dict()
    return {name: value.contiguous() for name, value in state.items() if name in own}


def boxes(network: BasePolicy) -> dict[str, spaces.Box]:
    """Returns the Box of every key that the network takes."""
    return dict(cast(Any, network.observation_space).items())


def _algorithm_of(network: BasePolicy) -> str:
    for name, algorithm in ALGORITHMS.items():
        if type(network) is algorithm.network:
            return name
    known = ", ".join(algorithm.network.__name__ for algorithm in ALGORITHMS.values())
    raise ValueError(f"expected a network of {known}, found {type(network).__name__}")


def _plausible(value: Any) -> bool:
    """Whether all numbers in a piece of JSON could belong to a network."""
    if isinstance(value, dict):
        return all(_plausible(each) for each in value.values())
    if isinstance(value, list):
        return all(_plausible(each) for each in value)
    return value is None or isinstance(value, str) or abs(value) <= LARGEST_NUMBER


def _shapes(config: CrowdNavConfig) -> dict[str, tuple[int, ...] | None]:
    return {key: box.shape for key, box in observation_space(config).items()}
