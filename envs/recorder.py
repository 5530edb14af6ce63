"""Collects what happens in an episode, row by row, until it is a `Trace`."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crowdsim.scenario import Scenario
from envs.config import CrowdNavConfig
from envs.perception import Percept
from envs.rewards import REWARD_TERMS
from envs.trace import TerminationReason, Trace
from envs.worlds import Worlds


@dataclass(eq=False)
class _Episode:
    """One running episode: what it started from, and its rows so far."""

    scenario: Scenario
    world_seed: np.random.SeedSequence
    time_limit: float
    shortest_path_lengths: list[float]
    rows: list[dict[str, Any]] = field(default_factory=list)
    rewards: list[list[float]] = field(default_factory=list)


class Recorder:
    """Keeps the rows of the episodes that run in W worlds."""

    def __init__(self, config: CrowdNavConfig):
        self._config = config
        self._episodes: dict[int, _Episode] = {}

    def start(
        self,
        world: int,
        scenario: Scenario,
        world_rng: np.random.Generator,
        time_limit: float,
        shortest_path_length: float,
    ) -> None:
        """Begins the episode of one world; `add` gives it its row 0."""
        seed = fresh_seed(world_rng)
        self._episodes[world] = _Episode(scenario, seed, time_limit, [shortest_path_length])

    def turn_back(self, world: int, shortest_path_length: float) -> None:
        """Begins another way in the episode of one world; `add` gives it its first row."""
        self._running(world).shortest_path_lengths.append(shortest_path_length)

    def add(
        self,
        rows: NDArray[np.intp],
        worlds: Worlds,
        goal: NDArray[np.float64],
        visible: NDArray[np.bool_],
        percept: Percept,
        rewards: dict[str, NDArray[np.float64]],
    ) -> None:
        """Adds a row to the episodes of `rows` (R,).

        `goal` (W, 2) and `visible` (W, N) are of all worlds, the rest has R in front.

        Raises:
            RuntimeError: An episode has ended, and its world was stepped before its reset.
        """
        for place, world in enumerate(rows):
            episode = self._running(int(world))
            people = len(episode.scenario.pedestrians)
            row = _state(worlds, int(world), people) | _perceived(percept, place)
            row |= {"robot_goal": goal[world].copy(), "visible": visible[world, :people].copy()}
            episode.rows.append(row)
            episode.rewards.append([float(rewards[name][place]) for name in REWARD_TERMS])

    def _running(self, world: int) -> _Episode:
        episode = self._episodes.get(world)
        if episode is None:
            raise RuntimeError(f"world {world}: expected a reset after the episode's end")
        return episode

    def finish(self, world: int, worlds: Worlds, reason: TerminationReason) -> Trace:
        """Returns the trace of the episode that ends in one world."""
        episode = self._episodes.pop(world)
        rewards = np.array(episode.rewards).T
        columns = {name: [row[name] for row in episode.rows] for name in episode.rows[0]}
        stacked: dict[str, Any] = {
            name: None if values[0] is None else np.array(values)
            for name, values in columns.items()
        }
        return Trace(
            scenario=episode.scenario,
            world_seed=episode.world_seed,
            physics_dt=self._config.physics_dt,
            dt=self._config.policy_dt,
            frame_dt=self._config.frame_dt,
            time_limit=episode.time_limit,
            mission=self._config.mission,
            robot_radius=self._config.robot_radius,
            goal_radius=self._config.goal_radius,
            shortest_path_lengths=np.array(episode.shortest_path_lengths),
            radius=episode.scenario.pedestrians.radius,
            rewards=dict(zip(REWARD_TERMS, rewards, strict=True)),
            termination_reason=reason,
            collision_role=worlds.collision_role[world],
            **stacked,
        )


def fresh_seed(rng: np.random.Generator) -> np.random.SeedSequence:
    """Returns the seed that `rng` started from, as if it had not spawned anything yet."""
    used = rng.bit_generator.seed_seq
    assert isinstance(used, np.random.SeedSequence)  # generators that spawn have one
    return np.random.SeedSequence(used.entropy, spawn_key=used.spawn_key)


def _state(worlds: Worlds, world: int, people: int) -> dict[str, Any]:
    crowd, robots = worlds.crowd, worlds.robots
    valid = crowd.valid[world, :people].copy()
    return {
        "robot_position": robots.position[world].copy(),
        "robot_velocity": robots.velocity[world].copy(),
        "robot_heading": robots.heading[world],
        "position": np.where(valid[:, None], crowd.position[world, :people], 0.0),
        "velocity": np.where(valid[:, None], crowd.velocity[world, :people], 0.0),
        "valid": valid,
        "ids": crowd.ids[world, :people].copy(),
        "clearance_pedestrian": worlds.clearance_pedestrian[world],
        "clearance_wall": worlds.clearance_wall[world],
        "social_work": worlds.social_work[world],
    }


def _perceived(percept: Percept, place: int) -> dict[str, Any]:
    outlook = percept.outlook
    return {
        "forecast": None if outlook is None else outlook.position[place],
        "forecast_ids": None if outlook is None else percept.observed.ids[place],
        "forecast_radius": None if outlook is None else outlook.radius[place],
        "forecast_frames_seen": (
            None if outlook is None else percept.history_valid[place].sum(axis=-1)
        ),
        "forecast_seconds": percept.forecast_seconds,
    }
