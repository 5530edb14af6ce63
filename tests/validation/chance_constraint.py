"""What it gives MPPI to keep clear of people by how sure their forecasts are, on paired seeds.

python tests/validation/chance_constraint.py constant_velocity circular_crossing 200
"""

import sys

import gymnasium
import numpy as np

from envs.config import CrowdNavConfig
from envs.evaluation.statistics import agresti_min
from envs.policies import MPPIParameters, MPPIPolicy
from envs.policies.rollouts import Costs

WIDTH = 20


def outcomes(config: CrowdNavConfig, chance: float, episodes: int) -> np.ndarray:
    """How the episodes of the seeds from 0 on end (`termination_reason`)."""
    policy = MPPIPolicy(config, MPPIParameters(costs=Costs(chance=chance)))
    keywords = {"scenario": config.scenario, "forecaster": config.forecaster}
    env = gymnasium.make_vec("envs:crowdnav/CrowdNav-v0", num_envs=WIDTH, **keywords)
    reasons = np.full(episodes, None, dtype=object)
    for first in range(0, episodes, WIDTH):
        policy.reset()
        observation, _ = env.reset(seed=first)
        while (running := np.equal(reasons[first : first + WIDTH], None)).any():
            observation, _, terminated, truncated, info = env.step(policy.act(observation))
            ended = terminated | truncated
            policy.reset(ended)
            for world in np.flatnonzero(ended & running):
                reasons[first + world] = info["final_info"]["termination_reason"][world]
    return reasons


def main(forecaster: str, scenario: str, episodes: int) -> None:
    """Print success and collisions without and with the constraint, and the paired differences."""
    config = CrowdNavConfig(scenario=scenario, forecaster=forecaster)
    without = outcomes(config, 0.0, episodes)
    with_it = outcomes(config, MPPIParameters().costs.chance, episodes)
    for reason in ("goal", "collision_pedestrian"):
        before, after = np.equal(without, reason), np.equal(with_it, reason)
        change = agresti_min(int((after & ~before).sum()), int((before & ~after).sum()), episodes)
        sys.stdout.write(
            f"{reason}: {before.mean():.3f} -> {after.mean():.3f}, "
            f"{change.mean:+.3f} [{change.low:+.3f}, {change.high:+.3f}], n={episodes}\n"
        )


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
