"""People who walk along ways, alone or in groups, and where on them they start.

A way is a line of points (1 + G, 2) [m]: the entrance, and the waypoints after it. Everybody walks
in a lane of it, so many metres to its left; members of a group walk abreast where it is wide
enough, else one behind the other.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crowdsim.groups import draw_groups
from crowdsim.map import Map
from crowdsim.motion import ModelChoice
from crowdsim.pedestrians import Pedestrians
from crowdsim.scenarios.placement import place_parties

FloatArray = NDArray[np.float64]

ABREAST: Final = 0.75
"""Distance between members of a group at the start [m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Walks:
    """Who starts where, and walks which way.

    Attributes:
        start: (N, 2) on the first stretch of the way [m].
        ways: (N, 1 + G, 2) entrance and waypoints [m].
        group: (N,) who walks with whom.
    """

    start: FloatArray
    ways: FloatArray
    group: NDArray[np.int64]

    @property
    def entrances(self) -> FloatArray:
        """(N, 2) where the ways begin [m]."""
        return self.ways[:, 0].copy()

    def pedestrians(
        self,
        rng: np.random.Generator,
        model: ModelChoice,
        desired_speed: ArrayLike | None = None,
    ) -> Pedestrians:
        """Draw the people who walk them; see `Pedestrians.draw`."""
        return Pedestrians.draw(
            rng,
            position=self.start,
            waypoints=self.ways[:, 1:],
            desired_speed=desired_speed,
            model=model,
            group=self.group,
        )


def draw_walks(
    rng: np.random.Generator,
    count: int,
    draw_way: Callable[[], ArrayLike],
    *,
    lane: float,
    groups: float = 0.0,
    stretch: tuple[float, float] = (0.0, 0.9),
    keep_away: Sequence[Sequence[float]] = (),
    ground: Map | None = None,
) -> Walks:
    """Draw a way for everybody, and a place on its first stretch, so that no waypoint is missed.

    Args:
        rng: Source of all draws.
        count: Number of people N.
        draw_way: Draws the middle line (1 + G, 2) of a way [m], of any G.
        lane: How far to either side of it people walk [m].
        groups: Share of people who walk in groups, 0 to 1.
        stretch: Part of the way to the first waypoint on which they start, of 0 to 1.
        keep_away: Points (x, y) [m] that nobody starts near.
        ground: Map whose walls nobody starts near; None where ways keep off them anyway.

    Raises:
        ValueError: There is no room for somebody, or the share is out of range.
    """
    group = draw_groups(rng, count, groups)
    ways: dict[int, FloatArray] = {}

    def draw(first: int, size: int) -> FloatArray:
        middle = np.asarray(draw_way(), dtype=np.float64)
        behind, across = formation(size, lane)
        reach = lane - float(np.abs(across).max())
        across = across + rng.uniform(-reach, reach)
        lines = np.array([shifted(middle, offset) for offset in across])  # (size, 1 + G, 2)
        ways.update(zip(range(first, first + size), lines, strict=True))
        leg = middle[1] - middle[0]
        length = float(np.linalg.norm(leg))
        low, high = stretch[0] * length + behind.max(), stretch[1] * length
        along = rng.uniform(min(low, high), high) - behind
        return np.asarray(lines[:, 0] + along[:, None] * leg / length)

    start = place_parties(group, draw, keep_away=keep_away, ground=ground)
    return Walks(start=start, ways=_stacked([ways[row] for row in range(count)]), group=group)


def formation(size: int, lane: float) -> tuple[FloatArray, FloatArray]:
    """How far each of a group walks behind its first member and left of its middle, (size,) [m].

    Abreast if a lane that reaches so far to either side has room, else in single file.
    """
    places: FloatArray = ABREAST * np.arange(size, dtype=np.float64)
    if places[-1] > 2.0 * lane:
        return places, np.zeros(size)
    return np.zeros(size), np.asarray(places - places.mean())


def shifted(line: FloatArray, left: float) -> FloatArray:
    """The line (P, 2) so many metres to the left of another one [m], as far off in its bends."""
    legs = np.diff(line, axis=0)
    legs /= np.linalg.norm(legs, axis=1, keepdims=True)
    normal = np.column_stack([-legs[:, 1], legs[:, 0]])
    bend = np.concatenate([normal[:1], normal]) + np.concatenate([normal, normal[-1:]])
    # Where the line turns right back, the corner would lie at infinity.
    sharpness = np.maximum((bend**2).sum(axis=1, keepdims=True), 1.0)
    return np.asarray(line + 2.0 * left * bend / sharpness)


def _stacked(ways: Sequence[FloatArray]) -> FloatArray:
    """Ways (N, 1 + G, 2); the shorter ones repeat their end."""
    points = max((len(way) for way in ways), default=2)
    padded = [np.pad(way, ((0, points - len(way)), (0, 0)), mode="edge") for way in ways]
    return np.array(padded).reshape(-1, points, 2)
