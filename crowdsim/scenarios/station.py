"""A railway station: people between doors, trains and shops, and a robot on an errand."""

from dataclasses import replace

import numpy as np

from crowdsim.motion import ModelChoice
from crowdsim.scenario import Scenario
from crowdsim.scenarios.public_place import public_place


def station_hall(
    rng: np.random.Generator,
    *,
    pedestrians: int = 30,
    layout: int | None = None,
    groups: float = 0.0,
    model: ModelChoice = "social_force",
) -> Scenario:
    """People walk between the doors, trains and shops of a station; the robot runs an errand.

    A generated terminus (`crowdsim.maps`) with pillars, barriers and kiosks. Who has left through a
    gate enters again as a new person through the one that he or she came from.

    Args:
        rng: Source of all draws.
        pedestrians: Number of people, 0 to 200.
        layout: Which station, 0 to 99,999; None draws one of the first 8. The first time that a
            process meets a station it takes a few seconds to find the ways.
        groups: Share of people who walk in groups, 0 to 1.
        model: Motion model of all, or the share of each.

    Raises:
        ValueError: A parameter is out of range, or there is no room for all people.
    """
    scenario = public_place(
        rng, place="station", pedestrians=pedestrians, layout=layout, groups=groups, model=model
    )
    return replace(scenario, name="station_hall")
