"""What the robot's sensors report of the people: range, field of view, occlusion, misses, noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crowdsim.visibility import visible
from envs.config import CrowdNavConfig
from envs.tracker import Rows
from envs.worlds import Worlds

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

NO_OCCLUDERS = np.empty((0, 2, 2))


@dataclass(frozen=True, eq=False)
class Detections:
    """What W sensors report at one moment; N pedestrian columns.

    Attributes:
        position: (W, N, 2) measured [m]; meaningless where not seen.
        seen: (W, N).
        tracks: (W, N) numbers that change when a column holds somebody else, or when the sensor
            takes the same person for somebody else.
    """

    position: Floats
    seen: Flags
    tracks: NDArray[np.int64]


class Sensor:
    """Detects people once per policy step; perfect within its range unless configured otherwise."""

    def __init__(self, config: CrowdNavConfig, worlds: int):
        self._config = config
        self._rng: dict[int, np.random.Generator] = {}
        self._losses = np.zeros((worlds, 1), dtype=np.int64)

    def restart(self, world: int, rng: np.random.Generator) -> None:
        """Takes the randomness of a new episode."""
        self._rng[world] = rng
        self._losses[world] = 0

    def detect(self, rows: Rows, worlds: Worlds) -> Detections:
        """Returns what the sensors of the worlds `rows` report now, R in the place of W."""
        crowd, config = worlds.crowd, self._config
        seen = crowd.valid[rows] & (_distance(rows, worlds) <= config.sensor_range)
        if config.perfect_sensor:
            return Detections(crowd.position[rows], seen, crowd.ids[rows])
        position = crowd.position[rows].copy()
        self._losses = np.pad(self._losses, ((0, 0), (0, crowd.columns - self._losses.shape[1])))
        for row, world in enumerate(np.arange(len(crowd.valid))[rows].tolist()):
            people = slice(len(worlds.running(world).ids))  # no draw depends on other worlds
            seen[row, people] &= self._in_sight(world, people, worlds)
            self._disturb(world, position[row, people], seen[row, people])
        # Ids stay below this for centuries of simulated time.
        return Detections(position, seen, crowd.ids[rows] + (self._losses[rows] << 40))

    def _in_sight(self, world: int, people: slice, worlds: Worlds) -> Flags:
        """(N,) whom the robot of one world sees, if the sensor misses nobody."""
        config, crowd, robots = self._config, worlds.crowd, worlds.robots
        hides = config.occlusion
        seen: Flags = visible(
            worlds.running(world).scenario.map.occluders if hides else NO_OCCLUDERS,
            robots.position[world, None],
            robots.heading[world, None],
            crowd.position[world, people],
            max_range=config.sensor_range,
            field_of_view=config.field_of_view,
            radius=crowd.radius[world, people] if hides else None,
        )[0]
        return seen

    def _disturb(self, world: int, position: Floats, seen: Flags) -> None:
        """Adds noise, misses and lost tracks to the people of one world, in place."""
        config, rng = self._config, self._rng[world]
        noise = rng.standard_normal(position.shape)
        missed, lost = rng.random((2, len(position)))
        position += config.position_noise * noise
        seen &= missed >= config.missed_detections
        self._losses[world, : len(position)] += lost < config.track_loss_rate * config.policy_dt


def _distance(rows: Rows, worlds: Worlds) -> Floats:
    """(R, N) from the robots to the pedestrians [m]."""
    gap = worlds.crowd.position[rows] - worlds.robots.position[rows, None]
    return np.asarray(np.sqrt(gap[..., 0] ** 2 + gap[..., 1] ** 2))
