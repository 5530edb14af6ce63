"""W episodes side by side: the loop in which crowd, forecasts and robot meet.

The single environment is W = 1. Physics runs world by world, everything else over W at once. No
episode depends on W, on its neighbors, or on when they end.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import ArrayLike, NDArray

from crowdsim.lidar import cast_rays
from crowdsim.map import Map
from crowdsim.recordings import Picture
from crowdsim.render import render_map
from crowdsim.scenario import Scenario
from crowdsim.scenarios import find_scenario, make_scenario
from envs.config import CrowdNavConfig
from envs.forecasters import make_world_forecaster
from envs.observation import Observation, Observer, map_crops
from envs.perception import Percept, Perception
from envs.recorder import Recorder
from envs.rewards import REWARD_TERMS, Consequences, reward_terms, total
from envs.robots import RobotState, checked_actions, make_robot
from envs.tasks import Tasks
from envs.trace import TerminationReason, Trace
from envs.tracker import Rows
from envs.worlds import Worlds

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class StepResult:
    """What one step of W episodes gave.

    Attributes:
        observation: Every key with W in front, fresh arrays.
        reward: (W,) sum of the terms.
        terminated: (W,) goal reached or contact.
        truncated: (W,) out of time, and not terminated.
        rewards: Named terms of the reward, (W,) each.
        reason: Per world, why the episode ended; None while it runs.
        forecast_seconds: (W,) mean wall-clock time per forecast since the reset [s].
    """

    observation: Observation
    reward: Floats
    terminated: Flags
    truncated: Flags
    rewards: dict[str, Floats]
    reason: list[TerminationReason | None]
    forecast_seconds: Floats


class Episodes:
    """Runs W episodes of one configuration.

    Attributes:
        config: The configuration.
        worlds: Physics and state; read it, do not write it.
        tasks: What the robots have to do.
        observer: Fills observations; `observer.space` is the space of one.
        scenarios: Per world, what its episode started from.
    """

    def __init__(self, config: CrowdNavConfig, count: int, *, record: bool = False):
        """Prepares `count` episodes; `record` keeps a `Trace` of each.

        Raises:
            ValueError: An unknown scenario, or a forecaster with other frames than `config`.
        """
        find_scenario(config.scenario)
        self.config = config
        self.worlds = Worlds(config, count, record=record)
        self.tasks = Tasks(config, count)
        self.observer = Observer(config)
        self.scenarios: dict[int, Scenario] = {}
        self._robot = make_robot(config)
        self._forecaster = make_world_forecaster(config)
        self._perception = Perception(config, count, self._robot, self._forecaster)
        self._recorder = Recorder(config) if record else None
        self._traces: dict[int, Trace] = {}
        self._pictures: dict[int, Picture] = {}
        self._percepts: dict[int, tuple[Percept, int]] = {}
        self._all = np.arange(count)
        self._forecast_seconds = np.zeros(count)

    def __len__(self) -> int:
        return len(self._all)

    def reset(
        self, generators: Sequence[np.random.Generator], rows: Sequence[int] | None = None
    ) -> Observation:
        """Starts new episodes in the worlds `rows` (default: all of them).

        Args:
            generators: One per row; each spawns the streams of its episode (scenario, world,
                forecaster, sensor), so that the next episode of the same generator is another one.
            rows: Which worlds, without repetition.

        Returns:
            Observation of those worlds, every key with R in front.
        """
        started = self._all if rows is None else np.asarray(rows, dtype=np.intp)
        streams = [
            self._start(world, generator)
            for world, generator in zip(started.tolist(), generators, strict=True)
        ]
        self._perception.restart(started, self.worlds, streams)
        percept = self._forecast(started)
        observation = self._observe(percept, started)
        self._percepts.update((world, (percept, row)) for row, world in enumerate(started.tolist()))
        self._record(started, percept, {name: np.zeros(len(started)) for name in REWARD_TERMS})
        return observation

    def step(self, actions: ArrayLike) -> StepResult:
        """Runs every episode on by one policy period.

        Args:
            actions: (W, 2); values beyond [-1, 1] are clipped.

        Raises:
            ValueError: Wrong shape, no real numbers, or a value that is not finite.
            ResetNeeded: Before the first reset.
        """
        if not self.scenarios:
            raise ResetNeeded("expected a reset before the first step, found none")
        self._apply(checked_actions(actions, len(self)))
        self._track()
        reached, progress = self._reached(), self.tasks.progress(self.worlds.robots.position)
        terminated = (reached & self.tasks.on_last_way()) | self.worlds.touched
        self._turn_back(reached & ~terminated)
        percept = self._forecast(slice(None))
        observation = self._observe(percept, slice(None))
        self._percepts = {world: (percept, world) for world in range(len(self))}
        terms = reward_terms(self._consequences(percept, reached, progress), self.config)
        truncated = self.tasks.out_of_time() & ~terminated
        reason = self._reasons(reached, terminated | truncated)
        self._record(self._all, percept, terms)
        self._finish_records(reason)
        return StepResult(
            observation=observation,
            reward=total(terms),
            terminated=terminated,
            truncated=truncated,
            rewards=terms,
            reason=reason,
            forecast_seconds=self._forecast_seconds / (self.tasks.steps + 1),
        )

    def percept(self, world: int) -> tuple[Percept, int]:
        """Returns what the robot of one world perceived last, and its row in that percept."""
        return self._percepts[world]

    def pop_traces(self) -> dict[int, Trace]:
        """Returns, by world, the traces of the episodes that ended, and forgets them."""
        traces, self._traces = self._traces, {}
        return traces

    def picture(self, world: int) -> Picture:
        """Returns the ground of one world: its photograph, or else as it is drawn."""
        ground = self.scenarios[world].map
        return _drawn(ground) if ground.picture is None else ground.picture

    def _start(self, world: int, generator: np.random.Generator) -> np.random.Generator:
        """Builds the world of a new episode; returns the randomness of the robot's sensors."""
        scenario_rng, world_rng, forecast_rng, sensor_rng = generator.spawn(4)
        name, parameters = self.config.scenario, self.config.scenario_parameters
        scenario = make_scenario(name, scenario_rng, **parameters)
        scenario = _at_pace(scenario, self.config.crowd_speed)
        self.scenarios[world] = scenario
        self.worlds.restart(world, scenario, world_rng)
        self.tasks.restart(world, scenario)
        if self._forecaster is not None:
            self._forecaster.restart(world, forecast_rng)
            self._pictures[world] = _drawn(scenario.map)
        self._forecast_seconds[world] = 0.0
        if self._recorder is not None:
            limit, way = self.tasks.time_limit[world], self.tasks.way_left[world]
            self._recorder.start(world, scenario, world_rng, float(limit), float(way))
        return sensor_rng

    def _apply(self, actions: Floats) -> None:
        self._robot.apply(actions, self.worlds.robots)
        self.worlds.step(self._robot)
        self.tasks.advance()

    def _track(self) -> None:
        self._perception.update(self.worlds)

    def _forecast(self, rows: Rows) -> Percept:
        """Chooses whom the robots of `rows` observe, and forecasts them."""
        percept = self._perception.look(rows, self.worlds, self._pictures)
        self._forecast_seconds[rows] += percept.forecast_seconds
        return percept

    def _observe(self, percept: Percept, rows: Rows) -> Observation:
        robots = self.worlds.robots.rows(rows)
        task, lidar = self.tasks.task(robots.position, rows), self._lidar(robots, rows)
        observation = self.observer.observe(percept, robots, task, lidar)
        if self.config.observe_map:
            grounds = [self.scenarios[world].map for world in self._all[rows].tolist()]
            observation["map"] = map_crops(robots, [_drawn(ground) for ground in grounds])
        return observation

    def _lidar(self, robots: RobotState, rows: Rows) -> Floats:
        """Ranges (R, rays); worlds on the same map are scanned together."""
        reach = self.config.sensor_range
        ranges = np.full((len(robots.heading), self.config.lidar_rays), reach)
        places: dict[Map, list[int]] = {}
        for place, world in enumerate(self._all[rows].tolist()):
            places.setdefault(self.scenarios[world].map, []).append(place)
        for ground, at in places.items():
            if len(ground.segments) > 0:
                position, heading = robots.position[at], robots.heading[at]
                rays = self.config.lidar_rays
                ranges[at] = cast_rays(ground.segments, position, heading, rays, reach)
        return ranges

    def _consequences(self, percept: Percept, reached: Flags, progress: Floats) -> Consequences:
        config, worlds = self.config, self.worlds
        times = np.arange(1.0, config.forecast_steps + 1.0) * config.frame_dt
        return Consequences(
            progress=progress,
            reached=reached,
            collided=worlds.touched,
            clearance=worlds.clearance_pedestrian,
            planned=self._robot.rollout(worlds.robots, times),
            forecast=percept.forecast,
            neighbors_valid=percept.observed.valid,
            neighbors_radius=percept.radius,
        )

    def _reached(self) -> Flags:
        """Whether the robots are at their goals and touched nothing on the way there."""
        return self.tasks.near_goal(self.worlds.robots.position) & ~self.worlds.touched

    def _turn_back(self, arrived: Flags) -> None:
        """Sends the robots that `arrived` (W,), but whose mission goes on, back again."""
        worlds = np.flatnonzero(arrived)
        self.tasks.turn_back(worlds, self.worlds.robots.position[worlds])
        if self._recorder is not None:
            for world in worlds.tolist():
                self._recorder.turn_back(world, float(self.tasks.way_left[world]))

    def _reasons(self, reached: Flags, ended: Flags) -> list[TerminationReason | None]:
        """Why the episodes ended, by world; None where they go on."""
        reasons: list[TerminationReason | None] = [None] * len(self)
        for world in np.flatnonzero(ended).tolist():
            if self.worlds.touched_pedestrian[world]:
                reasons[world] = "collision_pedestrian"
            elif self.worlds.touched_wall[world]:
                reasons[world] = "collision_wall"
            else:
                reasons[world] = "goal" if reached[world] else "timeout"
        return reasons

    def _record(self, rows: NDArray[np.intp], percept: Percept, terms: dict[str, Floats]) -> None:
        """Adds a row to the traces of the worlds `rows`."""
        if self._recorder is not None:
            visible = self._perception.visible
            goal = self.tasks.routes.goal
            self._recorder.add(rows, self.worlds, goal, visible, percept, terms)

    def _finish_records(self, reasons: list[TerminationReason | None]) -> None:
        for world, reason in enumerate(reasons):
            if self._recorder is not None and reason is not None:
                self._traces[world] = self._recorder.finish(world, self.worlds, reason)


def _at_pace(scenario: Scenario, factor: float) -> Scenario:
    """The same scenario with everybody's desired speed times `factor`, unless it is a replay."""
    if factor == 1.0 or scenario.replay is not None:
        return scenario
    people = scenario.pedestrians
    hurried = replace(
        people, desired_speed=factor * people.desired_speed, velocity=factor * people.velocity
    )
    return replace(scenario, pedestrians=hurried)


@lru_cache(maxsize=64)
def _drawn(ground: Map) -> Picture:
    """The ground as networks and policies see it everywhere, also where there is a photograph."""
    return Picture(*render_map(replace(ground, picture=None)))
