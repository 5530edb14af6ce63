"""What the robot's sensors report of the people: range, field of view, occlusion, misses, noise.

With `frame_jitter` a frame is older than the robot takes it for: it shows people where they were a
little earlier, and nobody who has entered since the last one.
"""

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
NOBODY = -1
"""Id of a column in which nobody was when the last frame was taken."""


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
        self._clock_rng: dict[int, np.random.Generator] = {}
        self._losses = np.zeros((worlds, 1), dtype=np.int64)
        self._before = np.full((worlds, 1), NOBODY)

    def restart(self, world: int, rng: np.random.Generator, worlds: Worlds) -> None:
        """Takes the randomness of a new episode and the people it begins with."""
        self._rng[world] = rng
        # A stream of its own: jitter changes neither noise nor misses.
        self._clock_rng[world] = rng.spawn(1)[0]
        self._widen(worlds.crowd.columns)
        self._losses[world] = 0
        self._before[world] = worlds.crowd.ids[world]

    def detect(self, rows: Rows, worlds: Worlds) -> Detections:
        """Returns what the sensors of the worlds `rows` report now, R in the place of W."""
        crowd, config = worlds.crowd, self._config
        seen = crowd.valid[rows] & (_distance(rows, worlds) <= config.sensor_range)
        if config.perfect_sensor:
            return Detections(crowd.position[rows], seen, crowd.ids[rows])
        position = crowd.position[rows].copy()
        self._widen(crowd.columns)
        for row, world in enumerate(np.arange(len(crowd.valid))[rows].tolist()):
            people = slice(len(worlds.running(world).ids))  # no draw depends on other worlds
            seen[row, people] &= self._in_sight(world, people, worlds)
            if config.frame_jitter > 0.0:
                self._delay(world, position[row, people], seen[row, people], worlds)
            self._disturb(world, position[row, people], seen[row, people])
        # Ids stay below this for centuries of simulated time.
        return Detections(position, seen, crowd.ids[rows] + (self._losses[rows] << 40))

    def _widen(self, columns: int) -> None:
        """Makes room for so many people."""
        more = ((0, 0), (0, columns - self._losses.shape[1]))
        self._losses = np.pad(self._losses, more)
        self._before = np.pad(self._before, more, constant_values=NOBODY)

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

    def _delay(self, world: int, position: Floats, seen: Flags, worlds: Worlds) -> None:
        """Puts the people of one world where they were when the frame was taken, in place."""
        age = self._clock_rng[world].uniform(0.0, self._config.frame_jitter)
        position[:] = worlds.people_before(world, age)
        people = slice(len(position))
        ids = worlds.crowd.ids[world, people]
        seen &= ids == self._before[world, people]
        present = worlds.crowd.valid[world, people]
        self._before[world, people] = np.where(present, ids, NOBODY)

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
