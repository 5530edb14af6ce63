"""Where people can walk in recorded crowds, so that forecasts through walls can be counted."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings import Picture, Recording
from crowdsim.recordings.drawn import walkable_in
from predictor.datasets import drawn_name, read_tests


@dataclass(frozen=True, kw_only=True, eq=False)
class Ground:
    """Where one can walk in a world.

    Attributes:
        walkable: (H, W) bool.
        pixel_from_world: (3, 3) homography into it.
    """

    walkable: NDArray[np.bool_]
    pixel_from_world: NDArray[np.float64]

    def is_off(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Of (..., 2) points [m]: 1 where one cannot walk, 0 where one can, NaN out of the map."""
        seen = points @ self.pixel_from_world[:, :2].T + self.pixel_from_world[:, 2]
        u, v = np.moveaxis(np.rint(seen[..., :2] / seen[..., 2:]), -1, 0)
        height, width = self.walkable.shape
        inside = (u >= 0) & (u < width) & (v >= 0) & (v < height)
        row, column = (np.where(inside, pixel, 0).astype(np.intp) for pixel in (v, u))
        return np.where(inside, ~self.walkable[row, column], np.nan)


def read_grounds(data: str, tests: Mapping[str, Sequence[Recording]]) -> dict[str, Ground]:
    """The ground of each recording of some tests, by its name, as far as it is known.

    Args:
        data: As `predictor.datasets.read_tests`.
        tests: What that gives for it.

    Raises:
        FileNotFoundError: A mask of real data is missing or damaged.
    """
    name = drawn_name(data)
    drawn = tests if name == data else read_tests(name)
    pictures = {r.name: r.picture for recordings in drawn.values() for r in recordings}
    grounds = {name: _ground(picture) for name, picture in pictures.items()}
    return {name: ground for name, ground in grounds.items() if ground is not None}


def _ground(picture: Picture | None) -> Ground | None:
    walkable = None if picture is None else walkable_in(picture)
    if picture is None or walkable is None:
        return None
    return Ground(walkable=walkable, pixel_from_world=picture.pixel_from_world)
