"""Robot policies. They act on observations alone and load without the simulator."""

from __future__ import annotations

from pathlib import Path

from envs.config import CrowdNavConfig
from envs.policies.mppi import MPPIParameters, MPPIPolicy
from envs.policies.policy import Observation, Policy
from envs.policies.straight import StraightPolicy

__all__ = ["MPPIParameters", "MPPIPolicy", "Observation", "Policy", "StraightPolicy", "make_policy"]


def make_policy(spec: str, config: CrowdNavConfig) -> Policy:
    """Makes the policy that `spec` names, for the robot and clocks of `config`.

    Args:
        spec: `straight`, `mppi`, `mppi@SECONDS` (planning that far ahead instead of 4.8 s), or
            the folder of a trained PPO policy.
        config: Configuration of the environment that the policy will act in.

    Raises:
        ValueError: `spec` is neither a known name nor such a folder.
    """
    if spec == "straight":
        return StraightPolicy(config)
    name, at, seconds = spec.partition("@")
    if name == "mppi":
        return MPPIPolicy(config, MPPIParameters(horizon=_seconds(seconds)) if at else None)
    if Path(spec).is_dir():
        # Torch and Stable-Baselines3 take seconds to import; the other policies need neither.
        from envs.policies.ppo import PPOPolicy

        return PPOPolicy(Path(spec), config)
    raise ValueError(
        f"unknown policy {spec!r}; known are straight, mppi, mppi@SECONDS, "
        "or the folder of a trained PPO policy"
    )


def _seconds(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"mppi@SECONDS needs a number of seconds, got {text!r}") from None
