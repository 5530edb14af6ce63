"""Two rooms and the door between them."""

from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.motion import ModelChoice
from crowdsim.pedestrians import Pedestrians
from crowdsim.recordings.surfaces import Surface
from crowdsim.scenario import Scenario
from crowdsim.scenarios.placement import place, require_count, require_range

WALL: Final = 0.3
"""Thickness of all walls [m]."""
SIDE: Final = 0.7
"""Distance that starts and goals keep from the walls [m]."""


def narrow_doorway(
    rng: np.random.Generator,
    *,
    pedestrians: int = 8,
    door_width: float = 1.3,
    room_length: float = 7.0,
    room_width: float = 7.0,
    crossing: float = 0.5,
    model: ModelChoice = "social_force",
) -> Scenario:
    """The robot has to pass a door that people use both ways, for as long as the episode lasts.

    Half of the people start in each room. Some of each half walk to the other room and back, the
    rest between places of their own room.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 100.
        door_width: Clear width of the door [m], 0.8 to 4.
        room_length: Depth of each room, away from the door [m], 4 to 30.
        room_width: Width of both rooms [m], 4 to 30.
        crossing: Share of people who use the door, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the rooms are too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 100)
    require_range("door_width", door_width, 0.8, 4.0)
    require_range("room_length", room_length, 4.0, 30.0)
    require_range("room_width", room_width, 4.0, 30.0)
    require_range("crossing", crossing, 0.0, 1.0, unit="(share)")
    side = np.where(np.arange(pedestrians) % 2 == 0, -1.0, 1.0)
    robot_x = room_length - 1.5

    def in_room(sign: float) -> NDArray[np.float64]:
        x = sign * rng.uniform(SIDE, room_length - SIDE)
        return np.array([x, rng.uniform(SIDE - 0.5 * room_width, 0.5 * room_width - SIDE)])

    def goal(index: int) -> NDArray[np.float64]:
        crosses = index // 2 < round(crossing * pedestrians) / 2
        return in_room(-side[index] if crosses else side[index])

    start = place(pedestrians, lambda index: in_room(side[index]), keep_away=[(-robot_x, 0.0)])
    goals = np.array([goal(index) for index in range(pedestrians)]).reshape(-1, 2)
    return Scenario(
        name="narrow_doorway",
        map=_two_rooms(door_width, room_length, room_width),
        pedestrians=Pedestrians.draw(rng, position=start, waypoints=goals, model=model),
        on_arrival="return",
        robot_start=(-robot_x, 0.0, 0.0),
        robot_goal=(robot_x, 0.0),
        time_limit=max(40.0, 5.0 * room_length),
    )


@lru_cache(maxsize=64)
def _two_rooms(door_width: float, length: float, width: float) -> Map:
    """Solid walls as building surfaces, so that pictures show what bodies feel."""
    half, door = 0.5 * width, 0.5 * door_width
    boxes = [
        (-length - WALL, half, length + WALL, half + WALL),
        (-length - WALL, -half - WALL, length + WALL, -half),
        (-length - WALL, -half, -length, half),
        (length, -half, length + WALL, half),
        (-0.5 * WALL, door, 0.5 * WALL, half),
        (-0.5 * WALL, -half, 0.5 * WALL, -door),
    ]
    walls = tuple(
        (Surface.BUILDING, np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]))
        for x0, y0, x1, y1 in boxes
    )
    bounds = (-length - WALL, -half - WALL, length + WALL, half + WALL)
    return Map(bounds=bounds, surfaces=walls)
