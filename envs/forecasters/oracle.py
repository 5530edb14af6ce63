"""Forecasts that are right: the simulator itself, run ahead. The upper bound, and how far below.

What a robot could know at best: everybody's goals, whims and reactions, and that of all to the
robot as it would move under the command that it has now. Only the robot's own later commands are
unknown, so that the oracle errs by what they change.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from crowdsim.world import World
from envs.config import CrowdNavConfig
from envs.forecasters.situation import Floats, Situation, WorldForecast
from envs.robots import Robot, RobotState
from predictor.calibration import SIGMAS

NOISY_ORACLE = "oracle_noisy"


class Oracle:
    """Forks every world and runs the forks over the horizon."""

    def __init__(self, config: CrowdNavConfig):
        self._config = config
        self._forks: dict[int, tuple[World, World]] = {}

    def restart(self, world: int, rng: np.random.Generator) -> None:
        """Forgets the fork of the last episode."""
        self._forks.pop(world, None)

    def forecast(self, situation: Situation) -> WorldForecast:
        """Looks ahead, without any doubt; who leaves the scene stays where that happens."""
        config, frames = self._config, self._config.forecast_steps
        indices = situation.indices.tolist()
        forks = [self._fork(world, situation.worlds.running(world)) for world in indices]
        followed = [Followed(fork) for fork in forks]
        state = situation.worlds.robots.rows(situation.indices)
        forecast = np.zeros((len(forks), frames, situation.select.shape[1], 2))
        for frame in range(frames):
            for _ in range(config.policy_steps_per_frame):
                self._drive(forks, situation.robot, state)
            for row, people in enumerate(followed):
                forecast[row, frame, : people.count] = people.positions()
        return WorldForecast(position=forecast, radius=np.zeros((config.history_steps, frames)))

    def _drive(self, forks: Sequence[World], robot: Robot, state: RobotState) -> None:
        """Runs the forks over one policy period in the steps in which worlds run, to the bit."""
        config = self._config
        velocities = robot.drive(state, config.physics_dt, config.physics_steps)
        for row, fork in enumerate(forks):
            state.velocity[row] = fork.run(velocities[row]).states[-1, -1, 2:]

    def _fork(self, world: int, running: World) -> World:
        """A fork in the state of `running`; to restore one is quicker than to build one."""
        known = self._forks.get(world)
        if known is not None and known[0] is running:
            known[1].restore(running.snapshot())
            return known[1]
        fork = running.fork()
        self._forks[world] = running, fork
        return fork


class Followed:
    """The N people who are in a world now, until they leave it.

    Attributes:
        count: N.
    """

    def __init__(self, world: World):
        self._world = world
        self._ids, self._present, self._position = world.ids, world.valid, world.positions
        self.count = len(self._ids)

    def positions(self) -> Floats:
        """Returns where they are by now, or were last (N, 2) [m]; 0 for who never was there."""
        # A new id is somebody else: the one who was there has left.
        self._present &= self._world.valid & (self._world.ids == self._ids)
        here = self._present[:, None]
        self._position = np.where(here, self._world.positions, self._position)
        return np.where(np.isfinite(self._position), self._position, 0.0)


@dataclass(frozen=True, kw_only=True)
class Blur:
    """By how much a noisy oracle is wrong; all zero is none.

    Attributes:
        sigma: Standard deviation of either coordinate at the end of the horizon [m]; the error of
            each forecast grows evenly from 0 now.
        delay: How late the forecasts come [s]: they tell where people are that much earlier.
        drop: Share of the people who are forecast to stand still, drawn anew every time.

    Raises:
        ValueError: A value out of range.
    """

    sigma: float = 0.0
    delay: float = 0.0
    drop: float = 0.0

    def __post_init__(self) -> None:
        for name in ("sigma", "delay"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) >= 0.0):
                raise ValueError(f"{name}: expected at least 0, found {getattr(self, name)}")
        if not 0.0 <= self.drop <= 1.0:
            raise ValueError(f"drop: expected a share from 0 to 1, found {self.drop}")

    @classmethod
    def parse(cls, spec: str) -> Self:
        """Reads `oracle_noisy@sigma=0.5+delay=0.4+drop=0.1`; what is not named is 0.

        Raises:
            ValueError: Something else, or a value out of range.
        """
        known = "|".join(item.name for item in fields(cls))
        setting = rf"({known})=([0-9.]+)"
        if not re.fullmatch(rf"{NOISY_ORACLE}@{setting}(\+{setting})*", spec):
            raise ValueError(
                f"expected {NOISY_ORACLE}@sigma=METRES+delay=SECONDS+drop=SHARE, found {spec!r}"
            )
        return cls(**{name: float(value) for name, value in re.findall(setting, spec)})


class NoisyOracle:
    """An oracle that is wrong by a known amount, for dose and response."""

    def __init__(self, oracle: Oracle, blur: Blur, frame_dt: float):
        self._oracle = oracle
        self._blur = blur
        self._frame_dt = frame_dt
        self._rng: dict[int, np.random.Generator] = {}

    def restart(self, world: int, rng: np.random.Generator) -> None:
        """Takes the randomness of a new episode."""
        self._oracle.restart(world, rng)
        self._rng[world] = rng

    def forecast(self, situation: Situation) -> WorldForecast:
        """Blurs what the oracle sees; the radii are those of `sigma` alone."""
        exact, now = self._oracle.forecast(situation), situation.history[:, -1:]
        path = delayed(exact.position, now, self._blur.delay / self._frame_dt)
        growth = np.arange(1.0, len(path[0]) + 1.0)[:, None, None] / len(path[0])
        for row, world in enumerate(situation.indices.tolist()):
            rng, people = self._rng[world], len(situation.worlds.running(world).ids)
            own = path[row, :, :people]  # a draw must not depend on how many other worlds hold
            own += self._blur.sigma * growth * rng.standard_normal((people, 2))
            dropped = rng.random(people) < self._blur.drop
            own[:, dropped] = now[row, :, :people][:, dropped]
        wider = SIGMAS * self._blur.sigma * growth[:, 0, 0]
        return WorldForecast(position=path, radius=exact.radius + wider)


def delayed(path: Floats, now: Floats, frames: float) -> Floats:
    """Shifts paths (R, F, N, 2) by so many frames; before they begin everybody is at `now`."""
    if frames == 0.0:
        return path
    whole = np.concatenate((now, path), axis=1)  # (R, 1 + F, N, 2)
    at = np.maximum(np.arange(1, len(path[0]) + 1) - frames, 0.0)
    before = np.floor(at).astype(np.intp)
    after = np.minimum(before + 1, len(path[0]))
    weight = (at - before)[:, None, None]
    return np.asarray(whole[:, before] * (1.0 - weight) + whole[:, after] * weight)
