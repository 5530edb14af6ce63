"""The small encounters of a robot and one or a few people in a corridor."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.motion import ModelChoice
from crowdsim.scenario import Scenario
from crowdsim.scenarios.corridor import RUN_UP, corridor_map
from crowdsim.scenarios.placement import require_count, require_range
from crowdsim.scenarios.walks import draw_walks

LENGTH: Final = 24.0
"""Length of the corridor [m]."""
LANE: Final = 0.3
"""People walk so near to the robot's line [m]: somebody has to give way."""


def frontal_approach(
    rng: np.random.Generator,
    *,
    pedestrians: int = 1,
    width: float = 4.0,
    model: ModelChoice = "social_force",
) -> Scenario:
    """Somebody comes straight towards the robot along a corridor.

    Frontal approach of Francis et al. 2023, figure 7. Who has passed enters again at the far end as
    a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, one behind the other, 0 to 6.
        width: Width of the corridor [m], 2 to 20.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range.
    """
    require_count("pedestrians", pedestrians, 0, 6)
    return _encounter(
        rng, "frontal_approach", pedestrians, width, model, ahead=-1.0, stretch=(0.0, 0.4)
    )


def pedestrian_overtaking(
    rng: np.random.Generator,
    *,
    pedestrians: int = 1,
    width: float = 4.0,
    pedestrian_speed: float = 1.7,
    model: ModelChoice = "social_force",
) -> Scenario:
    """Somebody in a hurry comes from behind and overtakes the robot.

    Pedestrian overtaking of Francis et al. 2023, figure 7. Who has left the corridor enters again
    behind as a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, one behind the other, 0 to 3.
        width: Width of the corridor [m], 2 to 20.
        pedestrian_speed: Speed that they want [m/s], 1.3 to 2.2.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range.
    """
    require_count("pedestrians", pedestrians, 0, 3)
    require_range("pedestrian_speed", pedestrian_speed, 1.3, 2.2, unit="m/s")
    return _encounter(
        rng,
        "pedestrian_overtaking",
        pedestrians,
        width,
        model,
        ahead=1.0,
        stretch=(0.0, 0.12),
        speed=pedestrian_speed,
    )


def robot_overtaking(
    rng: np.random.Generator,
    *,
    pedestrians: int = 1,
    width: float = 4.0,
    pedestrian_speed: float = 0.5,
    model: ModelChoice = "social_force",
) -> Scenario:
    """Somebody strolls ahead of the robot, which may pass if it does so with care.

    Robot overtaking of Francis et al. 2023, figure 7. Who has left the corridor enters again behind
    as a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, one behind the other, 0 to 4.
        width: Width of the corridor [m], 2 to 20.
        pedestrian_speed: Speed that they want [m/s], 0.2 to 0.8.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range.
    """
    require_count("pedestrians", pedestrians, 0, 4)
    require_range("pedestrian_speed", pedestrian_speed, 0.2, 0.8, unit="m/s")
    return _encounter(
        rng,
        "robot_overtaking",
        pedestrians,
        width,
        model,
        ahead=1.0,
        stretch=(0.25, 0.4),
        speed=pedestrian_speed,
    )


def _encounter(
    rng: np.random.Generator,
    name: str,
    pedestrians: int,
    width: float,
    model: ModelChoice,
    *,
    ahead: float,
    stretch: tuple[float, float],
    speed: float | None = None,
) -> Scenario:
    """People who walk along the robot's line: its way (`ahead` 1) or against it (-1)."""
    require_range("width", width, 2.0, 20.0)
    half = 0.5 * LENGTH
    robot_x = half - RUN_UP
    way: NDArray[np.float64] = ahead * np.array([(-half, 0.0), (half, 0.0)])
    walks = draw_walks(
        rng, pedestrians, lambda: way, lane=LANE, stretch=stretch, keep_away=[(-robot_x, 0.0)]
    )
    return Scenario(
        name=name,
        map=corridor_map(LENGTH, width),
        pedestrians=walks.pedestrians(rng, model, speed),
        on_arrival="respawn",
        entrances=walks.entrances,
        robot_start=(-robot_x, 0.0, 0.0),
        robot_goal=(robot_x, 0.0),
        time_limit=40.0,
    )
