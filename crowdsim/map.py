"""The static world: surfaces and walls, one geometry for physics, pictures and sensors."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from crowdsim.recordings.surfaces import Surface

if TYPE_CHECKING:
    from crowdsim.recordings.recording import Picture


def _no_walls() -> NDArray[np.float64]:
    return np.empty((0, 2, 2))


@dataclass(frozen=True, kw_only=True, eq=False)
class Map:
    """Surfaces and walls in world metres (x right, y up).

    Maps compare by identity, and distance fields and way-finding are cached per map object:
    build a map once and share it between scenarios.

    Attributes:
        bounds: `(x_min, y_min, x_max, y_max)` [m] of what pictures and grids cover. It is no
            wall: people may walk out of it.
        surfaces: `(surface, polygon (P, 2))` in painter's order, later ones on top.
        walls: `(S, 2, 2)` free-standing wall segments [m].
        background: the surface where no polygon lies, outside the bounds too.
        picture: a real photograph of the place, if there is one.
    """

    bounds: tuple[float, float, float, float]
    surfaces: tuple[tuple[Surface, NDArray[np.float64]], ...] = ()
    walls: NDArray[np.float64] = field(default_factory=_no_walls)
    background: Surface = Surface.PAVEMENT
    picture: Picture | None = None

    def __post_init__(self) -> None:
        """Refuse geometry that the physics would silently accept.

        Raises:
            ValueError: if bounds, polygons or walls are malformed or not finite.
        """
        x_min, y_min, x_max, y_max = self.bounds
        if not (np.isfinite(self.bounds).all() and x_min < x_max and y_min < y_max):
            raise ValueError(
                f"bounds: expected finite x_min < x_max and y_min < y_max, found {self.bounds}"
            )
        if self.walls.ndim != 3 or self.walls.shape[1:] != (2, 2):
            raise ValueError(f"walls: expected shape (S, 2, 2), found {self.walls.shape}")
        if not np.isfinite(self.walls).all():
            raise ValueError("walls: expected finite coordinates, found NaN or infinity")
        for index, (surface, polygon) in enumerate(self.surfaces):
            _check_polygon(f"surfaces[{index}] ({surface.name.lower()})", polygon)

    @cached_property
    def obstacles(self) -> shapely.Geometry:
        """The area that is not walkable, as one shapely geometry (walls have no area)."""
        area = self._covered_by([surface for surface in Surface if not surface.walkable])
        shapely.prepare(area)
        return area

    @cached_property
    def segments(self) -> NDArray[np.float64]:
        """All that bodies bump into: walls and the outlines of obstacles, `(S, 2, 2)` [m]."""
        return self._walls_and_outlines(self.obstacles)

    @cached_property
    def occluders(self) -> NDArray[np.float64]:
        """All that one cannot look across, `(S, 2, 2)` [m]: `segments` without the water's edge."""
        opaque = [surface for surface in Surface if not surface.see_through]
        return self._walls_and_outlines(self._covered_by(opaque))

    def walkable(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Tell for points `(..., 2)` [m] whether the ground can be walked on, `(...,)`."""
        points = np.asarray(points, dtype=np.float64)
        free: NDArray[np.bool_] = ~shapely.contains_xy(
            self.obstacles, points[..., 0], points[..., 1]
        )
        if self.background.walkable:
            return free
        x_min, y_min, x_max, y_max = self.bounds
        inside = (points >= (x_min, y_min)).all(axis=-1) & (points <= (x_max, y_max)).all(axis=-1)
        return np.asarray(free & inside)

    def _covered_by(self, kinds: Collection[Surface]) -> shapely.Geometry:
        """The area where the topmost surface is of some kinds."""
        area: shapely.Geometry = shapely.Polygon()
        if self.background in kinds:
            area = shapely.box(*self.bounds)
        for surface, corners in self.surfaces:
            polygon = shapely.Polygon(corners)
            area = area.union(polygon) if surface in kinds else area.difference(polygon)
        return area

    def _walls_and_outlines(self, area: shapely.Geometry) -> NDArray[np.float64]:
        outlines = [self.walls]
        for ring in shapely.get_rings(shapely.get_parts(area)):
            corners = shapely.get_coordinates(ring)
            outlines.append(np.stack([corners[:-1], corners[1:]], axis=1))  # (R, 2, 2)
        segments: NDArray[np.float64] = np.concatenate(outlines).astype(np.float64)
        segments = segments[(segments[:, 0] != segments[:, 1]).any(axis=1)]
        segments.flags.writeable = False
        return segments


def _check_polygon(name: str, polygon: NDArray[np.float64]) -> None:
    if polygon.ndim != 2 or polygon.shape[1] != 2 or len(polygon) < 3:
        raise ValueError(f"{name}: expected at least 3 corners (P, 2), found shape {polygon.shape}")
    if not np.isfinite(polygon).all():
        raise ValueError(f"{name}: expected finite corners, found NaN or infinity")
    if not shapely.Polygon(polygon).is_valid:
        raise ValueError(f"{name}: expected a simple polygon, found one that crosses itself")
