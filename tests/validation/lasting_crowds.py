"""Whether crowds last as long as missions: who is there, and who moves, after so many minutes.

python tests/validation/lasting_crowds.py 1 5 30
"""

import sys
from collections.abc import Sequence

import numpy as np

from crowdsim.scenarios import SCENARIOS, make_scenario
from crowdsim.world import World

SEED = 10_000
SECOND = 20
"""Physics steps in a second."""
STEP = 0.3
"""Who gets this far in a second is on the move [m]."""


def shares(world: World, minute: int) -> tuple[float, float]:
    """Share of the people who are there after so many minutes, and of those who then move."""
    while world.step_count < 60 * SECOND * minute:
        world.step()
    there, before = world.valid, world.positions
    for _ in range(SECOND):
        world.step()
    stayed = there & world.valid
    moved = np.linalg.norm(world.positions - before, axis=1) > STEP
    return float(there.mean()), float(moved[stayed].mean())


def main(minutes: Sequence[int]) -> None:
    """Write one line per scenario, a world without a robot each."""
    for name in SCENARIOS:
        if name == "replay":
            continue
        scenario = make_scenario(name, np.random.default_rng(SEED))
        world = World(scenario, rng=np.random.default_rng(SEED))
        found = [(minute, *shares(world, minute)) for minute in minutes]
        told = (f"{minute} min {there:.2f} {moving:.2f}" for minute, there, moving in found)
        sys.stdout.write(f"{name:40} there, moving: {', '.join(told)}\n")


if __name__ == "__main__":
    main([int(argument) for argument in sys.argv[1:]])
