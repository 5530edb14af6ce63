"""How simulated walkers move beside recorded ones: speed, acceleration, distance, curvature."""

from functools import cache

import crowds
import numpy as np

from crowdsim.groups import abreast, draw_groups
from crowdsim.pedestrians import ALONE
from crowdsim.recordings.eth_ucy import read_scene

MOVING = 0.3
"""Only people at least this fast count, for standing is a choice and not a motion [m/s]."""

IN_GROUPS = 0.7
"""Share of people in groups: in crowds_zara01 102 of 148 (its groups.txt)."""

QUANTITIES = (
    "speed [m/s]",
    "acceleration [m/s²]",
    "distance to the nearest [m]",
    "path curvature [1/m]",
)


def motions(positions, valid, dt):
    """Samples of the four `QUANTITIES`, of everybody who is moving, at any time.

    Args:
        positions: `(T, N, 2)` [m].
        valid: `(T, N)`.
        dt: seconds between rows.
    """
    velocity = np.diff(positions, axis=0) / dt
    speed = np.linalg.norm(velocity, axis=-1)
    change = np.diff(velocity, axis=0) / dt  # (T - 2, N, 2)
    mean = (velocity[1:] + velocity[:-1]) / 2
    cross = mean[..., 0] * change[..., 1] - mean[..., 1] * change[..., 0]
    moving = valid[2:] & valid[1:-1] & valid[:-2]
    moving &= (speed[1:] > MOVING) & (speed[:-1] > MOVING)
    apart = np.linalg.norm(positions[1:-1, :, None] - positions[1:-1, None], axis=-1)
    apart[~(valid[1:-1, :, None] & valid[1:-1, None])] = np.inf
    apart[:, np.arange(valid.shape[1]), np.arange(valid.shape[1])] = np.inf
    nearest = apart.min(axis=-1)
    slowness = np.maximum(np.linalg.norm(mean, axis=-1), MOVING)
    return (
        speed[1:][moving],
        np.linalg.norm(change, axis=-1)[moving],
        nearest[moving & np.isfinite(nearest)],
        (np.abs(cross) / slowness**3)[moving],
    )


@cache
def recorded(scene):
    """Samples of a recorded scene, `crowds_zara01` for one."""
    recording = read_scene(None, scene)
    return motions(recording.positions, recording.valid, recording.dt)


@cache
def simulated(seed, density=0.1, seconds=120.0):
    """Samples of a simulated street 14 m by 9 m at the density of Zara, walked along both ways.

    As there, most people walk in groups, who start and enter side by side.
    """
    rng = np.random.default_rng((seed, 30))
    place = crowds.fill(rng, (-7.0, -4.0, 7.0, 4.0), density)
    group = draw_groups(rng, len(place), IN_GROUPS)
    sign = rng.choice([-1.0, 1.0], len(place))[:, None]
    across = rng.uniform(-4.0, 4.0, (len(place), 1)) * [0.0, 1.0]
    for number in np.unique(group[group != ALONE]):
        members = np.flatnonzero(group == number)
        sign[members], across[members] = sign[members[0]], across[members[0]]
        place[members] = abreast(place[members[0]], 0.0, len(members))
    across += place * [0.0, 1.0]
    start = crowds.scenario(
        seed,
        place,
        sign * [9.0, 0.0] + across,
        on_arrival="respawn",
        entrances=-sign * [9.0, 0.0] + place * [0.0, 1.0],
        group=group,
    )
    tracks = crowds.walk(start, seed, seconds, every=8)
    valid = (np.abs(tracks.positions) < (7.5, 6.0)).all(axis=-1)
    return motions(tracks.positions, valid, tracks.dt)
