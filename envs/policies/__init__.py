"""Robot policies. They act on observations alone and load without the simulator."""

from __future__ import annotations

from pathlib import Path

from envs.config import CrowdNavConfig
from envs.policies.bundled import bundled_policy
from envs.policies.dwa import DWAPolicy
from envs.policies.mppi import MPPIParameters, MPPIPolicy
from envs.policies.orca import ORCAPolicy
from envs.policies.policy import Observation, Policy
from envs.policies.social_force import SocialForcePolicy
from envs.policies.straight import StraightPolicy

__all__ = [
    "DWAPolicy",
    "MPPIParameters",
    "MPPIPolicy",
    "ORCAPolicy",
    "Observation",
    "Policy",
    "SocialForcePolicy",
    "StraightPolicy",
    "make_policy",
]

SIMPLE = {
    policy.name: policy
    for policy in (StraightPolicy, SocialForcePolicy, ORCAPolicy, DWAPolicy, MPPIPolicy)
}
"""Policies that are made from a configuration alone, by name."""


def make_policy(spec: str, config: CrowdNavConfig) -> Policy:
    """Makes the policy that `spec` names, for the robot and clocks of `config`.

    Args:
        spec: `straight`, `social_force`, `orca`, `dwa`, `mppi`, `mppi@SECONDS` (planning that far
            ahead instead of 4.8 s), `ppo` or `ppo@SEED` (one that comes with the package, trained
            with the forecaster of `config`), or the folder of a trained policy.
        config: Configuration of the environment that the policy will act in.

    Raises:
        ValueError: `spec` is neither a known name nor such a folder.
    """
    if spec in SIMPLE:
        return SIMPLE[spec](config)
    name, at, seconds = spec.partition("@")
    if at and name == "mppi":
        return MPPIPolicy(config, MPPIParameters(horizon=_seconds(seconds)))
    if name == "ppo":
        return _learned(bundled_policy(spec, str(config.forecaster)), config)
    if Path(spec).is_dir():
        return _learned(Path(spec), config)
    raise ValueError(
        f"unknown policy {spec!r}; known are {', '.join(SIMPLE)}, mppi@SECONDS, "
        "ppo, ppo@SEED, or the folder of a trained policy"
    )


def _learned(folder: Path, config: CrowdNavConfig) -> Policy:
    # Torch and Stable-Baselines3 take seconds to import; the other policies need neither.
    from envs.policies.learned import LearnedPolicy

    return LearnedPolicy(folder, config)


def _seconds(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"mppi@SECONDS needs a number of seconds, got {text!r}") from None
