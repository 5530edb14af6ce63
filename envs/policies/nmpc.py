"""A planner that optimizes its controls against the forecasts by nonlinear programming."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from envs.config import CrowdNavConfig, whole_multiple
from envs.policies.mppi import CHANCE
from envs.policies.optimal_control import CONTROL, POSE, STATE, Program
from envs.policies.policy import Observation, Policy
from envs.policies.robot_motion import Limits, advance, feasible, steer
from envs.policies.rollouts import SPREADING, Costs, Scene
from envs.policies.scenes import SceneReader, to_actions

Floats = NDArray[np.float64]

HORIZON = 4.8
"""How far it plans [s]."""

WALLS = 4
"""Points of walls that a step of a plan keeps clear of: those nearest to where it starts from."""

BOW = 1.2, 1.5
"""Angle [rad] by which plans to the left and to the right start out, and for how long [s]."""

FAR = 1e3
"""Where nobody is [m]."""


class NMPCPolicy(Policy):
    """Nonlinear model predictive control on forecasts, for every kind of robot.

    Every call improves the plan of the last one, shifted by a step, and one straight to the target
    and one in a bow to either side, since an optimizer stays on the side of a person on which it
    begins; the cheapest is followed. How people are expected to move, `SceneReader` says.
    """

    name = "nmpc"

    def __init__(self, config: CrowdNavConfig) -> None:
        self._costs = Costs(chance=CHANCE)
        steps = whole_multiple("horizon", HORIZON, "policy_dt", config.policy_dt)
        self._reader = SceneReader(config, steps, self._costs.wall_margin)
        limits, obstacles = self._reader.limits, config.pedestrians_observed + WALLS
        self._program = Program(limits, self._costs, steps, obstacles)
        self._people = config.pedestrians_observed
        self._plans: dict[int, Floats] = {}

    def reset(self, mask: NDArray[np.bool_] | None = None) -> None:
        """Forgets the plans of finished episodes; see `Policy.reset`."""
        for world in list(self._plans) if mask is None else np.flatnonzero(mask).tolist():
            self._plans.pop(world, None)

    def act_batch(self, observation: Observation) -> NDArray[np.float32]:
        """Returns the first controls of W improved plans; see `Policy.act`."""
        for world, scene in enumerate(self._reader.scenes(observation)):
            self._plans[world] = self._best(scene, self._plans.get(world))
        first = np.array([self._plans[world][0] for world in range(len(observation["robot"]))])
        return np.clip(to_actions(first, self._reader.limits), -1.0, 1.0)

    def _best(self, scene: Scene, last: Floats | None) -> Floats:
        """The cheapest of several plans (H, 2)."""
        limits, velocity = self._reader.limits, scene.velocity
        targets, plans = self._targets(scene), []
        starts = [bowed(velocity, targets, angle, limits) for angle in (0.0, BOW[0], -BOW[0])]
        if last is not None:
            starts.append(np.concatenate((last[1:], last[-1:])))
        for start in starts:
            guess = rolled_out(start, velocity, limits)
            plans.append(self._program.solve(guess, self._question(scene, targets, guess)))
        return min(plans, key=lambda plan: plan[0])[1]

    def _targets(self, scene: Scene) -> Floats:
        """What each step heads for (H, 2): the goal, or the waypoint before where that bends."""
        limits, steps = self._reader.limits, self._reader.steps
        targets = np.tile(scene.goal, (steps, 1))
        across = scene.waypoint[0] * scene.goal[1] - scene.waypoint[1] * scene.goal[0]
        reach = np.hypot(*scene.waypoint)
        if abs(across) > 0.05 * reach * np.hypot(*scene.goal):
            on_the_way = limits.speed * limits.dt * np.arange(1, steps + 1) < reach
            targets[on_the_way] = scene.waypoint
        return targets

    def _question(self, scene: Scene, targets: Floats, guess: Floats) -> Floats:
        """The parameters of `Program`, one row per step."""
        costs, limits, steps = self._costs, self._reader.limits, self._reader.steps
        ahead = limits.dt * np.arange(1.0, steps + 1.0)
        here, there = self._people, scene.people.shape[1]
        place = np.full((steps, here + WALLS, 2), FAR)
        reach = np.full((steps, here + WALLS), limits.radius)
        margin = np.full((steps, here + WALLS), costs.wall_margin)
        weight = np.zeros((steps, here + WALLS, 2))  # near, and in contact
        place[:, :there], reach[:, :there] = scene.people, scene.reach
        certain = costs.person_margin + costs.spread * np.minimum(ahead, SPREADING)
        margin[:, :there] = certain[:, None] + costs.chance * scene.doubt
        fading = costs.discount ** ahead[:, None]
        weight[:, :there] = fading[..., None] * (costs.person, costs.contact)
        place[:, here:] = nearest_points(scene.walls, guess[1:, :2])
        weight[:, here:] = costs.wall, costs.contact
        parts = (targets, place, reach, margin, weight)
        return np.concatenate([part.reshape(steps, -1) for part in parts], axis=1)


@njit(cache=True)
def bowed(velocity: Floats, targets: Floats, angle: float, limits: Limits) -> Floats:
    """Controls (H, 2) to the targets that start out by an angle to the left of them."""
    controls, x, y, heading = np.empty_like(targets), 0.0, 0.0, 0.0
    a, b, point = velocity[0], velocity[1], np.empty(2)
    for t in range(len(targets)):
        turn = angle if t * limits.dt < BOW[1] else 0.0
        dx, dy = targets[t, 0] - x, targets[t, 1] - y
        point[0] = x + math.cos(turn) * dx - math.sin(turn) * dy
        point[1] = y + math.sin(turn) * dx + math.cos(turn) * dy
        wanted = steer(x, y, heading, point, limits)
        a, b = feasible(wanted[0], wanted[1], a, b, limits)
        x, y, heading = advance(x, y, heading, a, b, limits)
        controls[t, 0], controls[t, 1] = a, b
    return controls


@njit(cache=True)
def rolled_out(controls: Floats, velocity: Floats, limits: Limits) -> Floats:
    """States under controls (H, 2), and the control that follows each: (H + 1, 7)."""
    states = np.zeros((len(controls) + 1, STATE + CONTROL))
    states[0, POSE:STATE] = velocity
    states[:-1, STATE:] = controls
    states[1:, POSE:STATE] = controls
    x, y, heading = 0.0, 0.0, 0.0
    for t in range(len(controls)):
        x, y, heading = advance(x, y, heading, controls[t, 0], controls[t, 1], limits)
        states[t + 1, 0], states[t + 1, 1], states[t + 1, 2] = x, y, heading
    return states


def nearest_points(walls: Floats, path: Floats) -> Floats:
    """The `WALLS` points of walls (P, 4) that are nearest to each point of a path (H, 2)."""
    points = np.concatenate(
        (walls[:, :2], walls[:, :2] + 0.5 * walls[:, 2:], np.full((WALLS, 2), FAR))
    )
    distance = np.hypot(*np.moveaxis(points - path[:, None], -1, 0))
    return points[np.argsort(distance, axis=1, kind="stable")[:, :WALLS]]
