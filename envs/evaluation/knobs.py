"""What a stress test turns: one thing at a time, from what is usual to what is hard."""

import bisect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
import shapely

from crowdsim.maps import PLACES
from crowdsim.motion import MODEL_NAMES
from crowdsim.scenarios import make_scenario
from envs.evaluation.comparison import ScenarioChoice

Setting = float | int | bool | str

DRAWS: Final = 5
"""Draws of a scenario in all of which people must find room."""


@dataclass(frozen=True, kw_only=True)
class Knob:
    """One thing that can be made harder.

    Attributes:
        label: What the axis of a plot says, with the unit.
        values: Where it is turned to unless told otherwise, in the order of the axis.
        turn: Gives the scenario at a value.
    """

    label: str
    values: tuple[Setting, ...]
    turn: Callable[[ScenarioChoice, Any], ScenarioChoice]


def turned(choice: ScenarioChoice, name: str, value: Setting) -> ScenarioChoice:
    """Returns a scenario with one knob of `KNOBS` turned to a value; its title says so.

    Raises:
        ValueError: An unknown knob, or one that this scenario does not have.
    """
    if name not in KNOBS:
        raise ValueError(f"knob must be one of {', '.join(KNOBS)}, got {name!r}")
    scenario = KNOBS[name].turn(choice, value)
    return replace(scenario, title=f"{name}={value:g}" if is_number(value) else f"{name}={value}")


def is_number(value: Setting) -> bool:
    """Whether a value has a place on an axis; yes, no and names have none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def value_text(value: Setting) -> str:
    """A value in words."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return value if isinstance(value, str) else f"{value:.4g}"


def _environment(key: str) -> Callable[[ScenarioChoice, Any], ScenarioChoice]:
    """A keyword of `CrowdNavConfig`."""

    def turn(choice: ScenarioChoice, value: Any) -> ScenarioChoice:
        return replace(choice, settings={**choice.settings, key: value})

    return turn


def _parameter(key: str) -> Callable[[ScenarioChoice, Any], ScenarioChoice]:
    """A keyword of the scenario."""

    def turn(choice: ScenarioChoice, value: Any) -> ScenarioChoice:
        return replace(choice, parameters={**choice.parameters, key: value})

    return turn


def _behaviour(key: str) -> Callable[[ScenarioChoice, Any], ScenarioChoice]:
    """A keyword of `crowdsim.behaviour.Behaviour`."""

    def turn(choice: ScenarioChoice, value: Any) -> ScenarioChoice:
        present: Mapping[str, float] = choice.parameters.get("behaviour", {})
        return _parameter("behaviour")(choice, {**present, key: value})

    return turn


def _density(choice: ScenarioChoice, value: float) -> ScenarioChoice:
    """As many people as make this density on the ground of the scenario [1/m^2].

    Raises:
        ValueError: So many find no room to start in (says how many do), or the scenario does not
            take a number of people.
    """
    empty = {**choice.parameters, "pedestrians": 0}
    scenario = make_scenario(choice.scenario, np.random.default_rng(0), **empty)
    ground = shapely.box(*scenario.map.bounds).difference(scenario.map.obstacles).area
    count = round(value * ground)
    if not _has_room(choice, count):
        most = bisect.bisect_left(range(count), True, key=lambda n: not _has_room(choice, n)) - 1
        raise ValueError(
            f"density: {choice.scenario} has room for at most {most / ground:.2f} people per "
            f"square metre ({most} in all), expected {value} ({count})"
        )
    return _parameter("pedestrians")(choice, count)


def _has_room(choice: ScenarioChoice, count: int) -> bool:
    """Whether so many people find room in every one of `DRAWS` draws of a scenario."""
    parameters = {**choice.parameters, "pedestrians": count}
    try:
        for seed in range(DRAWS):
            make_scenario(choice.scenario, np.random.default_rng(seed), **parameters)
    except ValueError:
        return False
    return True


def _map(choice: ScenarioChoice, value: str) -> ScenarioChoice:
    """The same people in a generated place of a kind; what else the scenario takes is left out."""
    kept = {name: choice.parameters[name] for name in _OF_PEOPLE if name in choice.parameters}
    return replace(choice, scenario="public_place", parameters={**kept, "place": value})


_OF_PEOPLE: Final = ("pedestrians", "groups", "model", "behaviour")

KNOBS: Final[Mapping[str, Knob]] = {
    "horizon": Knob(
        label="forecast horizon [s]",
        values=(0.4, 1.2, 2.4, 4.8, 9.6, 19.2),
        turn=_environment("horizon"),
    ),
    # More find no room on the circle; `random_crossing` has room for 1 per square metre.
    "density": Knob(
        label="people on the ground [1/m²]", values=(0.05, 0.1, 0.15, 0.2), turn=_density
    ),
    "crowd_speed": Knob(
        label="people's speed against the usual",
        values=(0.5, 0.75, 1.0, 1.5, 2.0),
        turn=_environment("crowd_speed"),
    ),
    "awareness": Knob(
        label="share of people who notice the robot",
        values=(1.0, 0.75, 0.5, 0.25, 0.0),
        turn=_environment("robot_awareness"),
    ),
    "goal_changes": Knob(
        label="goal changes per person [1/s]",
        values=(0.0, 0.05, 0.1, 0.2),
        turn=_behaviour("goal_change_rate"),
    ),
    "sudden_stops": Knob(
        label="sudden stops per person [1/s]",
        values=(0.0, 0.05, 0.1, 0.2),
        turn=_behaviour("stop_rate"),
    ),
    # The bundled networks have seen `social_force` only: see `crowdsim.scenarios.mixed`.
    "motion_model": Knob(
        label="motion model of the people (networks know social_force)",
        values=MODEL_NAMES,
        turn=_parameter("model"),
    ),
    # Kinds that networks know, in layouts that they do not: `mixed` draws others.
    "map": Knob(
        label="kind of place, in layouts unseen in training", values=tuple(PLACES), turn=_map
    ),
    "missed_detections": Knob(
        label="share of missed detections",
        values=(0.0, 0.1, 0.2, 0.4, 0.6),
        turn=_environment("missed_detections"),
    ),
    "position_noise": Knob(
        label="noise of measured positions [m]",
        values=(0.0, 0.05, 0.1, 0.2, 0.4),
        turn=_environment("position_noise"),
    ),
    "frame_jitter": Knob(
        label="greatest age of a detection [s]",
        values=(0.0, 0.05, 0.1, 0.15, 0.2),
        turn=_environment("frame_jitter"),
    ),
    "track_losses": Knob(
        label="lost tracks per person [1/s]",
        values=(0.0, 0.1, 0.25, 0.5, 1.0),
        turn=_environment("track_loss_rate"),
    ),
    "occlusion": Knob(
        label="people and walls hide people", values=(False, True), turn=_environment("occlusion")
    ),
    "field_of_view": Knob(
        label="field of view [rad]",
        values=(2.0 * np.pi, 4.5, 3.0, 2.0, 1.0),
        turn=_environment("field_of_view"),
    ),
    "history": Knob(
        label="frames of history", values=(8, 6, 4, 3, 2, 1), turn=_environment("history_kept")
    ),
    "mission": Knob(
        label="length of the mission [s], 0 is a single way",
        values=(0.0, 60.0, 300.0, 1800.0),
        turn=_environment("mission"),
    ),
}
"""By name."""
