"""The same crowd without the robot, or with one that stands: what would have happened then."""

from collections.abc import Sequence

import numpy as np

from crowdsim.world import World
from envs.trace import Branch, Trace, TwinTrace


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
    steps = round((trace.duration + longer) / trace.dt)
    rows = [_row(world), *_roll(world, steps, round(trace.dt / trace.physics_dt))]
    return _twin(rows, trace.dt)


def branch_off(world: World, row: int, *, forecast_steps: int, frame_dt: float) -> Branch:
    """Rolls two forks of a running world over the horizon of a forecast.

    Args:
        world: Running world with a robot; stays as it is.
        row: Row of its trace that it has come to.
        forecast_steps: How many forecast steps to go.
        frame_dt: Time between them [s].
    """
    physics_steps = round(frame_dt / world.physics_dt)
    absent = _roll(world.without_robot(), forecast_steps, physics_steps)
    standing = _roll(world.fork(), forecast_steps, physics_steps)
    return Branch(row=row, absent=_twin(absent, frame_dt), standing=_twin(standing, frame_dt))


def _roll(world: World, count: int, physics_steps: int) -> list[Sequence[np.ndarray]]:
    """States of the crowd after so many physics steps each, a robot standing."""
    rows = []
    for _ in range(count):
        for _ in range(physics_steps):
            world.step()
        rows.append(_row(world))
    return rows


def _twin(rows: Sequence[Sequence[np.ndarray]], dt: float) -> TwinTrace:
    """The states of a crowd, `dt` apart, as a trace."""
    position, velocity, valid, ids = (np.array(column) for column in zip(*rows, strict=True))
    return TwinTrace(
        dt=dt,
        position=np.where(valid[..., None], position, 0.0),
        velocity=np.where(valid[..., None], velocity, 0.0),
        valid=valid,
        ids=ids,
    )


def _row(world: World) -> Sequence[np.ndarray]:
    return world.positions, world.velocities, world.valid, world.ids
