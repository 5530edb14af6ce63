"""A place while it is being drawn: ground is cut out, and things are put where people fit past."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from crowdsim.map import Map
from crowdsim.maps.shapes import box
from crowdsim.recordings.surfaces import Surface

FloatArray = NDArray[np.float64]
Part = tuple[Surface, FloatArray]

PASSAGE: Final = 1.6
"""Least width between a thing that is put down and everything else [m]: two people pass."""
CLEAR: Final = 0.5
"""Least distance from where people come, go and stop to anything solid [m]."""
DOORSTEP: Final = 1.6
"""Radius around doors and gates that nothing is put into [m]."""
OVERLAP: Final = 0.05
"""Pieces of ground that belong together overlap by this, so that no sliver is left [m]."""
ATTEMPTS: Final = 40


@dataclass(frozen=True, kw_only=True, eq=False)
class Place:
    """A generated map and where a crowd on it comes from and goes to. World metres.

    Attributes:
        kind: One of `crowdsim.maps.PLACES`.
        map: The ground; the same object every time the same layout is asked for.
        entrances: (E, 2, 2) straight gates; every point of one is walkable and `CLEAR` of
            obstacles. People enter and leave anywhere on them.
        stops: (S, 2) points worth walking to: doors, counters, benches, shelves. `CLEAR` too.
    """

    kind: str
    map: Map
    entrances: FloatArray
    stops: FloatArray


class Plan:
    """Surfaces, gates and stops collected in a frame of their own; `finish` makes the place.

    Attributes:
        rng: Source of all draws.
        ground: What can be walked on so far, without things and walls.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        """Start with nothing but solid buildings."""
        self.rng = rng
        self.ground: shapely.Geometry = shapely.Polygon()
        self._parts: list[Part] = []
        self._walls: list[FloatArray] = []
        self._gates: list[FloatArray] = []
        self._stops: list[FloatArray] = []
        self._doorsteps: list[shapely.Geometry] = []

    def gardens(self, reach: float) -> None:
        """Plant some of the ground between the buildings, so that they are not one brown mass."""
        for _ in range(int(self.rng.integers(6, 16))):
            x, y = self.rng.uniform(-reach, reach, 2)
            width, depth = self.rng.uniform(2.0, 6.0, 2)
            self._parts.append((Surface.TREE, box(x, y, x + width, y + depth)))

    def is_open(self, point: ArrayLike) -> bool:
        """Tell whether a point (2,) can be walked on so far."""
        x, y = np.asarray(point, dtype=np.float64).tolist()
        return bool(shapely.contains_xy(self.ground, x, y))

    def open(self, polygon: FloatArray, surface: Surface = Surface.PAVEMENT) -> None:
        """Cut walkable ground out of the buildings, or give it another surface."""
        self._parts.append((surface, polygon))
        self.ground = self.ground.union(shapely.Polygon(polygon))

    def pave(self, surface: Surface, polygon: FloatArray) -> None:
        """Give ground a surface where people do not get to: a track behind its railing."""
        self._parts.append((surface, polygon))

    def build(self, surface: Surface, polygon: FloatArray) -> None:
        """Put a solid thing down, wherever that is."""
        self._parts.append((surface, polygon))
        self.ground = self.ground.difference(shapely.Polygon(polygon))

    def wall(self, start: ArrayLike, end: ArrayLike) -> None:
        """Put a railing between two points."""
        self._walls.append(np.array([start, end], dtype=np.float64))

    def gate(self, start: ArrayLike, end: ArrayLike) -> None:
        """Let people come and go on a straight line, and keep its surroundings free."""
        gate = np.array([start, end], dtype=np.float64)
        self._gates.append(gate)
        self._doorsteps.append(shapely.LineString(gate).buffer(DOORSTEP))

    def stop(self, x: float, y: float) -> None:
        """Give people a point to walk to."""
        self._stops.append(np.array([x, y], dtype=np.float64))

    def door(self, x: float, y: float) -> None:
        """Give people a point to walk to, and keep its surroundings free."""
        self.stop(x, y)
        self._doorsteps.append(shapely.Point(x, y).buffer(DOORSTEP))

    def furnish(self, parts: Sequence[Part], gap: float = PASSAGE) -> bool:
        """Put a group of things down if all around it a gap stays free [m]; tells whether.

        The first part may carry later ones on top: a basin its water, a planter its tree.
        """
        hull = shapely.MultiPoint(np.concatenate([polygon for _, polygon in parts])).convex_hull
        shapely.prepare(self.ground)
        fits = self.ground.contains(hull.buffer(gap))
        if not fits or any(step.intersects(hull) for step in self._doorsteps):
            return False
        for surface, polygon in parts:
            self.build(surface, polygon)
        return True

    def scatter(
        self,
        area: FloatArray,
        count: int | np.integer[Any],
        thing: Callable[[float, float, float], Sequence[Part]],
        *,
        gap: float = PASSAGE,
        front: float | None = None,
    ) -> None:
        """Put up to `count` copies of a thing down at random, in a random quarter turn.

        Args:
            area: Polygon (P, 2) that their middles lie in.
            count: How many; fewer where there is no room.
            thing: Draws its parts at x, y [m] and an angle [rad].
            gap: Width that stays free around each [m].
            front: Distance from its middle to a stop before it [m]; None for no stop.
        """
        low, high = area.min(axis=0), area.max(axis=0)
        for _ in range(count):
            for _ in range(ATTEMPTS):
                x, y = self.rng.uniform(low, high).tolist()
                angle = 0.5 * math.pi * self.rng.integers(4)
                if not shapely.contains_xy(shapely.Polygon(area), x, y):
                    continue
                if self.furnish(thing(x, y, angle), gap):
                    if front is not None:
                        self.stop(x + front * math.cos(angle), y + front * math.sin(angle))
                    break

    def finish(self, kind: str, bounds: tuple[float, float, float, float]) -> Place:
        """Mirror and turn the plan by a drawn multiple of 90 degrees and make it a place.

        Stops that something stands too close to are left out.
        """
        world_from_plan = orientation(self.rng).T
        corners = np.array([bounds[:2], bounds[2:]]) @ world_from_plan
        (x_min, y_min), (x_max, y_max) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
        surfaces = tuple((surface, polygon @ world_from_plan) for surface, polygon in self._parts)
        world_map = Map(
            bounds=(x_min, y_min, x_max, y_max),
            surfaces=surfaces,
            walls=np.array(self._walls).reshape(-1, 2, 2) @ world_from_plan,
            background=Surface.BUILDING,
        )
        stops = np.array(self._stops).reshape(-1, 2) @ world_from_plan
        return Place(
            kind=kind,
            map=world_map,
            entrances=np.array(self._gates) @ world_from_plan,
            stops=stops[_clear(world_map, stops)],
        )


def _clear(world_map: Map, points: FloatArray) -> NDArray[np.bool_]:
    solid = shapely.union(world_map.obstacles, shapely.MultiLineString(list(world_map.walls)))
    far: NDArray[np.bool_] = shapely.distance(solid, shapely.points(points)) >= CLEAR
    return far


def orientation(rng: np.random.Generator) -> FloatArray:
    """One of the eight symmetries of the square (2, 2), with exact entries."""
    turns = [[[1, 0], [0, 1]], [[0, -1], [1, 0]], [[-1, 0], [0, -1]], [[0, 1], [-1, 0]]]
    mirror = np.diag([1.0, float(rng.choice([-1.0, 1.0]))])
    return np.array(turns[rng.integers(4)], dtype=np.float64) @ mirror
