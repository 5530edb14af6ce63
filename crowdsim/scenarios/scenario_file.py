"""Scenarios in YAML files; docs/scenario_files.md describes the format.

A file either describes a map, people and a robot's task, or names a scenario and its parameters.
Unknown keys are errors, and every error names the file and the key.
"""

import dataclasses
import functools
import hashlib
import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

import numpy as np
import yaml
from numpy.typing import NDArray

from crowdsim.behaviour import Behaviour
from crowdsim.map import Map
from crowdsim.maps import PLACES, read_map
from crowdsim.maps.places import LAYOUTS
from crowdsim.maps.shapes import box
from crowdsim.maps.vector import SURFACES
from crowdsim.motion import draw_models
from crowdsim.recordings.surfaces import Surface
from crowdsim.scenario import ON_ARRIVAL, Scenario
from crowdsim.scenarios.described import MOST_PEOPLE, Description, Flow
from crowdsim.scenarios.file_values import (
    is_number,
    items,
    number,
    numbers,
    refuse_unknown,
    section,
    whole_numbers,
)
from crowdsim.scenarios.regions import ENTRANCES, STOPS, PlaceChoice, Region

Generator = Callable[..., Scenario]
Named = tuple[str, dict[str, Any]]
"""A scenario's name and its parameters."""

ENDINGS: Final = (".yaml", ".yml")
DESCRIBED: Final = ("map", "people", "robot")
OPTIONS: Final = ("name", "behaviour", "time_limit")
PEOPLE: Final = ("via", "desired_speed", "groups", "spread", "on_arrival", "model")


def is_scenario_file(name: str) -> bool:
    """Whether a scenario's name is that of a file."""
    return name.endswith(ENDINGS)


@lru_cache(maxsize=64)
def parameter_names(generator: Generator) -> tuple[str, ...]:
    """The parameters that a generator of scenarios takes."""
    return tuple(name for name in inspect.signature(generator).parameters if name != "rng")


def read_scenario_file(path: Path | str, named: Mapping[str, Generator]) -> Generator:
    """Make a scenario file the generator that it describes.

    A file that is read again unchanged shares its map with the first time.

    Args:
        path: The file.
        named: Generators by the names that the file may use.

    Raises:
        FileNotFoundError: No such file, or no such map beside it.
        ValueError: The content is not as `docs/scenario_files.md` says.
    """
    content = _read(Path(path))
    if isinstance(content, Description):
        return content.draw
    name, parameters = content
    if name not in named:
        raise ValueError(f"{path}: scenario: expected one of {', '.join(named)}, found {name!r}")
    known = parameter_names(named[name])
    refuse_unknown(f"{path}: parameters", parameters, known)
    return functools.partial(named[name], **parameters)


def digest(path: Path | str) -> str:
    """SHA-256 of what a scenario file says, the map included that it names."""
    path = Path(path)
    content = _read(path)
    found = hashlib.sha256(path.read_bytes())
    if isinstance(content, Description) and isinstance(content.ground, Map):
        ground = content.ground
        found.update(repr((ground.bounds, ground.background)).encode())
        found.update(ground.walls.tobytes())
        for surface, polygon in ground.surfaces:
            found.update(bytes([surface]) + polygon.tobytes())
    return found.hexdigest()


def _read(path: Path) -> Description | Named:
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: expected YAML in UTF-8, found {error}") from error
    return _parse(path, text)


@lru_cache(maxsize=64)
def _parse(path: Path, text: str) -> Description | Named:
    """What a file of this text says; its map lies beside it."""
    try:
        content = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ValueError(f"{path}: expected YAML, found {error}") from error
    where = str(path)
    if isinstance(content, Mapping) and "scenario" in content:
        keys = section(where, content, ("scenario",), ("parameters",))
        parameters = keys.get("parameters", {})
        if not isinstance(parameters, Mapping):
            raise ValueError(f"{where}: parameters: expected keys and values, found {parameters!r}")
        return str(keys["scenario"]), dict(parameters)
    return _description(path, section(where, content, DESCRIBED, OPTIONS))


def _description(path: Path, keys: Mapping[str, Any]) -> Description:
    where = str(path)
    robot = section(f"{where}: robot", keys["robot"], ("start", "goal"), ())
    people = items(f"{where}: people", keys["people"])
    if not people:
        raise ValueError(f"{where}: people: expected at least one flow, found none")
    return Description(
        source=where,
        name=str(keys.get("name", path.stem)),
        ground=_ground(path, keys["map"]),
        flows=tuple(_flow(f"{where}: people[{i}]", flow) for i, flow in enumerate(people)),
        robot_start=_region(f"{where}: robot.start", robot["start"], pose=True),
        robot_goal=_region(f"{where}: robot.goal", robot["goal"]),
        behaviour=_behaviour(f"{where}: behaviour", keys.get("behaviour")),
        time_limit=number(f"{where}: time_limit", keys.get("time_limit", 30.0)),
    )


def _ground(path: Path, content: Any) -> Map | PlaceChoice:
    """A map file beside the scenario's, a place, or a map that stands here."""
    where = f"{path}: map"
    if isinstance(content, str):
        return read_map(path.parent / content)
    if isinstance(content, Mapping) and "place" in content:
        keys = section(where, content, ("place",), ("layout",))
        if keys["place"] not in PLACES:
            known = ", ".join(PLACES)
            raise ValueError(f"{where}.place: expected one of {known}, found {keys['place']!r}")
        layout = whole_numbers(f"{where}.layout", keys.get("layout", 0), LAYOUTS - 1)
        return PlaceChoice(kind=keys["place"], layout=layout)
    return _inline_map(where, content)


def _inline_map(where: str, content: Any) -> Map:
    keys = section(where, content, ("bounds",), ("background", "surfaces", "walls"))
    background = keys.get("background", "pavement")
    _require_surface(f"{where}.background", background)
    surfaces = items(f"{where}.surfaces", keys.get("surfaces", []))
    walls = items(f"{where}.walls", keys.get("walls", []))
    x_min, y_min, x_max, y_max = numbers(f"{where}.bounds", keys["bounds"], (4,))
    parts = tuple(_surface(f"{where}.surfaces[{i}]", part) for i, part in enumerate(surfaces))
    lines = [_points(f"{where}.walls[{i}]", line, 2) for i, line in enumerate(walls)]
    segments = [np.stack([line[:-1], line[1:]], axis=1) for line in lines]
    try:
        return Map(
            bounds=(x_min, y_min, x_max, y_max),
            surfaces=parts,
            walls=np.concatenate([np.empty((0, 2, 2)), *segments]),
            background=SURFACES[background],
        )
    except ValueError as error:
        raise ValueError(f"{where}.{error}") from error


def _surface(where: str, content: Any) -> tuple[Surface, NDArray[np.float64]]:
    """A surface and its corners, from `building: [[0, 0], …]` or `building: [0, 0, 4, 3]`."""
    if not isinstance(content, Mapping) or len(content) != 1:
        raise ValueError(f"{where}: expected one surface and its corners, found {content!r}")
    ((name, corners),) = content.items()
    _require_surface(where, name)
    if isinstance(corners, Sequence) and len(corners) == 4 and is_number(corners[0]):
        return SURFACES[name], box(*numbers(f"{where}.{name}", corners, (4,)))
    return SURFACES[name], _points(f"{where}.{name}", corners, 3)


def _require_surface(where: str, name: Any) -> None:
    if name not in SURFACES:
        raise ValueError(f"{where}: expected one of {', '.join(SURFACES)}, found {name!r}")


def _points(where: str, content: Any, least: int) -> NDArray[np.float64]:
    """Points (P, 2)."""
    points = items(where, content)
    if len(points) < least:
        raise ValueError(f"{where}: expected at least {least} points, found {len(points)}")
    return np.array([numbers(f"{where}[{i}]", point, (2,)) for i, point in enumerate(points)])


def _flow(where: str, content: Any) -> Flow:
    keys = section(where, content, ("count", "start", "goal"), PEOPLE)
    via = items(f"{where}.via", keys.get("via", []))
    groups = number(f"{where}.groups", keys.get("groups", 0.0))
    if not 0.0 <= groups <= 1.0:
        raise ValueError(f"{where}.groups: expected a share of 0 to 1, found {groups}")
    spread = keys.get("spread", False)
    if not isinstance(spread, bool):
        raise ValueError(f"{where}.spread: expected true or false, found {spread!r}")
    on_arrival = keys.get("on_arrival", "respawn")
    if on_arrival not in ON_ARRIVAL:
        known = ", ".join(ON_ARRIVAL)
        raise ValueError(f"{where}.on_arrival: expected one of {known}, found {on_arrival!r}")
    return Flow(
        count=whole_numbers(f"{where}.count", keys["count"], MOST_PEOPLE),
        start=_region(f"{where}.start", keys["start"]),
        via=tuple(_region(f"{where}.via[{i}]", region) for i, region in enumerate(via)),
        goal=_region(f"{where}.goal", keys["goal"]),
        desired_speed=_speed(f"{where}.desired_speed", keys.get("desired_speed")),
        groups=groups,
        spread=spread,
        on_arrival=on_arrival,
        model=_model(f"{where}.model", keys.get("model", "social_force")),
    )


def _speed(where: str, content: Any) -> tuple[float, float] | None:
    """Mean and deviation; one number is everybody's speed."""
    if content is None:
        return None
    mean, deviation = (
        (number(where, content), 0.0) if is_number(content) else numbers(where, content, (2,))
    )
    if mean < 0.0 or deviation < 0.0:
        raise ValueError(f"{where}: expected at least 0 m/s, found {content}")
    return mean, deviation


def _model(where: str, content: Any) -> str | dict[str, float]:
    try:
        draw_models(np.random.default_rng(0), 0, content)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{where}: expected a motion model, or shares; {error}") from error
    model: str | dict[str, float] = content
    return model


def _behaviour(where: str, content: Any) -> Behaviour | None:
    if content is None:
        return None
    known = [column.name for column in dataclasses.fields(Behaviour)]
    settings = {
        key: number(f"{where}.{key}", value)
        for key, value in section(where, content, (), known).items()
    }
    return Behaviour(**settings)


def _region(where: str, content: Any, *, pose: bool = False) -> Region:
    """A point, a box, a word for parts of a place, and where a `pose` may stand, one."""
    if content in (ENTRANCES, STOPS):
        return str(content)
    region = numbers(where, content, (2, 3, 4) if pose else (2, 4))
    if len(region) == 4 and not (region[0] <= region[2] and region[1] <= region[3]):
        raise ValueError(f"{where}: expected [x_min, y_min, x_max, y_max], found {content}")
    return region
