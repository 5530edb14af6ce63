"""Shortest walks around obstacles: where to head next, and how far it is.

A Dijkstra sweep over the walkable grid (scikit-image) orders its cells by distance from the goal;
in that order each cell is then given the farthest corner of the way that it can see (as Theta*
does: Nash et al. 2007). So people walk straight from corner to corner, at any angle, where the
raw grid would have them walk in 45 degree steps.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from skimage.graph import MCP_Geometric
from skimage.segmentation import expand_labels

from crowdsim.distance_field import distance_field
from crowdsim.map import Map

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
AnchorArray = NDArray[np.int32]

CELL = 0.125
"""Spacing of the walkable grid [m]."""

DIRECT = -1
"""Anchor of cells from which the goal is in sight, or cannot be reached at all."""


class GeodesicField:
    """Shortest walks to one goal from everywhere on a map.

    Attributes:
        goal: `(2,)` [m].
        anchors: `(H, W)` for each cell the flat index of the cell to head for, or `DIRECT`.
        costs: `(H, W)` walking distance from each cell to the goal [m].
        origin: `(2,)` world position of cell (0, 0) [m].
    """

    def __init__(self, free: BoolArray, origin: FloatArray, goal: FloatArray) -> None:
        """Sweep the walkable cells `(H, W)` from a goal `(2,)` [m].

        An empty grid stands for open ground. Points in cells that are not free go the way of
        the nearest free one.
        """
        self.goal = goal
        self.origin = origin
        self.anchors: AnchorArray = np.full(free.shape, DIRECT, dtype=np.int32)
        self.costs: FloatArray = np.full(free.shape, np.inf)
        if free.any():
            self._sweep(free)

    def distance(self, points: ArrayLike) -> FloatArray:
        """Walking distance `(...,)` [m] from points `(..., 2)`; inf where there is no way."""
        return np.asarray(self._follow(points)[..., 2])

    def direction(self, points: ArrayLike) -> FloatArray:
        """Unit vectors `(..., 2)` to walk in from points `(..., 2)`; zero at the goal itself.

        Where there is no way they point straight at the goal.
        """
        ahead: FloatArray = self._follow(points)[..., :2] - np.asarray(points, dtype=np.float64)
        length = np.linalg.norm(ahead, axis=-1, keepdims=True)
        unit: FloatArray = np.divide(ahead, length, out=np.zeros_like(ahead), where=length > 0)
        return unit

    def path(self, start: ArrayLike, spacing: float = 0.5) -> FloatArray:
        """Shortest walk `(P, 2)` [m] from a start to the goal, points at most `spacing` apart.

        Where there is no way it is the straight line.
        """
        pieces = []
        for here, corner in pairwise(self._corners(start)):
            count = int(np.ceil(np.linalg.norm(corner - here) / spacing))
            pieces.append(np.linspace(here, corner, max(count, 1), endpoint=False))
        return np.concatenate([*pieces, self.goal[None]])

    def length(self, start: ArrayLike) -> float:
        """Length of the shortest walk from a start `(2,)` [m]; inf where there is no way."""
        return float(self.distance(start))

    def point_ahead(self, start: ArrayLike, distance: float) -> FloatArray:
        """Point `(2,)` so many metres down the shortest walk; the goal when that is nearer."""
        for here, corner in pairwise(self._corners(start)):
            step = float(np.linalg.norm(corner - here))
            if step >= distance:
                return np.asarray(here + (corner - here) * (distance / step))
            distance -= step
        return self.goal.copy()

    def _corners(self, start: ArrayLike) -> list[FloatArray]:
        """Give start, corners and goal of the shortest walk."""
        corners = [np.asarray(start, dtype=np.float64)]
        while (corners[-1] != self.goal).any():
            corners.append(self._follow(corners[-1])[:2])
        return corners

    def _follow(self, points: ArrayLike) -> FloatArray:
        """Next corner (x, y) of the walk and its whole length, `(..., 3)` [m]."""
        points = np.asarray(points, dtype=np.float64)
        followed = np.empty((points.size // 2, 3))
        flat = np.ascontiguousarray(points).reshape(-1, 2)
        _follow_all(self.anchors, self.costs, self.origin, self.goal, flat, followed)
        return followed.reshape(*points.shape[:-1], 3)

    def _sweep(self, free: BoolArray) -> None:
        nearest = _nearest_free(free)
        goal_cell = cell_of(free.shape, self.origin, self.goal[0], self.goal[1])
        source = np.unravel_index(nearest[goal_cell], free.shape)
        # A goal too near a wall is looked for from the nearest place where one can stand.
        seen = self.goal if free[goal_cell] else self.origin + CELL * np.array(source[::-1])
        costs, _ = MCP_Geometric(np.where(free, 1.0, np.inf)).find_costs([source])
        reached = np.flatnonzero(np.isfinite(costs))
        order = reached[np.argsort(costs.ravel()[reached], kind="stable")]
        _pull_strings(free, order, self.origin, self.goal, seen, self.anchors, self.costs)
        self.anchors = self.anchors.ravel()[nearest]
        self.costs = self.costs.ravel()[nearest]


def geodesic_field(world_map: Map, goal: ArrayLike, clearance: float = 0.3) -> GeodesicField:
    """Give the field of shortest walks to a goal `(2,)` [m]; cached per map object and goal.

    Args:
        world_map: obstacles to walk around. Walks stay inside its bounds.
        goal: where to; if nobody can stand there, the nearest free place is sought first.
        clearance: distance that the walk keeps from walls [m].

    Raises:
        ValueError: if the goal is not finite.
    """
    x, y = (float(value) for value in np.asarray(goal, dtype=np.float64))
    if not np.isfinite([x, y]).all():
        raise ValueError(f"goal: expected finite coordinates, found ({x}, {y})")
    return _cached_field(world_map, x, y, float(clearance))


@lru_cache(maxsize=512)
def _cached_field(world_map: Map, x: float, y: float, clearance: float) -> GeodesicField:
    free, origin = _free_cells(world_map, clearance)
    return GeodesicField(free, origin, np.array([x, y]))


@lru_cache(maxsize=64)
def _free_cells(world_map: Map, clearance: float) -> tuple[BoolArray, FloatArray]:
    """Cells `(H, W)` where one can stand, and the position of the first; empty on open ground."""
    x_min, y_min, x_max, y_max = world_map.bounds
    origin = np.array([x_min, y_min]) + CELL / 2
    if len(world_map.segments) == 0:
        return np.zeros((0, 0), dtype=np.bool_), origin
    centers = np.stack(
        np.meshgrid(np.arange(origin[0], x_max, CELL), np.arange(origin[1], y_max, CELL)), axis=-1
    )  # (H, W, 2)
    clear = distance_field(world_map).distance(centers) >= clearance
    return clear & world_map.walkable(centers), origin


def _nearest_free(free: BoolArray) -> NDArray[np.int64]:
    """Flat index `(H, W)` of the free cell nearest to each cell."""
    labels = np.where(free, np.arange(1, free.size + 1).reshape(free.shape), 0)
    near = expand_labels(labels, distance=sum(free.shape))  # type: ignore[no-untyped-call]
    return np.asarray(near - 1)


@njit(cache=True)
def cell_of(shape: tuple[int, int], origin: FloatArray, x: float, y: float) -> tuple[int, int]:
    """Row and column of the cell that holds a point, the nearest one for points off the grid."""
    row = int(np.floor((y - origin[1]) / CELL + 0.5))
    column = int(np.floor((x - origin[0]) / CELL + 0.5))
    return min(max(row, 0), shape[0] - 1), min(max(column, 0), shape[1] - 1)


@njit(cache=True)
def next_point(
    anchors: AnchorArray, origin: FloatArray, goal: FloatArray, x: float, y: float
) -> tuple[float, float]:
    """Point to walk to from (x, y) [m]: the next corner of the shortest walk, or the goal."""
    if anchors.size == 0:
        return goal[0], goal[1]
    row, column = cell_of(anchors.shape, origin, x, y)
    if anchors[row, column] == DIRECT:
        return goal[0], goal[1]
    return _center(anchors[row, column], anchors.shape[1], origin)


@njit(cache=True)
def _center(cell: int, columns: int, origin: FloatArray) -> tuple[float, float]:
    return origin[0] + (cell % columns) * CELL, origin[1] + (cell // columns) * CELL


@njit(cache=True)
def _follow_all(
    anchors: AnchorArray,
    costs: FloatArray,
    origin: FloatArray,
    goal: FloatArray,
    points: FloatArray,
    followed: FloatArray,
) -> None:
    for index in range(points.shape[0]):
        x, y = points[index, 0], points[index, 1]
        next_x, next_y = next_point(anchors, origin, goal, x, y)
        rest = 0.0
        if anchors.size > 0:
            row, column = cell_of(anchors.shape, origin, x, y)
            anchor = anchors[row, column]
            if anchor != DIRECT:
                rest = costs[anchor // anchors.shape[1], anchor % anchors.shape[1]]
            elif not np.isfinite(costs[row, column]):
                rest = np.inf
        followed[index, 0] = next_x
        followed[index, 1] = next_y
        followed[index, 2] = np.hypot(next_x - x, next_y - y) + rest


@njit(cache=True)
def _pull_strings(
    free: BoolArray,
    order: NDArray[np.int64],
    origin: FloatArray,
    goal: FloatArray,
    seen: FloatArray,
    anchors: AnchorArray,
    costs: FloatArray,
) -> None:
    """Give each cell, nearest to the goal first, the farthest corner that a neighbor knows.

    Args:
        free: `(H, W)` cells where one can stand.
        order: flat indices of the reachable cells by distance from the goal, its own cell first.
        origin: `(2,)` position of the first cell [m].
        goal: `(2,)` [m].
        seen: `(2,)` place that must be in sight for walking straight to the goal [m].
        anchors: `(H, W)` filled: the cell to head for.
        costs: `(H, W)` filled: walking distance [m].
    """
    columns = free.shape[1]
    for rank in range(len(order)):
        row, column = order[rank] // columns, order[rank] % columns
        x, y = _center(order[rank], columns, origin)
        if rank == 0:
            costs[row, column] = np.hypot(goal[0] - x, goal[1] - y)
        else:
            anchors[row, column], costs[row, column] = _farthest_in_sight(
                row, column, free, origin, goal, seen, anchors, costs
            )


@njit(cache=True)
def _farthest_in_sight(
    row: int,
    column: int,
    free: BoolArray,
    origin: FloatArray,
    goal: FloatArray,
    seen: FloatArray,
    anchors: AnchorArray,
    costs: FloatArray,
) -> tuple[int, float]:
    """Anchor and cost of the best way from a cell: by a neighbor's anchor or by the neighbor."""
    rows, columns = free.shape
    x, y = _center(row * columns + column, columns, origin)
    best, chosen = np.inf, DIRECT
    for near_row in range(max(row - 1, 0), min(row + 2, rows)):
        for near_column in range(max(column - 1, 0), min(column + 2, columns)):
            rest = costs[near_row, near_column]
            if not np.isfinite(rest):
                continue
            near = near_row * columns + near_column
            near_x, near_y = _center(near, columns, origin)
            cost = np.hypot(near_x - x, near_y - y) + rest
            if cost < best:
                best, chosen = cost, near
            anchor = anchors[near_row, near_column]
            if anchor == DIRECT:
                cost, aim_x, aim_y = np.hypot(goal[0] - x, goal[1] - y), seen[0], seen[1]
            else:
                aim_x, aim_y = _center(anchor, columns, origin)
                rest = costs[anchor // columns, anchor % columns]
                cost = np.hypot(aim_x - x, aim_y - y) + rest
            if cost < best and _in_sight(free, origin, x, y, aim_x, aim_y):
                best, chosen = cost, anchor
    return chosen, best


@njit(cache=True)
def _in_sight(
    free: BoolArray, origin: FloatArray, x: float, y: float, aim_x: float, aim_y: float
) -> bool:
    """Whether all cells on the line are free, looked at once per cell's width."""
    count = int(np.ceil(np.hypot(aim_x - x, aim_y - y) / CELL))
    for index in range(1, count + 1):
        t = index / count
        row, column = cell_of(free.shape, origin, x + t * (aim_x - x), y + t * (aim_y - y))
        if not free[row, column]:
            return False
    return True
