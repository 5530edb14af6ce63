"""Rooms that empty through doors, and crowds that go round corners."""

from functools import cache

import crowds
import numpy as np


def room_with_doors(doors, width, corners):
    """Walls of a box x_min, y_min, x_max, y_max with doors in its long sides.

    Args:
        doors: (x, y) of the doors' middles, each on the lower or upper side.
        width: free width of the doors [m].
        corners: the box.
    """
    x_min, y_min, x_max, y_max = corners
    sides = [crowds.polyline((x, y_min), (x, y_max)) for x in (x_min, x_max)]
    half = width / 2 + 0.05
    for y in (y_min, y_max):
        ends = [x_min]
        for x in sorted(door for door, side in doors if side == y):
            ends += [x - half, x + half]
        ends.append(x_max)
        sides += [
            crowds.polyline((a, y), (b, y)) for a, b in zip(ends[::2], ends[1::2], strict=True)
        ]
    return np.concatenate(sides)


@cache
def emptying_time(seed, doors):
    """RiMEA 9: seconds until 1,000 people have left a room of 30 m by 20 m by four or two doors.

    Everybody takes the nearest of the doors, which are 1 m wide; infinite if somebody stays.
    """
    middles = [(-7.5, -10.0), (7.5, -10.0), (-7.5, 10.0), (7.5, 10.0)][:doors]
    rng = np.random.default_rng((seed, 9))
    place = crowds.fill(rng, (-14.5, -9.5, 14.5, 9.5), 1000 / (29 * 19))[:1000]
    nearest = np.linalg.norm(place[:, None] - np.array(middles), axis=-1).argmin(axis=1)
    door = np.array(middles)[nearest]
    outward = np.sign(door[:, 1:]) * [0.0, 1.0]
    waypoints = crowds.by_way_of(place, door + 1.2 * outward, door + 600.0 * outward)
    walls = room_with_doors(middles, 1.0, (-15.0, -10.0, 15.0, 10.0))
    start = crowds.scenario(seed, place, waypoints, walls=walls)

    def is_empty(positions):
        return (np.abs(positions[:, 1]) > 10.0).all()

    tracks = crowds.walk(start, seed, 500.0, every=4, until=is_empty)
    return float(tracks.times[-1]) if is_empty(tracks.positions[-1]) else np.inf


def door_ratio(seed):
    return emptying_time(seed, 2) / emptying_time(seed, 4)


def second_room(seed):
    """RiMEA 12: seconds from a passage to the next door, against walking there freely.

    150 people leave a room by a passage of 1 m into a second room, 10 m long, with a door of
    1 m; the jam is to be before the passage, not before the door.
    """
    rng = np.random.default_rng((seed, 12))
    place = crowds.fill(rng, (-9.5, -4.5, -0.5, 4.5), 150 / 81)
    first = [(0.0, -0.55), (0.0, -5.0), (-10.0, -5.0), (-10.0, 5.0), (0.0, 5.0), (0.0, 0.55)]
    second = [(0.0, 0.55), (5.0, 0.55), (5.0, 5.0), (15.0, 5.0), (15.0, 0.55)]
    walls = [crowds.polyline(*first)]
    walls += [crowds.polyline(*[(x, s * y) for x, y in second]) for s in (-1, 1)]
    start = crowds.scenario(
        seed, place, crowds.by_way_of(place, (16.2, 0.0), (150.0, 0.0)), walls=np.concatenate(walls)
    )
    tracks = crowds.walk(start, seed, 80.0)
    stay = crowds.crossing_times(tracks, 15.0) - crowds.crossing_times(tracks, 5.0)
    free = 10.0 / start.pedestrians.desired_speed
    return float(np.nanmean(stay / free))


def mean_way_time(seed, walls, goal, line, people=150):
    """Mean seconds that a crowd before the origin of a 4 m wide corridor needs to get to a line.

    Args:
        seed: of the crowd.
        walls: of the corridor.
        goal: `(2,)` beyond the line.
        line: axis that it crosses, and where [m].
    """
    rng = np.random.default_rng((seed, 15))
    place = crowds.fill(rng, (-20.0, -1.9, -2.5, 1.9), people / 66.5)
    start = crowds.scenario(seed, place, np.broadcast_to(goal, place.shape), walls=walls)
    axis, end = line
    tracks = crowds.walk(start, seed, 150.0, until=lambda p: (p[:, axis] > end).all())
    along = crowds.Tracks(tracks.positions[:, :, [axis, 1 - axis]], tracks.dt)
    return float(crowds.crossing_times(along, end).mean())


def crowd_round_a_corner(seed):
    """RiMEA 15: mean time of 150 people round a corner, between two straight ways.

    0 is as long as straight on over the length of the inner side, 1 over that of the outer side.
    """
    outer = [(-22.0, -2.05), (12.05, -2.05), (12.05, 32.0)]
    inner = [(-22.0, 2.05), (7.95, 2.05), (7.95, 32.0)]
    walls = np.concatenate([crowds.polyline(*outer), crowds.polyline(*inner)])
    bend = mean_way_time(seed, walls, (10.0, 30.0), (1, 12.0))
    times = []
    for length in (7.95 + 9.95, 12.05 + 14.05):
        walls = crowds.corridor(-22.0, length + 20.0, 4.0)
        times.append(mean_way_time(seed, walls, (length + 18.0, 0.0), (0, length)))
    return (bend - times[0]) / (times[1] - times[0])


SPEEDS = (0.6, 0.9, 1.3, 1.8, 2.4, 3.2, 4.2)


@cache
def hurried_time(seed, speed):
    """Seconds until 100 people who all want to be so fast have left by a door of 1 m."""
    rng = np.random.default_rng((seed, 16))
    place = crowds.fill(rng, (-9.0, -3.9, -0.7, 3.9), 100 / (8.3 * 7.8))
    room = [(0.0, 0.55), (0.0, 4.5), (-9.5, 4.5), (-9.5, -4.5), (0.0, -4.5), (0.0, -0.55)]
    walls = crowds.polyline(*room)
    waypoints = crowds.by_way_of(place, (1.2, 0.0), (600.0, 0.0))
    start = crowds.scenario(seed, place, waypoints, walls=walls, desired_speed=speed)
    tracks = crowds.walk(start, seed, 200.0, until=lambda p: (p[:, 0] > 0.0).all())
    return float(tracks.times[-1])


def fastest_interior(seed):
    """Faster is slower: seconds that the highest speed loses against the best one in between."""
    times = [hurried_time(seed, speed) for speed in SPEEDS]
    return min(times[0], times[-1]) - min(times[1:-1])
