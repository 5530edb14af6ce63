"""One person, two, and a few: what can be foretold by hand."""

from dataclasses import replace
from functools import cache

import crowds
import numpy as np

from crowdsim.recordings.surfaces import Surface

CALM = replace(crowds.MODEL, whim=0.0)


@cache
def corridor_times(seed):
    """RiMEA 1: seconds for 40 m at 1.33 m/s, along x and in the same corridor turned by 45 degrees.

    Without whims, which know no corridor and would differ between the two.
    """
    turn = np.array([[1.0, 1.0], [-1.0, 1.0]]) / np.sqrt(2)  # rows are turned by +45 degrees
    y = np.random.default_rng((seed, 3)).uniform(-0.5, 0.5)
    walls = crowds.corridor(-1.0, 44.0, 2.0)
    times = []
    for frame in (np.eye(2), turn):
        start = crowds.scenario(
            seed,
            np.array([[-0.5, y]]) @ frame,
            np.array([[43.0, y]]) @ frame,
            walls=walls @ frame,
            desired_speed=1.33,
        )
        tracks = crowds.walk(start, seed, 45.0, model=CALM)
        along = crowds.Tracks(tracks.positions @ frame.T, tracks.dt)
        times.append(
            float((crowds.crossing_times(along, 40.0) - crowds.crossing_times(along, 0.0))[0])
        )
    return times


def corridor_time(seed):
    return corridor_times(seed)[0]


def turned_corridor(seed):
    straight, turned = corridor_times(seed)
    return abs(turned - straight)


def hidden_people(seed):
    """Sideways shift [m] of a walker by five people who stand behind the wall beside the way."""
    rng = np.random.default_rng((seed, 4))
    behind = np.stack([np.linspace(2.0, 8.0, 5) + rng.uniform(-0.5, 0.5, 5), np.full(5, -0.35)], 1)
    walls = crowds.polyline((-2.0, 0.0), (12.0, 0.0))
    ways = []
    for others in (behind[:0], behind):
        place = np.concatenate([[[-1.0, 0.5]], others])
        goal = np.concatenate([[[11.0, 0.5]], others])
        start = crowds.scenario(seed, place, goal, walls=walls, desired_speed=1.3, radius=0.25)
        ways.append(crowds.walk(start, seed, 8.0, model=CALM).positions[:, 0])
    return float(np.abs(ways[0][:, 1] - ways[1][:, 1]).max())


def overtaking(seed):
    """Least free space [m] while three fast walkers pass three slow ones in a corridor of 2.4 m."""
    rng = np.random.default_rng((seed, 6))
    slow = np.stack([[6.0, 9.0, 12.0], rng.uniform(-0.6, 0.6, 3)], axis=1)
    fast = np.stack([[0.0, 1.5, 3.0], rng.uniform(-0.6, 0.6, 3)], axis=1)
    place = np.concatenate([slow, fast])
    start = crowds.scenario(
        seed,
        place,
        place * [0.0, 1.0] + [60.0, 0.0],
        walls=crowds.corridor(-2.0, 62.0, 2.4),
        desired_speed=[0.6, 0.6, 0.6, 1.5, 1.5, 1.5],
    )
    tracks = crowds.walk(start, seed, 30.0, every=1)
    ahead = tracks.positions[-1, 3:, 0].min() - tracks.positions[-1, :3, 0].max()
    least = float(crowds.gaps(tracks, start.pedestrians.radius).min())
    return least if ahead > 0 else -np.inf


def queueing(seed):
    """Least free space [m] in a queue of ten behind somebody slow who cannot be passed."""
    place = np.stack([np.arange(11) * -1.0, np.zeros(11)], axis=1)
    place += np.random.default_rng((seed, 7)).uniform(-0.02, 0.02, place.shape)
    start = crowds.scenario(
        seed,
        place,
        place * [0.0, 1.0] + [40.0, 0.0],
        walls=crowds.corridor(-14.0, 42.0, 0.65),
        desired_speed=np.where(np.arange(11) == 0, 0.4, 1.34),
    )
    tracks = crowds.walk(start, seed, 60.0, every=1)
    return float(crowds.gaps(tracks, start.pedestrians.radius).min())


def corner(seed):
    """RiMEA 6: positions inside the block while 20 people go round its corner, and stragglers."""
    rng = np.random.default_rng((seed, 8))
    place = crowds.fill(rng, (-6.0, 0.2, -1.0, 1.8), 2.5)
    goal = np.broadcast_to([11.0, 16.0], place.shape)
    block = np.array([[-8.0, 2.0], [10.0, 2.0], [10.0, 20.0], [-8.0, 20.0]])
    outer = crowds.polyline((-8.0, 0.0), (12.0, 0.0), (12.0, 20.0))
    start = crowds.scenario(seed, place, goal, walls=outer, surfaces=((Surface.BUILDING, block),))
    tracks = crowds.walk(start, seed, 40.0)
    inside = ~start.map.walkable(tracks.positions)
    stragglers = (tracks.positions[:, :, 1] > 4.0).any(axis=0) == 0
    return int(inside.sum() + stragglers.sum())
