"""Seeded scenario generators by name; each documents its parameters."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from crowdsim.behaviour import Behaviour
from crowdsim.scenario import Scenario
from crowdsim.scenarios.circular import (
    circular_crossing,
    circular_crossing_with_static_obstacles,
)
from crowdsim.scenarios.corridor import narrow_hallway, parallel_traffic
from crowdsim.scenarios.crowds import crowd_navigation, robot_crowding
from crowdsim.scenarios.doorway import narrow_doorway
from crowdsim.scenarios.encounters import (
    frontal_approach,
    pedestrian_overtaking,
    robot_overtaking,
)
from crowdsim.scenarios.junctions import blind_corner, intersection, t_intersection
from crowdsim.scenarios.open_ground import group_crossing, perpendicular_traffic, random_crossing
from crowdsim.scenarios.public_place import public_place
from crowdsim.scenarios.replay import replay
from crowdsim.scenarios.rooms import bottleneck, entering_room, exiting_room
from crowdsim.scenarios.scenario_file import is_scenario_file, parameter_names, read_scenario_file
from crowdsim.scenarios.station import station_hall
from crowdsim.scenarios.urban import urban_crossing

SCENARIOS: Final[dict[str, Callable[..., Scenario]]] = {
    "circular_crossing": circular_crossing,
    "random_crossing": random_crossing,
    "parallel_traffic": parallel_traffic,
    "perpendicular_traffic": perpendicular_traffic,
    "robot_crowding": robot_crowding,
    "crowd_navigation": crowd_navigation,
    "frontal_approach": frontal_approach,
    "pedestrian_overtaking": pedestrian_overtaking,
    "robot_overtaking": robot_overtaking,
    "intersection": intersection,
    "t_intersection": t_intersection,
    "blind_corner": blind_corner,
    "narrow_doorway": narrow_doorway,
    "narrow_hallway": narrow_hallway,
    "bottleneck": bottleneck,
    "entering_room": entering_room,
    "exiting_room": exiting_room,
    "group_crossing": group_crossing,
    "circular_crossing_with_static_obstacles": circular_crossing_with_static_obstacles,
    "urban_crossing": urban_crossing,
    "station_hall": station_hall,
    "public_place": public_place,
    "replay": replay,
}


def find_scenario(name: str) -> Callable[..., Scenario]:
    """Give the generator that a name stands for.

    Args:
        name: One of `SCENARIOS`; several joined by `+`, one of which is drawn each time; or a
            scenario file (`crowdsim.scenarios.scenario_file`), whose name ends in `.yaml` or
            `.yml`.

    Raises:
        ValueError: Unknown name, or a file that describes no scenario.
        FileNotFoundError: No such file.
    """
    if is_scenario_file(name):
        return read_scenario_file(name, SCENARIOS)
    names = name.split("+")
    if not set(names) <= set(SCENARIOS):
        raise ValueError(
            f"scenario must be one of {', '.join(SCENARIOS)}, or several joined by +, got {name!r}"
        )
    return SCENARIOS[name] if len(names) == 1 else _drawn_from([SCENARIOS[one] for one in names])


def _drawn_from(generators: Sequence[Callable[..., Scenario]]) -> Callable[..., Scenario]:
    """Give the generator that draws one of these; it takes no parameters."""

    def draw(rng: np.random.Generator) -> Scenario:
        return generators[int(rng.integers(len(generators)))](rng)

    return draw


def make_scenario(
    name: str,
    rng: np.random.Generator,
    *,
    behaviour: Behaviour | Mapping[str, float] | None = None,
    **parameters: Any,
) -> Scenario:
    """Draw the initial conditions of one world.

    Args:
        name: As `find_scenario` takes it.
        rng: Source of all draws.
        behaviour: What people do besides walking, in any scenario but a replay.
        **parameters: Parameters of that scenario's function; a file that describes people and map
            takes `model`.

    Raises:
        ValueError: Unknown name or parameter (the message lists the known ones), or a parameter
            out of range.
        FileNotFoundError: A file that is not there, or a replay whose data is not.
    """
    generator = find_scenario(name)
    known = parameter_names(generator)
    unknown = sorted(set(parameters) - set(known))
    if unknown:
        raise ValueError(f"{name} takes {', '.join(known)}; got {', '.join(unknown)}")
    scenario = generator(rng, **parameters)
    if behaviour is None:
        return scenario
    return replace(scenario, behaviour=Behaviour.of(behaviour))
