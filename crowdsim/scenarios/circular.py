"""People on a circle who all want to be on its other side."""

import math
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.motion import ModelChoice
from crowdsim.pedestrians import Pedestrians
from crowdsim.scenario import OnArrival, Scenario
from crowdsim.scenarios.placement import place, require_count, require_range

MARGIN: Final = 3.0
"""Ground around the circle [m]."""


def circular_crossing(
    rng: np.random.Generator,
    *,
    pedestrians: int = 20,
    radius: float = 6.0,
    noise: float = 0.5,
    on_arrival: OnArrival = "return",
    model: ModelChoice = "social_force",
) -> Scenario:
    """People start on a circle and walk to the opposite point; the robot crosses it from the south.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 200.
        radius: Radius of the circle [m], 2 to 30.
        noise: Starts are moved by up to this much along x and y [m], 0 to 2.
        on_arrival: `return` (walk back and forth for ever) or `stop`.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the circle is too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 200)
    require_range("radius", radius, 2.0, 30.0)
    require_range("noise", noise, 0.0, 2.0)
    if on_arrival not in ("return", "stop"):
        raise ValueError(f"on_arrival must be return or stop, got {on_arrival!r}")

    def draw(_: int) -> NDArray[np.float64]:
        angle = rng.uniform(-math.pi, math.pi)
        on_circle = radius * np.array([math.cos(angle), math.sin(angle)])
        return on_circle + rng.uniform(-noise, noise, 2)

    # Goals mirror the starts: keeping off the robot's start keeps them off its goal as well.
    start = place(pedestrians, draw, keep_away=[(0.0, -radius), (0.0, radius)])
    return Scenario(
        name="circular_crossing",
        map=_square(radius + MARGIN),
        pedestrians=Pedestrians.draw(rng, position=start, waypoints=-start, model=model),
        on_arrival=on_arrival,
        robot_start=(0.0, -radius, math.pi / 2.0),
        robot_goal=(0.0, radius),
        time_limit=max(20.0, 4.0 * radius),
    )


@lru_cache(maxsize=64)
def _square(half: float) -> Map:
    return Map(bounds=(-half, -half, half, half))
