"""The robots' way to their goals: how far it is and where to head next. W robots at once."""

import numpy as np
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.scenario import Scenario
from crowdsim.wayfinding import GeodesicField, geodesic_field

Floats = NDArray[np.float64]


class Routes:
    """Shortest ways on the maps of W worlds; straight lines where a map has no obstacles.

    Attributes:
        goal: (W, 2) [m].
    """

    def __init__(self, worlds: int):
        self.goal = np.zeros((worlds, 2))
        self._maps: dict[int, Map] = {}
        self._origin = np.zeros((worlds, 2))
        self._fields: dict[int, GeodesicField] = {}

    def restart(self, world: int, scenario: Scenario) -> None:
        """Takes the goal and the map of a new episode.

        Raises:
            ValueError: There is no way from the robot's start to its goal.
        """
        self.goal[world] = scenario.robot_goal
        self._origin[world] = scenario.robot_start[:2]
        self._maps[world] = scenario.map
        self._find_ways(world)
        if world in self._fields and not np.isfinite(
            self._fields[world].length(self._origin[world])
        ):
            raise ValueError(
                f"{scenario.name}: the robot's goal {scenario.robot_goal} must be reachable "
                f"from its start {scenario.robot_start[:2]}, there is no way"
            )

    def turn_back(self, world: int) -> None:
        """Takes for a goal where the last way began."""
        goal = self.goal[world].copy()
        self.goal[world] = self._origin[world]
        self._origin[world] = goal
        self._find_ways(world)

    def _find_ways(self, world: int) -> None:
        """Looks the ways to the goal up, where there is anything to walk around."""
        self._fields.pop(world, None)
        if len(self._maps[world].segments) > 0:
            self._fields[world] = geodesic_field(self._maps[world], self.goal[world].copy())

    def distance(self, position: Floats, worlds: NDArray[np.intp]) -> Floats:
        """Returns the way (R,) [m] that is left from `position` (R, 2) in `worlds` (R,)."""
        offset = self.goal[worlds] - position
        left = np.sqrt(offset[:, 0] ** 2 + offset[:, 1] ** 2)
        for row, world in enumerate(worlds):
            if world in self._fields:
                left[row] = self._fields[world].length(position[row])
        return left

    def waypoint(self, position: Floats, worlds: NDArray[np.intp], ahead: float) -> Floats:
        """Returns points (R, 2) `ahead` metres down the way, or the goal when that is nearer."""
        offset = self.goal[worlds] - position
        length = np.sqrt(offset[:, 0] ** 2 + offset[:, 1] ** 2)
        share = ahead / np.maximum(length, ahead)
        points = position + offset * share[:, None]
        for row, world in enumerate(worlds):
            if world in self._fields:
                points[row] = self._fields[world].point_ahead(position[row], ahead)
        return points
