"""Recorded crowds simulated anew: everybody starts where they were, and goes where they went.

Every few seconds of an ETH/UCY scene the people who are seen then are put into a world on the
scene's map, with the velocity that they had, the place where they are last seen as goal, their own
mean speed as desired speed, and the groups that the data name. The world runs for 4.8 s, the length
of a usual forecast, and is compared with what these people did: how fast they walk and speed up,
how near they come to each other, how their ways bend, and where they are. Goals and speeds are
taken from the future: this measures the forces, it is no forecast.
"""

from dataclasses import dataclass, replace
from functools import cache

import crowds
import numpy as np
import real_crowds
from scipy import stats

from crowdsim.maps import eth_ucy_map
from crowdsim.pedestrians import ALONE, Pedestrians
from crowdsim.recordings import FRAME_DT, find_data, read_scene
from crowdsim.scenario import Scenario
from crowdsim.world import World

FITTED = ("crowds_zara02", "students003")
HELD_OUT = ("crowds_zara01", "biwi_hotel")
"""Scenes at the true 0.4 s whose groups are known."""

ROWS = 12
"""Rows of 0.4 s that are simulated."""

STANDING = 0.1
"""Who is slower than this on average wants to stand [m/s]."""


@dataclass(frozen=True)
class Start:
    """A scenario, and what happened next: positions `(ROWS + 1, N, 2)` [m], `valid` likewise."""

    scenario: Scenario
    positions: np.ndarray
    valid: np.ndarray


@cache
def recording(scene):
    return read_scene(None, scene).regular()


def groups_of(scene, ids):
    """Number of the group of each of `ids (N,)`; `ALONE` for who has none."""
    lines = (find_data() / "scenes" / scene / "groups.txt").read_text(encoding="utf-8").split("\n")
    number = {int(who): k for k, line in enumerate(lines) for who in line.split()}
    return np.array([number.get(who, ALONE) for who in ids.tolist()], dtype=np.int64)


@cache
def starts(scene, every, grouped=True):
    """Starts every so many rows of a scene, at least two people each, in their groups or alone."""
    crowd, world_map = recording(scene), eth_ucy_map(None, scene)
    group = groups_of(scene, crowd.ids) if grouped else np.full(len(crowd.ids), ALONE)
    walked = crowd.positions[crowd.valid]
    spot = walked[world_map.walkable(walked)][0]
    rows = range(1, len(crowd.positions) - ROWS, every)
    seen = [(row, np.flatnonzero(crowd.valid[row - 1 : row + 2].all(axis=0))) for row in rows]
    return [start_at(crowd, world_map, spot, group, row, who) for row, who in seen if len(who) > 1]


def start_at(crowd, world_map, spot, group, row, who):
    """The `Start` of people `who (N,)` at a row, members of a group in consecutive rows.

    A scenario wants a place for a robot, though no world of these has one: the walkable `spot`.
    """
    who = who[np.argsort(group[who], kind="stable")]
    place = crowd.positions[row, who]
    last = len(crowd.valid) - 1 - crowd.valid[::-1, who].argmax(axis=0)
    speed = mean_speeds(crowd, who)
    stands = speed < STANDING
    # Who stands has a goal all the same, but far away: nobody is to arrive, and leave.
    far = place[np.linalg.norm(place[:, None] - place, axis=-1).argmax(axis=1)]
    people = Pedestrians.draw(
        np.random.default_rng(row),
        position=place,
        waypoints=np.where(stands[:, None], far, crowd.positions[last, who]),
        desired_speed=np.where(stands, 0.0, speed),
        group=group[who],
    )
    velocity = (place - crowd.positions[row - 1, who]) / FRAME_DT
    radius = crowds.fitting(people.radius, place, overlap=0.0)
    scenario = Scenario(
        name="resimulation",
        map=world_map,
        pedestrians=replace(people, velocity=velocity, radius=radius),
        robot_start=(*spot, 0.0),
        robot_goal=tuple(spot),
        on_arrival="leave",
    )
    later = slice(row, row + ROWS + 1)
    return Start(scenario, crowd.positions[later][:, who], crowd.valid[later][:, who])


def mean_speeds(crowd, who):
    """Mean speed `(N,)` [m/s] of people over all of their tracks."""
    step = np.linalg.norm(np.diff(crowd.positions[:, who], axis=0), axis=-1) / FRAME_DT
    seen = crowd.valid[1:, who] & crowd.valid[:-1, who]
    return (step * seen).sum(axis=0) / seen.sum(axis=0)


def simulate(start, seed, model):
    """Positions and `valid` `(ROWS + 1, N)` of a start run with a `SocialForce`."""
    world = World(start.scenario, rng=np.random.default_rng((seed, 40)), social_force=model)
    rows = [(world.positions, world.valid)]
    for _ in range(ROWS):
        for _ in range(round(FRAME_DT / world.physics_dt)):
            world.step()
        rows.append((world.positions, world.valid))
    return tuple(np.stack(column) for column in zip(*rows, strict=True))


@dataclass(frozen=True)
class Comparison:
    """Samples of `real_crowds.QUANTITIES`, real and simulated, and displacement errors [m].

    Attributes:
        real: samples of each quantity.
        made: likewise.
        error: mean distance of simulated from real people over 4.8 s.
        plain_error: the same for people who keep the velocity that they start with.
    """

    real: tuple
    made: tuple
    error: float
    plain_error: float

    def distances(self):
        """Kolmogorov-Smirnov distance of each quantity, 0 to 1."""
        return [stats.ks_2samp(a, b).statistic for a, b in zip(self.real, self.made, strict=True)]

    def loss(self):
        """Mean distance, plus the error against the plain one."""
        return float(np.mean(self.distances()) + self.error / self.plain_error)


def compare(scenes, model, *, every=25, seed=0, grouped=True):
    """Simulate scenes anew, from a start every so many rows, and compare."""
    real, made, errors, plain = [], [], [], []
    for start in (start for scene in scenes for start in starts(scene, every, grouped)):
        positions, valid = simulate(start, seed, model)
        both = valid & start.valid
        real.append(real_crowds.motions(start.positions, start.valid, FRAME_DT))
        made.append(real_crowds.motions(positions, both, FRAME_DT))
        stays = both.all(axis=0)
        errors.append(displacements(positions, start.positions)[stays])
        kept = start.scenario.pedestrians.velocity * FRAME_DT * np.arange(ROWS + 1)[:, None, None]
        plain.append(displacements(start.positions[0] + kept, start.positions)[stays])
    samples = [
        tuple(np.concatenate(column) for column in zip(*side, strict=True)) for side in (real, made)
    ]
    return Comparison(
        *samples, float(np.concatenate(errors).mean()), float(np.concatenate(plain).mean())
    )


def displacements(positions, others):
    """Mean distance `(N,)` over the rows after the first [m]."""
    return np.linalg.norm(positions - others, axis=-1)[1:].mean(axis=0)
