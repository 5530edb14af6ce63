"""Two streams against each other: lanes, and a door that both want."""

from functools import cache

import crowds
import numpy as np

LENGTH, WIDTH = 24.0, 4.0


@cache
def counterflow(seed, density=0.8, seconds=60.0):
    """Tracks of two streams that enter again where they came from, and who goes to the right."""
    rng = np.random.default_rng((seed, 20))
    place = crowds.fill(rng, (-LENGTH / 2, -1.7, LENGTH / 2, 1.7), density)
    right = rng.permutation(len(place)) % 2 == 0
    sign = np.where(right, 1.0, -1.0)[:, None]
    ahead = sign * [LENGTH / 2, 0.0] + place * [0.0, 1.0]
    entrances = -sign * [LENGTH / 2, 0.0] + place * [0.0, 1.0]
    start = crowds.scenario(
        seed,
        place,
        ahead,
        walls=crowds.corridor(-LENGTH / 2 - 2, LENGTH / 2 + 2, WIDTH),
        on_arrival="respawn",
        entrances=entrances,
    )
    return crowds.walk(start, seed, seconds, every=10), right


def lane_order(positions, right, strip=0.5):
    """Order of rows `(T, N, 2)`: mean over people of ((n+ - n-) / (n+ + n-))^2 in their strip.

    Rex and Löwen 2007: 1 when all in a strip along the corridor walk one way, near 0 when mixed.
    """
    orders = []
    for row in positions:
        seen = np.abs(row[:, 0]) < LENGTH / 2
        strips = np.floor(row[seen, 1] / strip).astype(int) + 50
        plus = np.bincount(strips[right[seen]], minlength=100)
        minus = np.bincount(strips[~right[seen]], minlength=100)
        both = np.maximum(plus + minus, 1)
        order = ((plus - minus) / both) ** 2
        orders.append((order * (plus + minus)).sum() / max((plus + minus).sum(), 1))
    return np.array(orders)


def growth_of_lanes(seed):
    """Lane order in the last 10 s less that in the first second."""
    tracks, right = counterflow(seed)
    order = lane_order(tracks.positions, right)
    return float(order[tracks.times >= tracks.times[-1] - 10.0].mean() - order[:3].mean())


def counterflow_speed(seed, density=2.0):
    """Mean speed along the corridor [m/s] at 2 /m^2, half of the people each way."""
    tracks, right = counterflow(seed, density, 20.0)
    velocity = tracks.velocities[:, :, 0] * np.where(right, 1.0, -1.0)
    seen = (np.abs(tracks.positions[:-1, :, 0]) < 6.0) & (np.abs(velocity) < 3.0)
    late = tracks.times[:-1] > 5.0
    return float(velocity[late][seen[late]].mean())


def two_way_door(seed):
    """People per second through a door of 1 m, both ways together, 20 on each side."""
    rng = np.random.default_rng((seed, 22))
    left = crowds.fill(rng, (-7.0, -2.0, -2.0, 2.0), 1.0)
    place = np.concatenate([left, left * [-1.0, 1.0]])
    side = np.where(place[:, :1] < 0, 1.0, -1.0)
    goal = side * [8.0, 0.0]
    walls = np.concatenate([crowds.polyline((0.0, s * 0.55), (0.0, s * 8.0)) for s in (-1, 1)])
    start = crowds.scenario(seed, place, goal, walls=walls)
    tracks = crowds.walk(start, seed, 120.0, until=lambda p: (p * side > 0.3)[:, 0].all())
    through = np.array(
        [crowds.crossing_times(crowds.Tracks(tracks.positions * side, tracks.dt), 0.0)]
    )
    times = np.sort(through[np.isfinite(through)])
    return float((len(times) - 1) / (times[-1] - times[0])) if len(times) > 10 else 0.0
