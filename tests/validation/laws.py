"""The laws between people on one circle: how long people need, and how near they come.

python tests/validation/laws.py
"""

import sys

import numpy as np

from crowdsim.forces import ELLIPTICAL, MOUSSAID_2009, SocialForce
from crowdsim.scenarios import make_scenario
from crowdsim.world import World

LAWS = {"circular": SocialForce(), "elliptical": ELLIPTICAL, "moussaid_2009": MOUSSAID_2009}
SEEDS = range(5)
STEPS = 600
THERE = 0.8  # who is this near to the goal has arrived [m]
TOUCHING = 0.01  # gap between people who touch, or as good as [m]


def crossing(law, seed):
    """Arrival times `(N,)` over those of an unhindered walk, NaN for none; gaps `(T, P)` [m]."""
    start = make_scenario("circular_crossing", np.random.default_rng(seed), on_arrival="stop")
    people = start.pedestrians
    world = World(start, rng=np.random.default_rng(seed), social_force=law)
    goal = people.waypoints[:, -1]
    unhindered = (np.linalg.norm(goal - people.position, axis=1) - THERE) / people.desired_speed
    i, j = np.triu_indices(len(people), 1)
    arrived, gaps = np.full(len(people), np.nan), []
    for _ in range(STEPS):
        world.step()
        place = world.positions
        there = np.linalg.norm(goal - place, axis=1) < THERE
        arrived[there & np.isnan(arrived)] = world.time
        gaps.append(
            np.linalg.norm(place[i] - place[j], axis=1) - people.radius[i] - people.radius[j]
        )
    return arrived / unhindered, np.array(gaps)


if __name__ == "__main__":
    for name, law in LAWS.items():
        runs = [crossing(law, seed) for seed in SEEDS]
        times, gaps = (np.concatenate(part) for part in zip(*runs, strict=True))
        sys.stdout.write(
            f"{name}: time {np.nanmean(times):.2f}, deepest overlap {-1000 * gaps.min():.0f} mm, "
            f"{np.isnan(times).sum()} of {len(times)} did not arrive, "
            f"{(gaps < TOUCHING).sum() / len(gaps):.2f} of {gaps.shape[1]} pairs touch\n"
        )
