"""What the knobs of stress tests turn, and how far they can be turned."""

import numpy as np
import pytest

from crowdsim.maps import PLACES, make_place
from crowdsim.scenarios import make_scenario
from crowdsim.scenarios.mixed import MIXTURE
from crowdsim.scenarios.public_place import DRAWN
from envs.evaluation.comparison import ScenarioChoice
from envs.evaluation.knobs import KNOBS, turned

CIRCLE = ScenarioChoice(scenario="circular_crossing")


def test_a_square_holds_one_per_square_metre() -> None:
    choice = turned(ScenarioChoice(scenario="random_crossing"), "density", 1.0)
    assert choice.parameters == {"pedestrians": 256}


def test_more_people_than_find_room_are_refused_with_the_limit() -> None:
    with pytest.raises(ValueError, match=r"circular_crossing has room for at most 0\.2. people"):
        turned(CIRCLE, "density", 0.5)
    with pytest.raises(ValueError, match="replay takes scene, data; got pedestrians"):
        turned(ScenarioChoice(scenario="replay"), "density", 0.1)


def test_places_keep_the_people_and_leave_the_rest() -> None:
    parameters = {"pedestrians": 5, "radius": 7.0, "behaviour": {"stop_rate": 0.1}}
    choice = ScenarioChoice(scenario="circular_crossing", parameters=parameters)
    mall = turned(choice, "map", "mall")
    assert mall.scenario == "public_place"
    assert mall.parameters == {
        "pedestrians": 5,
        "behaviour": {"stop_rate": 0.1},
        "place": "mall",
    }


def test_training_knows_neither_these_layouts_nor_other_models() -> None:
    rng = np.random.default_rng(0)
    drawn = [item.parameters(rng) for item in MIXTURE for _ in range(50)]
    layouts = [parameters["layout"] for parameters in drawn if "layout" in parameters]
    assert min(layouts) >= DRAWN
    assert not any("model" in parameters for parameters in drawn)
    scenario = make_scenario("public_place", rng, place="street", pedestrians=2)
    assert any(scenario.map is make_place("street", layout).map for layout in range(DRAWN))
    assert set(KNOBS["map"].values) == set(PLACES)
