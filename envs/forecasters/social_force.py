"""The social force model as a forecaster: the crowd that was seen, rolled on without knowing more.

What the simulator's people know and an observer does not is inferred: everybody goes on where the
last displacement leads, at that speed; all have the same body; and nobody's whims can be foreseen.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.distance_field import distance_field
from crowdsim.forces import ETH_UCY, SocialForce, accelerations
from crowdsim.line_of_sight import Screens, list_walls, screens
from crowdsim.map import Map
from crowdsim.mixed_crowd import LEAST_MAX_SPEED, accelerate
from envs.forecasters.situation import Flags, Floats, Situation, WorldForecast
from envs.forecasters.tracks import radius_of
from predictor.inputs import check_tracks, last_step

SOCIAL_FORCE: Final = "social_force"
PARAMETERS: Final = {
    SOCIAL_FORCE: SocialForce(),
    f"{SOCIAL_FORCE}@eth_ucy": ETH_UCY,
}
"""By the names of the forecasters: the simulator's own, and those fitted to crowds_zara02 and
students003, which are tests of two of ETH/UCY's folds and training crowds of the others."""
GOAL_DISTANCE: Final = 2.0
"""How far ahead the goal lies, in horizons: nobody gets there while being forecast."""
BODY_RADIUS: Final = 0.25
"""Mean of the simulated people [m]."""
RELAXATION_TIME: Final = 0.5
"""Likewise [s] (Helbing and Molnár 1995)."""
LONGEST_STEP: Final = 0.1
"""Of the integration [s]."""

Walls = tuple[Floats, Floats, float, Screens]
"""What the kernel takes of a map: grid, origin and spacing of its distance field, and what hides
people from each other."""

OPEN_GROUND: Final[Walls] = (
    np.empty((0, 0, 3)),
    np.zeros(2),
    0.1,
    list_walls(np.empty((0, 2, 2)), SocialForce().interaction_range),
)


class SocialForceForecaster:
    """Rolls people on by the social force, behind `predictor.forecaster.Forecaster`.

    Pictures tell it no walls; `roll_on` takes the maps of worlds.

    Args:
        name: Of its parameters, key of `PARAMETERS`.
        forecast_steps: Frames to forecast.
        history_steps: Frames of history.
        frame_dt: Time between two frames [s].
    """

    def __init__(
        self,
        name: str = SOCIAL_FORCE,
        *,
        forecast_steps: int = 12,
        history_steps: int = 8,
        frame_dt: float = 0.4,
    ) -> None:
        self.name = name
        self._model = PARAMETERS[name]
        self.forecast_steps = forecast_steps
        self.history_steps = history_steps
        self.frame_dt = frame_dt

    def forecast(
        self,
        history: Floats,
        valid: Flags,
        map_images: Sequence[NDArray[np.uint8] | None] | NDArray[np.uint8] | None = None,
        pixel_from_world: Sequence[Floats | None] | Floats | None = None,
        select: Flags | None = None,
    ) -> Floats:
        """Forecasts as `Forecaster.forecast` says, on open ground."""
        check_tracks(history, valid, select)
        if history.ndim == 3:
            chosen = None if select is None else select[None]
            return np.asarray(self.roll_on(history[None], valid[None], [None], chosen)[0])
        return self.roll_on(history, valid, [None] * len(history), select)

    def roll_on(
        self, history: Floats, valid: Flags, maps: Sequence[Map | None], select: Flags | None
    ) -> Floats:
        """Rolls W worlds on between their walls.

        Args:
            history: (W, T, N, 2) positions [m], the last one now.
            valid: (W, T, N).
            maps: W maps; None is open ground.
            select: (W, N), whom to forecast; None forecasts everyone seen now.

        Returns:
            (W, F, N, 2) positions [m], as `Forecaster.forecast` says.
        """
        seen = valid[:, -1]
        now = np.where(seen[..., None], history[:, -1], 0.0)
        velocity = last_step(history, valid)[0] / self.frame_dt
        path = np.repeat(now[:, None], self.forecast_steps, axis=1)
        for world, map_ in enumerate(maps):
            people = np.flatnonzero(seen[world])
            bodies = np.concatenate([now[world, people], velocity[world, people]], axis=1)
            rolled = self._rolled(bodies, self._walls(map_))
            chosen = people if select is None else people[select[world, people]]
            path[world][:, chosen] = rolled[:, np.isin(people, chosen)]
        return path

    def _walls(self, map_: Map | None) -> Walls:
        if map_ is None:
            return OPEN_GROUND
        field = distance_field(map_)
        return field.grid, field.origin, field.cell, screens(map_, self._model.interaction_range)

    def _rolled(self, bodies: Floats, walls: Walls) -> Floats:
        """(F, P, 2) positions of (P, 4) bodies that want to keep their velocities."""
        goal = bodies[:, :2] + GOAL_DISTANCE * self.forecast_steps * self.frame_dt * bodies[:, 2:]
        speed = np.hypot(bodies[:, 2], bodies[:, 3])
        steps = max(1, round(self.frame_dt / LONGEST_STEP))
        dt, model = self.frame_dt / steps, self._model.record()
        frames = self.forecast_steps
        return np.asarray(rolled_on(bodies, goal, speed, *walls, model, frames, steps, dt))


class SocialForceBetweenWalls:
    """The same for an environment: it knows the walls, and the robot is one of the people."""

    def __init__(self, forecaster: SocialForceForecaster):
        self._forecaster = forecaster

    def restart(self, world: int, rng: np.random.Generator) -> None:
        """Has nothing to remember."""

    def forecast(self, situation: Situation) -> WorldForecast:
        """Forecasts as `WorldForecaster.forecast` says."""
        history = np.concatenate((situation.history, situation.robot_history[:, :, None]), axis=2)
        valid = np.concatenate((situation.valid, situation.robot_valid[:, :, None]), axis=2)
        nobody = np.zeros((len(history), 1), dtype=np.bool_)
        select = np.concatenate((situation.select, nobody), axis=1)
        worlds = situation.worlds
        maps = [worlds.running(world).scenario.map for world in situation.indices.tolist()]
        path = self._forecaster.roll_on(history, valid, maps, select)
        return WorldForecast(position=path[:, :, :-1], radius=radius_of(self._forecaster))


@njit(cache=True, error_model="numpy")
def rolled_on(
    bodies: Floats,
    goal: Floats,
    desired_speed: Floats,
    wall_grid: Floats,
    wall_origin: Floats,
    wall_cell: float,
    hiding: Screens,
    model: NDArray[np.void],
    frames: int,
    steps: int,
    dt: float,
) -> Floats:
    """Positions (F, P, 2) [m] of people whom only the social force moves.

    Args:
        bodies: (P, 4) x, y, vx, vy; changed in place.
        goal: (P, 2) where they go [m].
        desired_speed: (P,) [m/s].
        wall_grid: Of a `DistanceField`.
        wall_origin: Of it [m].
        wall_cell: Of it [m].
        hiding: The walls, listed for looks over the interaction range.
        model: Parameters, as `SocialForce.record` gives them.
        frames: F.
        steps: Of the integration per frame.
        dt: Length of one of them [s].
    """
    count = len(bodies)
    present, noise = np.ones(count, dtype=np.bool_), np.zeros((count, 2))
    radius, relaxation_time = np.full(count, BODY_RADIUS), np.full(count, RELAXATION_TIME)
    max_speed = np.maximum(model[0].max_speed_ratio * desired_speed, LEAST_MAX_SPEED)
    path = np.empty((frames, count, 2))
    for frame in range(frames):
        for _ in range(steps):
            direction = _towards(goal, bodies)
            acceleration = accelerations(
                bodies,
                present,
                radius,
                direction,
                desired_speed,
                relaxation_time,
                present,
                noise,
                dt,
                wall_grid,
                wall_origin,
                wall_cell,
                hiding,
                model,
            )
            accelerate(bodies, acceleration, max_speed, dt)
            bodies[:, :2] += dt * bodies[:, 2:]
        path[frame] = bodies[:, :2]
    return path


@njit(cache=True, error_model="numpy")
def _towards(goal: Floats, bodies: Floats) -> Floats:
    """Unit vectors (P, 2) from bodies to their goals; 0 for who is there."""
    direction = np.zeros_like(goal)
    for i in range(len(goal)):
        x, y = goal[i, 0] - bodies[i, 0], goal[i, 1] - bodies[i, 1]
        distance = np.hypot(x, y)
        if distance > 1e-6:
            direction[i, 0], direction[i, 1] = x / distance, y / distance
    return direction
