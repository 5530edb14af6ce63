"""What a forecaster of the environment is asked, and what it answers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings import Picture
from envs.robots import Robot
from envs.worlds import Worlds

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class Situation:
    """R worlds at one moment, world frame, SI units; N pedestrian columns.

    Attributes:
        indices: (R,) which of the worlds.
        worlds: The physics. A forecaster that reads more than the ground from it knows what no
            robot can know.
        robot: How the robots move on under the command that they have.
        history: (R, T, N, 2) observed positions, a frame apart, the last one now; 0 where not
            valid.
        valid: (R, T, N).
        robot_history: (R, T, 2) of the robots.
        robot_valid: (R, T), False altogether where a forecaster must not see them.
        select: (R, N), whom to forecast.
        pictures: R pictures of the ground, None where no one needs them.
    """

    indices: NDArray[np.intp]
    worlds: Worlds
    robot: Robot
    history: Floats
    valid: Flags
    robot_history: Floats
    robot_valid: Flags
    select: Flags
    pictures: Sequence[Picture | None]


@dataclass(frozen=True, kw_only=True, eq=False)
class WorldForecast:
    """The next F frames of R worlds, world frame; N pedestrian columns.

    Attributes:
        position: (R, F, N, 2) [m], finite; meaningless for who was not selected.
        radius: (T, F) within which 9 in 10 people are expected of their positions [m], in row k of
            people seen in k + 1 frames of their history.
        modes: (R, M, F, N, 2) other ways that they may go, the likeliest first [m]; None where
            nobody asked for them.
        probability: (R, M, N) of the modes; None likewise.
    """

    position: Floats
    radius: Floats
    modes: Floats | None = None
    probability: Floats | None = None


class WorldForecaster(Protocol):
    """Forecasts the pedestrians of several worlds at once."""

    def restart(self, world: int, rng: np.random.Generator) -> None:
        """Takes note that an episode begins in one world; `rng` is all its randomness."""

    def forecast(self, situation: Situation) -> WorldForecast:
        """Forecasts who is selected."""
