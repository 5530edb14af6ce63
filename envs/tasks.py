"""What W robots have to do: the way to the goal in its time, and in a mission the way back, again.

A mission takes the robot to and fro between its goal and its start. The task of a step is settled
before the robot looks around: the observation of an arrival shows the next goal already, and the
progress of that step is the one towards the goal that was reached.
"""

import numpy as np
from numpy.typing import NDArray

from crowdsim.scenario import Scenario
from envs.config import CrowdNavConfig
from envs.observation import WAYPOINT_DISTANCE, Task
from envs.routes import Routes
from envs.tracker import Rows

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


class Tasks:
    """The tasks of W robots.

    Attributes:
        routes: Ways to the goals.
        steps: (W,) policy steps since the reset.
        way_left: (W,) length of the way to the goal when last looked at [m].
        time_limit: (W,) time for a way to the goal [s].
    """

    def __init__(self, config: CrowdNavConfig, worlds: int):
        self._config = config
        self._all = np.arange(worlds)
        self.steps = np.zeros(worlds, dtype=np.int64)
        self._way_steps = np.zeros(worlds, dtype=np.int64)
        self.routes = Routes(worlds)
        self.way_left = np.zeros(worlds)
        self.time_limit = np.ones(worlds)

    def restart(self, world: int, scenario: Scenario) -> None:
        """Takes the task of a new episode.

        Raises:
            ValueError: There is no way to the goal, or no mission in this scenario.
        """
        config = self._config
        if config.mission > 0.0:
            check_mission(scenario, config.goal_radius)
        self.routes.restart(world, scenario)
        start = np.array([scenario.robot_start[:2]], dtype=np.float64)
        limit = scenario.time_limit if config.time_limit is None else config.time_limit
        self.steps[world] = self._way_steps[world] = 0
        self.time_limit[world] = limit
        self.way_left[world] = self.routes.distance(start, np.array([world]))[0]

    def advance(self) -> None:
        """Counts a policy step."""
        self.steps += 1
        self._way_steps += 1

    def task(self, position: Floats, rows: Rows) -> Task:
        """Returns what the robots of `rows`, at `position` (R, 2), have to do."""
        worlds = self._all[rows]
        elapsed = self._way_steps[rows] * self._config.policy_dt
        return Task(
            goal=self.routes.goal[rows],
            waypoint=self.routes.waypoint(position, worlds, WAYPOINT_DISTANCE),
            time_left=np.maximum(0.0, 1.0 - elapsed / self.time_limit[rows]),
        )

    def progress(self, position: Floats) -> Floats:
        """How much shorter the ways (W,) have become [m]; nothing where there is no way for now."""
        left = self.routes.distance(position, self._all)
        left = np.where(np.isfinite(left), left, self.way_left)
        progress, self.way_left = self.way_left - left, left
        return progress

    def near_goal(self, position: Floats) -> Flags:
        """(W,), whether the robots at `position` (W, 2) are at their goals."""
        offset = self.routes.goal - position
        return np.asarray(offset[:, 0] ** 2 + offset[:, 1] ** 2 < self._config.goal_radius**2)

    def on_last_way(self) -> Flags:
        """(W,), whether arriving now is the end: the mission has taken as long as it should."""
        return np.asarray(self.steps >= np.rint(self._config.mission / self._config.policy_dt))

    def out_of_time(self) -> Flags:
        """(W,), whether the time for the present way is over."""
        return np.asarray(self._way_steps >= np.rint(self.time_limit / self._config.policy_dt))

    def turn_back(self, worlds: NDArray[np.intp], position: Floats) -> None:
        """Sends the robots of `worlds` (R,), at `position` (R, 2), where they last came from."""
        for world in worlds.tolist():
            self.routes.turn_back(world)
        self._way_steps[worlds] = 0
        self.way_left[worlds] = self.routes.distance(position, worlds)


def check_mission(scenario: Scenario, goal_radius: float) -> None:
    """Raises ValueError if the crowd of a scenario ends some day, or start and goal are one."""
    each = scenario.on_arrival
    if scenario.replay is not None or "leave" in ((each,) if isinstance(each, str) else each):
        raise ValueError(
            f"mission: expected people who do not leave for good, found {scenario.name} with "
            + ("recorded people" if scenario.replay is not None else "on_arrival 'leave'")
        )
    apart = np.linalg.norm(np.subtract(scenario.robot_goal, scenario.robot_start[:2]))
    if apart < 2.0 * goal_radius:
        raise ValueError(
            f"mission: expected a start at least {2.0 * goal_radius} m from the goal, "
            f"found {apart:.2f} m in {scenario.name}"
        )
