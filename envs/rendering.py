"""What a person sees of a running episode."""

import numpy as np
from numpy.typing import NDArray

from crowdsim.render import render_frame
from envs.episodes import Episodes


def render_world(episodes: Episodes, world: int) -> NDArray[np.uint8]:
    """Draws one world as it is now, with the histories and forecasts that the robot has.

    Returns:
        (H, W, 3) uint8 RGB.
    """
    crowd, robots = episodes.worlds.crowd, episodes.worlds.robots
    picture = episodes.picture(world)
    velocity = crowd.velocity[world]
    histories, forecasts = _observed_paths(episodes, world)
    x, y = robots.position[world].tolist()
    goal_x, goal_y = episodes.tasks.routes.goal[world].tolist()
    return render_frame(
        picture.image,
        picture.pixel_from_world,
        positions=crowd.position[world],
        radius=crowd.radius[world],
        valid=crowd.valid[world],
        ids=crowd.ids[world],
        headings=np.arctan2(velocity[:, 1], velocity[:, 0]),
        histories=histories,
        forecasts=forecasts,
        robot=(x, y, float(robots.heading[world])),
        robot_radius=episodes.config.robot_radius,
        robot_goal=(goal_x, goal_y),
    )


Paths = list[NDArray[np.float64]]


def _observed_paths(episodes: Episodes, world: int) -> tuple[Paths, Paths]:
    """Histories and forecasts by column; empty for people whom the robot does not observe."""
    percept, row = episodes.percept(world)
    columns = episodes.worlds.crowd.columns
    histories: Paths = [np.empty((0, 2))] * columns
    forecasts: Paths = [np.empty((0, 2))] * columns
    for place in np.flatnonzero(percept.observed.valid[row]):
        column = percept.observed.slot[row, place]
        histories[column] = percept.history[row, place][percept.history_valid[row, place]]
        if percept.forecast is not None:
            forecasts[column] = percept.forecast[row, place]
    return histories, ([] if percept.forecast is None else forecasts)
