"""The mixture of scenarios that training sets are drawn from.

Its crowds were set beside ETH/UCY (`tests/validation/training_crowds.py`): there a sixth of the
people stand, half walk with somebody, whole crowds are slower or faster than others, and next to
nobody turns on the spot. So nobody here walks back where he or she came from (`on_arrival`
`return`), and maps are others than those that environments and evaluations draw.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from crowdsim.motion import ModelChoice
from crowdsim.pedestrians import Pedestrians
from crowdsim.scenario import Scenario
from crowdsim.scenarios.circular import (
    ARRANGEMENTS,
    circular_crossing,
    circular_crossing_with_static_obstacles,
)
from crowdsim.scenarios.corridor import narrow_hallway, parallel_traffic
from crowdsim.scenarios.crowds import crowd_navigation
from crowdsim.scenarios.described import Description, Flow
from crowdsim.scenarios.junctions import intersection, t_intersection
from crowdsim.scenarios.open_ground import group_crossing, perpendicular_traffic, random_crossing
from crowdsim.scenarios.placement import parties
from crowdsim.scenarios.public_place import DRAWN
from crowdsim.scenarios.regions import ENTRANCES, PlaceChoice
from crowdsim.scenarios.rooms import bottleneck, entering_room, exiting_room
from crowdsim.scenarios.station import station_hall
from crowdsim.scenarios.urban import LAYOUTS, STREETS, urban_crossing

MIXED: Final = "mixed"
"""Name for a draw among `MIXTURE`."""
FEW: Final = 12
"""Layouts of places that are drawn: ways are found once per layout and process."""

Generator = np.random.Generator
Parameters = dict[str, Any]


def _crowd(rng: Generator, low: int, high: int) -> Parameters:
    """How many people, and which share of them walk in groups."""
    return {
        "pedestrians": int(rng.integers(low, high, endpoint=True)),
        "groups": round(rng.uniform(0.2, 0.8), 2),
    }


def _length(rng: Generator, low: float, high: float) -> float:
    return round(rng.uniform(low, high), 1)


def _circle(rng: Generator) -> Parameters:
    return {
        "pedestrians": int(rng.integers(6, 25)),
        "radius": _length(rng, 6.0, 10.0),
        "on_arrival": "respawn",
    }


def _planters(rng: Generator) -> Parameters:
    return {
        "pedestrians": int(rng.integers(6, 17)),
        "radius": _length(rng, 6.0, 9.0),
        "layout": int(rng.integers(ARRANGEMENTS, LAYOUTS)),
    }


def _square(rng: Generator) -> Parameters:
    return {
        **_crowd(rng, 25, 60),
        "size": _length(rng, 12.0, 18.0),
        "standing": round(rng.uniform(0.1, 0.6), 2),
    }


def _open(rng: Generator) -> Parameters:
    return {**_crowd(rng, 20, 50), "size": _length(rng, 10.0, 18.0)}


def _groups(rng: Generator) -> Parameters:
    crowd = _crowd(rng, 12, 36)
    return {**crowd, "groups": round(rng.uniform(0.6, 1.0), 2), "width": _length(rng, 6.0, 12.0)}


def _junction(rng: Generator) -> Parameters:
    return {**_crowd(rng, 8, 28), "width": _length(rng, 3.0, 6.0)}


def _neck(rng: Generator) -> Parameters:
    return {"pedestrians": int(rng.integers(8, 21)), "width": _length(rng, 1.0, 2.4)}


def _stream(rng: Generator) -> Parameters:
    return {**_crowd(rng, 12, 36), "width": _length(rng, 5.0, 10.0), "from_left": rng.uniform()}


def _corridor(rng: Generator) -> Parameters:
    width = _length(rng, 3.0, 8.0)
    return {**_crowd(rng, 10, round(6.0 * width)), "width": width, "oncoming": rng.uniform()}


def _hallway(rng: Generator) -> Parameters:
    return {
        "pedestrians": int(rng.integers(2, 7)),
        "width": _length(rng, 1.6, 2.4),
        "oncoming": rng.uniform(),
    }


def _room(rng: Generator) -> Parameters:
    return {
        "pedestrians": int(rng.integers(6, 17)),
        "door_width": _length(rng, 1.0, 2.4),
        "room_length": _length(rng, 6.0, 9.0),
        "room_width": _length(rng, 6.0, 9.0),
    }


def _layout(rng: Generator) -> Parameters:
    return {**_crowd(rng, 16, 40), "layout": int(rng.integers(DRAWN, DRAWN + FEW))}


def _street(rng: Generator) -> Parameters:
    return {**_crowd(rng, 14, 40), "layout": int(rng.integers(STREETS, LAYOUTS))}


def _place(kind: str) -> Callable[..., Scenario]:
    """Generator of people who walk between the entrances of a place of a kind."""

    def draw(
        rng: Generator,
        *,
        pedestrians: int,
        groups: float,
        layout: int,
        model: ModelChoice = "social_force",
    ) -> Scenario:
        walkers = Flow(
            count=(pedestrians, pedestrians),
            start=ENTRANCES,
            goal=ENTRANCES,
            groups=groups,
            spread=True,
            model=model,
        )
        return Description(
            source=MIXED,
            name=kind,
            ground=PlaceChoice(kind=kind, layout=(layout, layout)),
            flows=(walkers,),
            robot_start=ENTRANCES,
            robot_goal=ENTRANCES,
        ).draw(rng)

    return draw


@dataclass(frozen=True, kw_only=True)
class Ingredient:
    """A kind of crowd in the mixture.

    Attributes:
        share: Of the recordings.
        make: Generator of scenarios.
        parameters: Draws its parameters.
        standing: Greatest share of the people who stand where they would have started to walk; 0
            where they would be in the way.
    """

    share: float
    make: Callable[..., Scenario]
    parameters: Callable[[Generator], Parameters]
    standing: float = 0.0


MIXTURE: Final = (
    Ingredient(share=0.20, make=crowd_navigation, parameters=_square),
    Ingredient(share=0.13, make=random_crossing, parameters=_open, standing=0.5),
    Ingredient(share=0.05, make=perpendicular_traffic, parameters=_stream, standing=0.2),
    Ingredient(share=0.05, make=group_crossing, parameters=_groups, standing=0.2),
    Ingredient(share=0.15, make=parallel_traffic, parameters=_corridor, standing=0.2),
    Ingredient(share=0.14, make=urban_crossing, parameters=_street, standing=0.3),
    Ingredient(share=0.04, make=_place("square"), parameters=_layout, standing=0.5),
    Ingredient(share=0.03, make=_place("street"), parameters=_layout, standing=0.4),
    Ingredient(share=0.03, make=_place("mall"), parameters=_layout, standing=0.4),
    Ingredient(share=0.03, make=station_hall, parameters=_layout, standing=0.4),
    Ingredient(share=0.03, make=intersection, parameters=_junction),
    Ingredient(share=0.03, make=t_intersection, parameters=_junction),
    Ingredient(share=0.02, make=circular_crossing, parameters=_circle),
    Ingredient(share=0.02, make=circular_crossing_with_static_obstacles, parameters=_planters),
    Ingredient(share=0.01, make=narrow_hallway, parameters=_hallway),
    Ingredient(share=0.015, make=entering_room, parameters=_room),
    Ingredient(share=0.015, make=exiting_room, parameters=_room),
    Ingredient(share=0.01, make=bottleneck, parameters=_neck),
)
"""What the recordings of `mixed` are; the shares add up to 1."""
PACE: Final = (0.65, 1.2)
"""Between which the desired speeds of a whole crowd are scaled: recorded crowds differ so much."""


def draw_mixed(rng: Generator, *, model: ModelChoice | None = None) -> Scenario:
    """Draw one scenario of the mixture.

    Args:
        rng: Source of all draws.
        model: Motion model of all people, or the share of each; None leaves it to the scenario.
    """
    shares = [ingredient.share for ingredient in MIXTURE]
    ingredient = MIXTURE[rng.choice(len(MIXTURE), p=shares)]
    parameters = ingredient.parameters(rng)
    if model is not None:
        parameters["model"] = model
    scenario = ingredient.make(rng, **parameters)
    people = _paced(scenario.pedestrians, rng.uniform(*PACE))
    people = _some_stand(rng, people, rng.uniform(0.0, ingredient.standing))
    return replace(scenario, pedestrians=people)


def _paced(people: Pedestrians, pace: float) -> Pedestrians:
    return replace(
        people, desired_speed=pace * people.desired_speed, velocity=pace * people.velocity
    )


def _some_stand(rng: Generator, people: Pedestrians, share: float) -> Pedestrians:
    """Let a share of the parties stand where they are."""
    walks = np.ones(len(people))
    for first, size in parties(people.group):
        walks[first : first + size] = rng.random() >= share
    return replace(
        people,
        desired_speed=walks * people.desired_speed,
        velocity=walks[:, None] * people.velocity,
    )
