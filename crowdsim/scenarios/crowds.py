"""Crowds of which a part stands: people who talk while others walk by, or who look at the robot."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.groups import draw_groups
from crowdsim.motion import ModelChoice
from crowdsim.pedestrians import ALONE, Pedestrians
from crowdsim.scenario import OnArrival, Scenario
from crowdsim.scenarios.open_ground import OPEN_LANE, RUN_UP, across_square, open_ground
from crowdsim.scenarios.placement import place, place_parties, require_count, require_range
from crowdsim.scenarios.walks import Walks, draw_walks

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

CIRCLE: Final = 0.85
"""Distance between neighbors in a circle of people who talk [m]."""
RING: Final = (1.1, 3.2)
"""Least and largest distance of onlookers from the robot [m]."""


def crowd_navigation(
    rng: np.random.Generator,
    *,
    pedestrians: int = 30,
    size: float = 14.0,
    standing: float = 0.3,
    groups: float = 0.3,
    model: ModelChoice = "social_force",
) -> Scenario:
    """People mill about a square, some stand and talk; the robot finds its way through.

    Crowd navigation of Francis et al. 2023, table 3: the robot crosses a space that people walk
    about in. Who walks takes a turn in the middle and leaves; then a new person enters.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 500.
        size: Side of the square [m], 8 to 60.
        standing: Share of people who stand in circles of two to four, 0 to 1.
        groups: Share of the others who walk in groups, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the square is too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 500)
    require_range("size", size, 8.0, 60.0)
    require_range("standing", standing, 0.0, 1.0, unit="(share)")
    require_range("groups", groups, 0.0, 1.0, unit="(share)")
    half = 0.5 * size
    robot_y = half - RUN_UP
    together = draw_groups(rng, round(standing * pedestrians), 1.0)

    def circle(_: int, count: int) -> FloatArray:
        middle = rng.uniform(2.0 - half, half - 2.0, 2)
        return np.asarray(middle + _circle(count, rng.uniform(-math.pi, math.pi)))

    stand = place_parties(together, circle, keep_away=[(0.0, -robot_y), (0.0, robot_y)])

    def stroll() -> FloatArray:
        ends = across_square(rng, half)
        return np.insert(ends, 1, rng.uniform(-0.6 * half, 0.6 * half, 2), axis=0)

    walks = draw_walks(
        rng,
        pedestrians - len(stand),
        stroll,
        lane=OPEN_LANE,
        groups=groups,
        keep_away=[(0.0, -robot_y), *stand.tolist()],
    )
    return _standing_and_walking(
        rng, "crowd_navigation", stand, together, walks, model, half, -robot_y
    )


def robot_crowding(
    rng: np.random.Generator,
    *,
    pedestrians: int = 18,
    size: float = 14.0,
    standing: float = 0.6,
    groups: float = 0.0,
    model: ModelChoice = "social_force",
) -> Scenario:
    """Onlookers stand around the robot, others come for a look; it has to get away through them.

    Robot crowding of Francis et al. 2023, figure 7: a robot that stands is surrounded by people.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 60.
        size: Side of the square [m], 12 to 60.
        standing: Share of people who stand around the robot, 0 to 1, in a ring of 1.1 to 3.2 m;
            the others walk past it, leave, and enter again as new persons.
        groups: Share of the others who walk in groups, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or there is no room for all onlookers.
    """
    require_count("pedestrians", pedestrians, 0, 60)
    require_range("size", size, 12.0, 60.0)
    require_range("standing", standing, 0.0, 1.0, unit="(share)")
    require_range("groups", groups, 0.0, 1.0, unit="(share)")
    half = 0.5 * size
    robot = np.array([0.0, RING[1] + 0.3 - half])
    stand = place(
        round(standing * pedestrians),
        lambda _: robot + _near(rng, *RING),
        keep_away=[robot.tolist()],
    )
    alone = np.full(len(stand), ALONE)

    def visit() -> FloatArray:
        return np.insert(across_square(rng, half), 1, robot + _near(rng, *RING), axis=0)

    walks = draw_walks(
        rng,
        pedestrians - len(stand),
        visit,
        lane=OPEN_LANE,
        groups=groups,
        keep_away=[robot.tolist(), *stand.tolist()],
    )
    return _standing_and_walking(
        rng, "robot_crowding", stand, alone, walks, model, half, float(robot[1])
    )


def _standing_and_walking(
    rng: np.random.Generator,
    name: str,
    stand: FloatArray,
    together: IntArray,
    walks: Walks,
    model: ModelChoice,
    half: float,
    robot_y: float,
) -> Scenario:
    """People who keep to their places (S, 2), in groups (S,), and walks between them.

    The robot goes from (0, robot_y) to the north of a square of some half width.
    """
    places = np.repeat(stand[:, None], walks.ways.shape[1] - 1, axis=1)  # (S, G, 2)
    groups_so_far = together.max(initial=ALONE) + 1
    walking = np.where(walks.group == ALONE, ALONE, walks.group + groups_so_far)
    stays: list[OnArrival] = ["stop"] * len(stand)
    leaves: list[OnArrival] = ["respawn"] * len(walks.start)
    return Scenario(
        name=name,
        map=open_ground(half, half),
        pedestrians=Pedestrians.draw(
            rng,
            position=np.concatenate([stand, walks.start]),
            waypoints=np.concatenate([places, walks.ways[:, 1:]]),
            group=np.concatenate([together, walking]),
            model=model,
        ),
        on_arrival=(*stays, *leaves),
        entrances=np.concatenate([stand, walks.entrances]),
        robot_start=(0.0, robot_y, 0.5 * math.pi),
        robot_goal=(0.0, half - RUN_UP),
        time_limit=max(40.0, 6.0 * half),
    )


def _circle(count: int, angle: float) -> FloatArray:
    """Places (count, 2) around the middle of people who talk [m]; one person is the middle."""
    turn = angle + 2.0 * math.pi * np.arange(count) / count
    radius = 0.0 if count == 1 else 0.5 * CIRCLE / math.sin(math.pi / count)
    return radius * np.column_stack([np.cos(turn), np.sin(turn)])


def _near(rng: np.random.Generator, low: float, high: float) -> FloatArray:
    """A point (2,) uniform in the ring between two distances from the origin [m]."""
    radius, angle = math.sqrt(rng.uniform(low**2, high**2)), rng.uniform(-math.pi, math.pi)
    return radius * np.array([math.cos(angle), math.sin(angle)])
