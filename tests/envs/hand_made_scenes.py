"""Scenarios set by hand: a few people where a test wants them, and a robot."""

import numpy as np

from crowdsim.map import Map
from crowdsim.pedestrians import Pedestrians
from crowdsim.scenario import Scenario

OPEN_GROUND = Map(bounds=(-20.0, -20.0, 20.0, 20.0))


def set_scene(
    rng: np.random.Generator,
    *,
    people: object = (),
    goals: object = None,
    speed: float = 1.0,
    ground: Map = OPEN_GROUND,
    robot: tuple[float, float, float] = (0.0, 0.0, 0.0),
    goal: tuple[float, float] = (8.0, 0.0),
    time_limit: float = 10.0,
) -> Scenario:
    """People at `people` (N, 2) who walk to `goals` (N, 2), or stand, and a robot."""
    start = np.array(people, dtype=np.float64).reshape(-1, 2)
    stands = goals is None
    return Scenario(
        name="by_hand",
        map=ground,
        pedestrians=Pedestrians.draw(
            rng,
            position=start,
            waypoints=start if stands else np.array(goals, dtype=np.float64).reshape(-1, 2),
            desired_speed=0.0 if stands else speed,
            radius=0.25,
        ),
        robot_start=robot,
        robot_goal=goal,
        time_limit=time_limit,
    )
