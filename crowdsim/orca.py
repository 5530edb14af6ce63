"""Optimal reciprocal collision avoidance: the velocity nearest to the wanted one that hits nobody.

Van den Berg, Guy, Lin and Manocha, "Reciprocal n-body collision avoidance", 2011. With x the way
from a to b, v = v_a - v_b, r the sum of the radii and T the time horizon, a and b meet within T if
v lies in the velocity obstacle, the cone of all discs with centre x / t and radius r / t, t <= T.
If it does, u is the smallest change that brings v to the border, where n points outwards, and a
takes its share s of it:

    permitted for a: (v - (v_a + s u)) . n >= 0

s is one half between two who both give way, and one against who does not. Walls permit no velocity
that reaches their nearest point within their own, shorter time horizon T_w: (D - r) / T_w is the
speed towards a wall at distance D (the paper takes the whole cone of every wall instead; at a
wall's end this is a little stricter, so that people slow down in doors).

Our own, because the one package with wheels on the index, pyrvo, brings a second simulator along,
moves its agents by its own clock, knows neither contacts nor other models beside its own, and is
steered and read agent by agent (`crowdnav benchmark` times it).
"""

import math
from dataclasses import astuple, dataclass, fields

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.bodies import WALL_RADIUS
from crowdsim.cell_list import build_cell_list
from crowdsim.distance_field import distance_to_segment
from crowdsim.half_planes import breach, nearest_permitted
from crowdsim.line_of_sight import Screens, is_hidden, nearest_walls
from crowdsim.velocity_obstacle import way_out

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
RecordArray = NDArray[np.void]


@dataclass(frozen=True, kw_only=True)
class Orca:
    """Parameters of the model.

    Attributes:
        horizon: T, people avoid whom they would meet within it [s].
        wall_horizon: T_w, likewise for walls [s].
        interaction_range: people farther apart than this ignore each other [m].
        neighbors: at most so many are looked at, the nearest ones, seen or hidden.
        wavering: deviation from the chosen velocity in each step, which breaks perfect symmetry
            [m/s].
        max_acceleration: how hard people change their velocity [m/s^2].
    """

    horizon: float = 3.0
    wall_horizon: float = 0.5
    interaction_range: float = 6.0
    neighbors: int = 10
    wavering: float = 0.05
    max_acceleration: float = 5.0

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ValueError: if a parameter is not finite, or not positive (`wavering` may be 0).
        """
        for name, value in zip((f.name for f in fields(self)), astuple(self), strict=True):
            if not (np.isfinite(value) and (value > 0 or (name == "wavering" and value == 0))):
                raise ValueError(f"{name}: expected a finite value > 0, found {value}")

    def record(self) -> RecordArray:
        """Give the parameters as the one-row record array that the kernels take."""
        dtype = [(f.name, np.int64 if f.name == "neighbors" else np.float64) for f in fields(self)]
        return np.array([astuple(self)], dtype=dtype)


@njit(cache=True)
def avoid(
    gives_way: BoolArray,
    takes_part: BoolArray,
    notices_robot: BoolArray,
    bodies: FloatArray,
    present: BoolArray,
    radius: FloatArray,
    direction: FloatArray,
    desired_speed: FloatArray,
    max_speed: FloatArray,
    noise: FloatArray,
    dt: float,
    walls: FloatArray,
    wall_grid: FloatArray,
    wall_origin: FloatArray,
    wall_cell: float,
    screens: Screens,
    model: RecordArray,
    acceleration: FloatArray,
) -> None:
    """Write the accelerations that bring those who take part to their permitted velocities.

    Args:
        gives_way: `(M,)` whose half of the evasion can be counted on.
        takes_part: `(N,)` who moves by this model.
        notices_robot: `(N,)` who of them is aware of the robot.
        bodies: `(M, 4)` x, y, vx, vy; the N pedestrians first, then perhaps the robot.
        present: `(M,)` who is there.
        radius: `(M,)` [m].
        direction: `(M, 2)` wanted direction, shorter than 1 for who wants to be slow.
        desired_speed: `(N,)` [m/s].
        max_speed: `(N,)` [m/s].
        noise: `(N, 2)` standard normal draws for this step.
        dt: its length [s].
        walls: `(S, 2, 2)` segments [m].
        wall_grid: `(H, W, 3)` grid of their `DistanceField`.
        wall_origin: `(2,)` its origin [m].
        wall_cell: its spacing [m].
        screens: the walls, listed for looks over the interaction range.
        model: parameters, as `Orca.record` gives them.
        acceleration: `(M, 2)` [m/s^2], changed in place.
    """
    members, starts, columns = build_cell_list(bodies, present, model[0].interaction_range)
    planes = np.empty((len(walls) + model[0].neighbors, 4))
    neighbors = np.empty(model[0].neighbors, dtype=np.int64)
    nearest = nearest_walls(bodies, wall_grid, wall_origin, wall_cell)
    for cell in range(len(starts) - 1):
        for i in members[starts[cell] : starts[cell + 1]]:
            if i >= len(takes_part) or not takes_part[i]:
                continue
            reach = radius[i] + WALL_RADIUS + max_speed[i] * model[0].wall_horizon
            firm = 0
            # A cell of the grid more, for between its points the distance is interpolated.
            if nearest[i, 0] <= reach + wall_cell:
                firm = wall_planes(bodies[i], radius[i], reach, walls, model, planes)
            seen = len(bodies) if notices_robot[i] else len(takes_part)
            cells = cell, members, starts, columns
            found = _find_neighbors(i, seen, *cells, bodies, model, neighbors)
            for k in range(found):
                j = neighbors[k]
                share = 0.5 if gives_way[j] else 1.0
                planes[firm + k] = person_plane(
                    bodies[i], bodies[j], radius[i] + radius[j], share, model[0].horizon, dt
                )
            wanted = desired_speed[i] * direction[i, 0], desired_speed[i] * direction[i, 1]
            people = neighbors[:found]
            vx, vy = _heed_seen(
                i, *wanted, max_speed[i], planes, firm, people, bodies, nearest, screens
            )
            # Two who block each other in a door would wait for ever: none may go first.
            change_x = (vx + model[0].wavering * noise[i, 0] - bodies[i, 2]) / dt
            change_y = (vy + model[0].wavering * noise[i, 1] - bodies[i, 3]) / dt
            change = math.hypot(change_x, change_y)
            scale = min(1.0, model[0].max_acceleration / change) if change > 0 else 0.0
            acceleration[i] = change_x * scale, change_y * scale


@njit(cache=True)
def person_plane(
    body: FloatArray, other: FloatArray, contact: float, share: float, horizon: float, dt: float
) -> tuple[float, float, float, float]:
    """Half-plane (px, py, nx, ny) of the velocities with which a body avoids another.

    Args:
        body: `(4,)` x, y, vx, vy of who avoids.
        other: `(4,)` of who is avoided.
        contact: sum of the radii [m].
        share: of the evasion that `body` takes.
        horizon: T [s].
        dt: time in which those who overlap part [s].
    """
    vx, vy = body[2] - other[2], body[3] - other[3]
    ux, uy, nx, ny = way_out(other[0] - body[0], other[1] - body[1], vx, vy, contact, horizon, dt)
    return body[2] + share * ux, body[3] + share * uy, nx, ny


@njit(cache=True)
def wall_planes(
    body: FloatArray,
    radius: float,
    reach: float,
    walls: FloatArray,
    model: RecordArray,
    planes: FloatArray,
) -> int:
    """Write the half-planes of the walls within `reach` [m] of a body; gives how many there are."""
    count = 0
    for index in range(len(walls)):
        distance, away_x, away_y = distance_to_segment(body[0], body[1], walls[index])
        if 0 < distance <= reach:
            nx, ny = away_x / distance, away_y / distance
            towards = (distance - radius - WALL_RADIUS) / model[0].wall_horizon
            planes[count] = -towards * nx, -towards * ny, nx, ny
            count += 1
    return count


@njit(cache=True)
def _heed_seen(
    body: int,
    wanted_x: float,
    wanted_y: float,
    max_speed: float,
    planes: FloatArray,
    firm: int,
    neighbors: IntArray,
    bodies: FloatArray,
    nearest: FloatArray,
    screens: Screens,
) -> tuple[float, float]:
    """Velocity nearest to the wanted one that those half-planes permit whose people are seen.

    Looking through the map costs more than the linear programme. So people are only looked for
    when their half-plane is broken; then it joins the programme, or drops out behind a wall.
    """
    used, end = firm, firm + len(neighbors)
    while True:
        x, y = nearest_permitted(planes, used, firm, wanted_x, wanted_y, max_speed)
        heeded, k = used, used
        while k < end:
            if breach(planes[k], x, y) <= 0:
                k += 1
            elif _is_hidden(body, neighbors[k - firm], bodies, nearest, screens):
                end -= 1
                planes[k], neighbors[k - firm] = planes[end], neighbors[end - firm]
            else:
                _swap(k, used, firm, planes, neighbors)
                used, k = used + 1, k + 1
        if used == heeded:
            return x, y


@njit(cache=True)
def _is_hidden(
    a: int,
    b: int,
    bodies: FloatArray,
    nearest: FloatArray,
    screens: Screens,
) -> bool:
    dx, dy = bodies[b, 0] - bodies[a, 0], bodies[b, 1] - bodies[a, 1]
    room = nearest[a, 0] + nearest[b, 0]
    if dx * dx + dy * dy <= room * room:
        return False
    return is_hidden(screens, bodies[a, 0], bodies[a, 1], bodies[b, 0], bodies[b, 1])


@njit(cache=True)
def _swap(a: int, b: int, firm: int, planes: FloatArray, neighbors: IntArray) -> None:
    """Let two half-planes of people change places."""
    for column in range(4):
        planes[a, column], planes[b, column] = planes[b, column], planes[a, column]
    neighbors[a - firm], neighbors[b - firm] = neighbors[b - firm], neighbors[a - firm]


@njit(cache=True)
def _find_neighbors(
    body: int,
    seen: int,
    cell: int,
    members: IntArray,
    starts: IntArray,
    columns: int,
    bodies: FloatArray,
    model: RecordArray,
    neighbors: IntArray,
) -> int:
    """Write who of the first `seen` bodies are nearest, nearest first; gives how many they are."""
    count, most = 0, len(neighbors)
    far = np.full(most, model[0].interaction_range ** 2)
    left, right = min(cell % columns, 1), min(columns - 1 - cell % columns, 1)
    for middle in (cell - columns, cell, cell + columns):
        if not 0 <= middle < len(starts) - 1:
            continue
        for other in members[starts[middle - left] : starts[middle + right + 1]]:
            dx, dy = bodies[other, 0] - bodies[body, 0], bodies[other, 1] - bodies[body, 1]
            squared = dx * dx + dy * dy
            if other == body or other >= seen or squared >= far[-1]:
                continue
            place = min(count, most - 1)
            while place > 0 and far[place - 1] > squared:
                far[place], neighbors[place] = far[place - 1], neighbors[place - 1]
                place -= 1
            far[place], neighbors[place] = squared, other
            count = min(count + 1, most)
    return count
