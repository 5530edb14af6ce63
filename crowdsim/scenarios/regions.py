"""Regions that a user names, and free points drawn from them."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.distance_field import distance_field
from crowdsim.groups import abreast
from crowdsim.map import Map
from crowdsim.maps import Place, make_place
from crowdsim.routes import GOAL_SPACING
from crowdsim.scenarios.placement import ATTEMPTS
from crowdsim.wayfinding import geodesic_field

FloatArray = NDArray[np.float64]

ENTRANCES: Final = "entrances"
STOPS: Final = "stops"
Region = tuple[float, ...] | str
"""A point (x, y), a box (x_min, y_min, x_max, y_max) [m], or `ENTRANCES` or `STOPS` of a place."""

CLEAR: Final = 0.4
"""Distance that drawn points keep from everything solid [m]."""
LEAST_WAY: Final = 2.0
"""Least distance between two points of a way that follow each other [m]."""


@dataclass(frozen=True, kw_only=True)
class PlaceChoice:
    """A generated place: its kind, and the least and greatest layout that is drawn."""

    kind: str
    layout: tuple[int, int]


class Points:
    """Where people can start, pass and arrive.

    Attributes:
        map: The ground.
    """

    def __init__(self, ground: Map | PlaceChoice, rng: np.random.Generator) -> None:
        """Take a map as it is, or draw a place."""
        self._place: Place | None = None
        if isinstance(ground, PlaceChoice):
            low, high = ground.layout
            self._place = make_place(ground.kind, int(rng.integers(low, high + 1)))
        self.map: Map = ground if isinstance(ground, Map) else self._place_of_draw().map
        self._field = distance_field(self.map)

    def _place_of_draw(self) -> Place:
        if self._place is None:
            raise ValueError(f"{ENTRANCES} and {STOPS} need a place as the map, found another map")
        return self._place

    def way(self, rng: np.random.Generator, regions: tuple[Region, ...]) -> FloatArray:
        """One point per region (P, 2), neighbors at least `LEAST_WAY` apart.

        Raises:
            ValueError: None was found in `ATTEMPTS` draws.
        """
        for _ in range(ATTEMPTS):
            points = np.array(
                [self._start(rng, regions[0]), *(self._end(rng, r) for r in regions[1:])]
            )
            if (np.linalg.norm(np.diff(points, axis=0), axis=1) >= LEAST_WAY).all():
                return points
        names = " and ".join(map(str, regions))
        raise ValueError(f"no way whose points are {LEAST_WAY} m apart found between {names}")

    def _start(self, rng: np.random.Generator, region: Region) -> FloatArray:
        """A free point (2,) of a region, anywhere along an entrance."""
        if region == ENTRANCES:
            first, last = rng.choice(self._place_of_draw().entrances)
            return np.asarray(first + rng.uniform() * (last - first))
        return self._end(rng, region)

    def _end(self, rng: np.random.Generator, region: Region) -> FloatArray:
        """A free point (2,) of a region, the middle of an entrance.

        Way-finding to a point is computed once per map: few distinct goals keep it quick.
        """
        if region == ENTRANCES:
            return np.asarray(rng.choice(self._place_of_draw().entrances).mean(axis=0))
        if region == STOPS:
            return np.asarray(rng.choice(self._place_of_draw().stops))
        low, high = np.array(region[:2], dtype=np.float64), np.array(region[-2:], dtype=np.float64)
        for _ in range(ATTEMPTS if (high > low).any() else 1):
            point = rng.uniform(low, high)
            if self.are_free(point):
                return np.asarray(point)
        raise ValueError(f"no free point found in {region}: walls are nearer than {CLEAR} m")

    def on_the_walk(self, rng: np.random.Generator, way: FloatArray, size: int) -> FloatArray:
        """Places (size, 2) side by side, anywhere on the walk to the first point of a way."""
        goal = np.round(way[1] / GOAL_SPACING) * GOAL_SPACING
        field = geodesic_field(self.map, goal)
        there = field.point_ahead(way[0], rng.uniform(0.0, 0.9) * field.length(way[0]))
        ahead_x, ahead_y = field.direction(there).tolist()
        return abreast(there, math.atan2(ahead_y, ahead_x), size)

    def are_free(self, points: FloatArray) -> NDArray[np.bool_]:
        """Whether somebody can stand at points (..., 2), (...,)."""
        clear = self._field.distance(points) >= CLEAR
        return np.asarray(clear & self.map.walkable(points))
