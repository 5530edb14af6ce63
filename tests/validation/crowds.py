"""Placing crowds in simple buildings, running them, and handing their tracks to PedPy."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import pedpy
import shapely

from crowdsim.forces import SocialForce
from crowdsim.map import Map
from crowdsim.pedestrians import Pedestrians
from crowdsim.scenario import Scenario
from crowdsim.world import World

MODEL = SocialForce()
"""What all cases run with: the defaults."""

FAR = (1e3, 1e3)
"""Where the robot of a scenario is said to be; no case has one."""


@dataclass(frozen=True)
class Tracks:
    """Positions `(T, N, 2)` [m] of everybody, and the seconds between two rows."""

    positions: np.ndarray
    dt: float

    @property
    def times(self):
        """Seconds of the rows `(T,)`."""
        return self.dt * np.arange(len(self.positions))

    @property
    def velocities(self):
        """Mean velocities between rows `(T - 1, N, 2)` [m/s]."""
        return np.diff(self.positions, axis=0) / self.dt

    def pedpy(self, first=0.0, last=np.inf):
        """Rows between two times [s] as PedPy takes them."""
        rows = np.flatnonzero((self.times >= first) & (self.times <= last))
        frames, people = np.meshgrid(rows, np.arange(self.positions.shape[1]), indexing="ij")
        table = pd.DataFrame(
            {
                "id": people.ravel(),
                "frame": frames.ravel(),
                "x": self.positions[rows, :, 0].ravel(),
                "y": self.positions[rows, :, 1].ravel(),
            }
        )
        return pedpy.TrajectoryData(data=table, frame_rate=1 / self.dt)


def polyline(*corners):
    """Walls `(S, 2, 2)` along a line of corners."""
    points = np.array(corners, dtype=float)
    return np.stack([points[:-1], points[1:]], axis=1)


def corridor(x_min, x_max, width):
    """Two walls along x with `width` [m] of free ground between their surfaces."""
    y = width / 2 + 0.05
    return np.concatenate([polyline((x_min, s * y), (x_max, s * y)) for s in (-1, 1)])


def fill(rng, box, density, *, jitter=0.25):
    """Places `(N, 2)` on a shaken hexagonal lattice in a box x_min, y_min, x_max, y_max [m].

    Args:
        rng: source of the jitter.
        box: where.
        density: people per square metre.
        jitter: largest shift, in lattice spacings that bodies of 0.5 m leave free.
    """
    x_min, y_min, x_max, y_max = box
    count = round(density * (x_max - x_min) * (y_max - y_min))
    spacing = np.sqrt(2 / (np.sqrt(3) * density))
    columns = max(1, round((y_max - y_min) / spacing))
    rows = -(-count // columns)
    index = np.arange(count)
    row, column = index // columns, index % columns
    x = x_min + (row + 0.5) * (x_max - x_min) / rows
    y = y_min + (column + 0.25 + 0.5 * (row % 2)) * (y_max - y_min) / columns
    shift = rng.uniform(-1, 1, (count, 2)) * max(jitter * (spacing - 0.4), 0.01)
    return np.stack([x, y], axis=1) + shift


def by_way_of(place, door, goal):
    """Waypoints `(N, 2, 2)` for all at `place (N, 2)`: through a door, then far away.

    The door's point lies so far behind it that the walls are no longer in the way.
    """
    return np.stack([np.broadcast_to(door, place.shape), np.broadcast_to(goal, place.shape)], 1)


def scenario(seed, position, waypoints, *, walls=None, surfaces=(), **drawn):
    """A scenario without a robot; on arrival people stop.

    Args:
        seed: of what is drawn for the people.
        position: `(N, 2)` starts [m].
        waypoints: `(N, G, 2)` or `(N, 2)` [m].
        walls: `(S, 2, 2)` [m].
        surfaces: of the map.
        drawn: columns of `Pedestrians` to be given instead of drawn, or `on_arrival`.
    """
    walls = np.empty((0, 2, 2)) if walls is None else walls
    changes = {key: drawn.pop(key) for key in ("on_arrival", "entrances") if key in drawn}
    points = np.concatenate([np.reshape(position, (-1, 2)), walls.reshape(-1, 2)])
    low, high = points.min(axis=0) - 1.0, points.max(axis=0) + 1.0
    crowd = Pedestrians.draw(
        np.random.default_rng((seed, 1)), position=position, waypoints=waypoints, **drawn
    )
    return Scenario(
        name="validation",
        map=Map(bounds=(*low, *high), walls=walls, surfaces=surfaces),
        pedestrians=replace(crowd, radius=fitting(crowd.radius, crowd.position)),
        robot_start=(*FAR, 0.0),
        robot_goal=FAR,
        **changes,
    )


def fitting(radius, place, *, overlap=0.04, least=0.1):
    """Radii `(N,)` [m], smaller where people stand closer than that, but for some overlap."""
    apart = np.linalg.norm(place[:, None] - place, axis=-1)
    np.fill_diagonal(apart, np.inf)
    return np.minimum(radius, np.maximum((apart.min(axis=1) + overlap) / 2, least))


def walk(
    start: Scenario,
    seed: int,
    seconds: float,
    *,
    model: SocialForce | None = None,
    every: int = 2,
    until: Callable[[np.ndarray], bool] | None = None,
) -> Tracks:
    """Run a scenario and keep the positions of every so many steps of 0.05 s.

    Args:
        start: what to run.
        seed: of the whims.
        seconds: at most.
        model: parameters, `MODEL` if none are given.
        every: steps between two rows.
        until: stops the run when it says so of the positions `(N, 2)`.
    """
    world = World(start, rng=np.random.default_rng((seed, 2)), social_force=model or MODEL)
    kept = [world.positions]
    for step in range(1, round(seconds / world.physics_dt) + 1):
        world.step()
        if step % every == 0:
            kept.append(world.positions)
            if until is not None and until(kept[-1]):
                break
    return Tracks(np.stack(kept), every * world.physics_dt)


def crossing_times(tracks, x):
    """When everybody first passes a line across x `(N,)` [s], between rows; NaN if never."""
    ahead = tracks.positions[:, :, 0] - x  # (T, N)
    times = np.full(ahead.shape[1], np.nan)
    for person in range(ahead.shape[1]):
        after = np.flatnonzero(ahead[:, person] >= 0)
        if len(after) > 0 and after[0] > 0:
            row = after[0]
            before, now = ahead[row - 1, person], ahead[row, person]
            times[person] = tracks.dt * (row - now / (now - before))
    return times


def gaps(tracks, radius):
    """Least free space between any two bodies in each row `(T,)` [m]; negative is overlap."""
    contact = radius[:, None] + radius
    first, second = np.triu_indices(len(radius), 1)
    apart = tracks.positions[:, first] - tracks.positions[:, second]
    return (np.linalg.norm(apart, axis=-1) - contact[first, second]).min(axis=1)


def area(x_min, y_min, x_max, y_max):
    """PedPy's measurement area of a box."""
    return pedpy.MeasurementArea(shapely.box(x_min, y_min, x_max, y_max))
