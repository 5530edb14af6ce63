"""Rooms behind a corridor, and a passage that everybody has to squeeze through."""

import math
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.maps.shapes import box
from crowdsim.motion import ModelChoice
from crowdsim.recordings.surfaces import Surface
from crowdsim.scenario import Scenario
from crowdsim.scenarios.placement import require_count, require_range
from crowdsim.scenarios.walks import draw_walks

FloatArray = NDArray[np.float64]

WALL: Final = 0.3
"""Thickness of all walls [m]."""
CORRIDOR: Final = 3.0
"""Width of the corridor along the room [m]."""
REACH: Final = 8.0
"""Half the length of that corridor [m]."""
BACK_DOOR: Final = 2.0
"""Width of the room's other door [m]."""
EDGE: Final = 1.0
"""Ground beyond where people enter and leave [m]."""
LANE: Final = 0.15
"""People keep so near to their line through a door [m]."""
MIDDLE: Final = -0.5 * (WALL + CORRIDOR)
"""Middle line of the corridor, which runs along y [m]."""
BEFORE_DOOR: Final = 0.9
"""People aim at the middle of a door from so far before and behind it [m]."""
HALL: Final = (8.0, 6.0)
"""Length and width of the hall before a bottleneck [m]."""
BEHIND: Final = 4.0
"""Length of the ground behind a bottleneck [m]."""


def entering_room(
    rng: np.random.Generator,
    *,
    pedestrians: int = 7,
    door_width: float = 1.5,
    room_length: float = 7.0,
    room_width: float = 7.0,
    passing: float = 0.3,
    model: ModelChoice = "social_force",
) -> Scenario:
    """The robot comes along a corridor and enters a room that people are leaving.

    Entering room of Francis et al. 2023, figure 7. People come into the room through a door at its
    back, out of the robot's way; who has left along the corridor enters again as a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 100.
        door_width: Clear width of the door to the corridor [m], 0.9 to 4.
        room_length: Depth of the room, away from that door [m], 5 to 30.
        room_width: Width of the room along the corridor [m], 6 to 12.
        passing: Share of people who walk along the corridor past the door, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the room is too small for the people.
    """
    return _room(
        rng, "entering_room", pedestrians, door_width, room_length, room_width, passing, model
    )


def exiting_room(
    rng: np.random.Generator,
    *,
    pedestrians: int = 7,
    door_width: float = 1.5,
    room_length: float = 7.0,
    room_width: float = 7.0,
    passing: float = 0.3,
    model: ModelChoice = "social_force",
) -> Scenario:
    """The robot leaves a room that people are entering, and goes away along the corridor.

    Exiting room of Francis et al. 2023, figure 7. People leave the room through a door at its back,
    out of the robot's way; then new persons come along the corridor.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 100.
        door_width: Clear width of the door to the corridor [m], 0.9 to 4.
        room_length: Depth of the room, away from that door [m], 5 to 30.
        room_width: Width of the room along the corridor [m], 6 to 12.
        passing: Share of people who walk along the corridor past the door, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the corridor is too small for the people.
    """
    return _room(
        rng, "exiting_room", pedestrians, door_width, room_length, room_width, passing, model
    )


def _room(
    rng: np.random.Generator,
    name: str,
    pedestrians: int,
    door_width: float,
    length: float,
    width: float,
    passing: float,
    model: ModelChoice,
) -> Scenario:
    """The robot and the people meet in the door at the origin; the room lies east of it."""
    require_count("pedestrians", pedestrians, 0, 100)
    require_range("door_width", door_width, 0.9, 4.0)
    require_range("room_length", length, 5.0, 30.0)
    require_range("room_width", width, 6.0, 12.0)
    require_range("passing", passing, 0.0, 1.0, unit="(share)")
    robot_enters = name == "entering_room"
    outside = (MIDDLE, -(REACH - 2.5))
    inside = (length - 1.5, -0.5 * width + 1.5)

    def draw_way() -> FloatArray:
        side = rng.choice([-1.0, 1.0])
        if rng.random() < passing:
            return _past_the_door(rng, side)
        out = _out_of_the_room(rng, length, width, side)
        return out if robot_enters else out[::-1]

    start, goal = (outside, inside) if robot_enters else (inside, outside)
    ground = room_map(door_width, length, width)
    walks = draw_walks(rng, pedestrians, draw_way, lane=LANE, keep_away=[start], ground=ground)
    heading = 0.5 * math.pi if robot_enters else math.pi
    return Scenario(
        name=name,
        map=ground,
        pedestrians=walks.pedestrians(rng, model),
        on_arrival="respawn",
        entrances=walks.entrances,
        robot_start=(*start, heading),
        robot_goal=goal,
        time_limit=max(45.0, 3.0 * (length + REACH)),
    )


def bottleneck(
    rng: np.random.Generator,
    *,
    pedestrians: int = 12,
    width: float = 1.4,
    passage: float = 2.0,
    model: ModelChoice = "social_force",
) -> Scenario:
    """A hall empties through a narrow passage, and the robot has to queue with everybody.

    The bottleneck experiment of Seyfried et al. 2009, with a robot in the crowd. Who is through
    enters the hall again as a new person.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 80.
        width: Clear width of the passage [m], 0.9 to 4.
        passage: Its length [m], 0.3 to 6.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or the hall is too small for the people.
    """
    require_count("pedestrians", pedestrians, 0, 80)
    require_range("width", width, 0.9, 4.0)
    require_range("passage", passage, 0.3, 6.0)
    length, reach = HALL[0], 0.5 * HALL[1] - 0.6

    def draw_way() -> FloatArray:
        here, there = rng.uniform(-reach, reach, 2)
        through = [(-BEFORE_DOOR, 0.0), (passage + BEFORE_DOOR, 0.0)]
        return np.array([(-length, here), *through, (passage + BEHIND, there)])

    start = (1.5 - length, 0.0)
    walks = draw_walks(rng, pedestrians, draw_way, lane=LANE, keep_away=[start])
    return Scenario(
        name="bottleneck",
        map=bottleneck_map(width, passage),
        pedestrians=walks.pedestrians(rng, model),
        on_arrival="respawn",
        entrances=walks.entrances,
        robot_start=(*start, 0.0),
        robot_goal=(passage + BEHIND - 1.5, 0.0),
        time_limit=60.0,
    )


def _past_the_door(rng: np.random.Generator, side: float) -> FloatArray:
    """Along the corridor (2, 2), to the north (side 1) or to the south (-1)."""
    x = MIDDLE + rng.uniform(-0.8, 0.8)
    return np.array([(x, -side * REACH), (x, side * REACH)])


def _out_of_the_room(
    rng: np.random.Generator, length: float, width: float, side: float
) -> FloatArray:
    """From the back door through the other one, then along the corridor to one side, (4, 2)."""
    back = (length + WALL + 0.3, _back_door(width))
    through = [(BEFORE_DOOR, 0.0), (-BEFORE_DOOR, 0.0)]
    return np.array([back, *through, (MIDDLE + rng.uniform(-0.8, 0.8), side * REACH)])


def _back_door(width: float) -> float:
    """Where the middle of the back door is along y [m]: at the end of the wall."""
    return 0.5 * width - 0.6 - 0.5 * BACK_DOOR


@lru_cache(maxsize=64)
def room_map(door_width: float, length: float, width: float) -> Map:
    """A room east of a corridor that runs along y; the door is at the origin."""
    half, door, back = 0.5 * width, 0.5 * door_width, _back_door(width)
    west, east, end = MIDDLE - 0.5 * CORRIDOR, length + WALL + EDGE, REACH + EDGE
    blocks = [
        box(west - EDGE, -end, west, end),
        box(-0.5 * WALL, door, 0.5 * WALL, end),
        box(-0.5 * WALL, -end, 0.5 * WALL, -door),
        box(0.5 * WALL, half, east, end),
        box(0.5 * WALL, -end, east, -half),
        box(length, back + 0.5 * BACK_DOOR, length + WALL, half),
        box(length, -half, length + WALL, back - 0.5 * BACK_DOOR),
    ]
    surfaces = tuple((Surface.BUILDING, block) for block in blocks)
    return Map(bounds=(west - EDGE, -end, east, end), surfaces=surfaces)


@lru_cache(maxsize=64)
def bottleneck_map(width: float, passage: float) -> Map:
    """A hall west of the origin, a passage from there eastwards, and ground behind it."""
    west, east, side = -HALL[0] - EDGE, passage + BEHIND + EDGE, 0.5 * HALL[1]
    blocks = [
        box(west, side, east, side + EDGE),
        box(west, -side - EDGE, east, -side),
        box(0.0, 0.5 * width, passage, side),
        box(0.0, -side, passage, -0.5 * width),
    ]
    surfaces = tuple((Surface.BUILDING, block) for block in blocks)
    return Map(bounds=(west, -side - EDGE, east, side + EDGE), surfaces=surfaces)
