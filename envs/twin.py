"""The same crowd without the robot: what would have happened had it not been there."""

import numpy as np

from crowdsim.world import World
from envs.trace import Trace, TwinTrace


def run_twin(trace: Trace, *, longer: float = 0.0) -> TwinTrace:
    """Runs the world of an episode again, from the same draws, without the robot.

    Args:
        trace: The episode.
        longer: How far to go on after the episode's end [s].

    Returns:
        The crowd at the clock of `trace`; people are in the same columns.
    """
    seed = np.random.SeedSequence(trace.world_seed.entropy, spawn_key=trace.world_seed.spawn_key)
    world = World(
        trace.scenario, rng=np.random.default_rng(seed), physics_dt=trace.physics_dt, robot=None
    )
    rows = [_row(world)]
    for _ in range(round((trace.duration + longer) / trace.dt)):
        for _ in range(round(trace.dt / trace.physics_dt)):
            world.step()
        rows.append(_row(world))
    position, velocity, valid, ids = (np.array(column) for column in zip(*rows, strict=True))
    return TwinTrace(
        dt=trace.dt,
        position=np.where(valid[..., None], position, 0.0),
        velocity=np.where(valid[..., None], velocity, 0.0),
        valid=valid,
        ids=ids,
    )


def _row(world: World) -> tuple[np.ndarray, ...]:
    return world.positions, world.velocities, world.valid, world.ids
