"""Rollouts of the robot and what they cost: the numba half of the sampling planner.

Frame, units and controls are those of `envs.policies.robot_motion`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from envs.policies.robot_motion import Limits, advance, detour, feasible, steer

BRAKE, STEER = 1, 2
"""Rows of the sample table that hold no noise: stop now, and head for the target at full speed."""

SPREADING = 2.0
"""Time after which the margin around people grows no more [s]; a crowd would fill the room."""

NEGLIGIBLE = 16.0
"""Rollouts that cost this many temperatures more than the best one (1e-7 of its weight) end."""


class Costs(NamedTuple):
    """Weights of the rollout cost, per second unless said otherwise.

    Attributes:
        distance: Per metre of way that is left to the goal, turning included.
        terminal: Once, per metre of way that is left at the end of the rollout.
        contact: While nearer than `slack` to a person or a wall.
        slack: Clearance that counts as contact: plans are not followed to the centimetre [m].
        person: While touching the edge of a person; falls as a parabola to zero at `person_margin`.
        person_margin: Free space around a person that is left alone where possible [m].
        spread: Growth of `person_margin` per second ahead, as forecasts grow uncertain [m/s];
            it ends after `SPREADING` seconds.
        chance: Share of the radius that holds 9 in 10 people (`forecast_radius`) that is left alone
            beyond `person_margin`, up to its size after `SPREADING` seconds.
        wall: As `person`, for walls.
        wall_margin: As `person_margin`, for walls [m].
        smoothness: Per squared change of the control (in units of its limit) and step.
        discount: Factor on the costs of people per second ahead: later plans will mend the rest.
    """

    distance: float = 1.0
    terminal: float = 1.0
    contact: float = 100.0
    slack: float = 0.1
    person: float = 20.0
    person_margin: float = 0.5
    spread: float = 0.2
    chance: float = 0.0
    wall: float = 10.0
    wall_margin: float = 0.3
    smoothness: float = 0.1
    discount: float = 0.7


@njit(cache=True)
def past(x: float, y: float, waypoint: NDArray[np.float64]) -> bool:
    """Whether (x, y) lies beyond the waypoint as seen from the origin."""
    ahead = (x - waypoint[0]) * waypoint[0] + (y - waypoint[1]) * waypoint[1]
    return bool(ahead > 0.0)


@njit(cache=True)
def way_left(x: float, y: float, waypoint: NDArray[np.float64], goal: NDArray[np.float64]) -> float:
    """Length of the way from (x, y) over the waypoint to the goal, straight once past it [m]."""
    to_goal = math.hypot(x - goal[0], y - goal[1])
    if past(x, y, waypoint):
        return to_goal
    to_waypoint = math.hypot(x - waypoint[0], y - waypoint[1])
    return to_waypoint + math.hypot(goal[0] - waypoint[0], goal[1] - waypoint[1])


@njit(cache=True)
def proximity(clearance: float, margin: float, weight: float, costs: Costs) -> float:
    """Cost per second of being `clearance` metres away, surface to surface."""
    if clearance >= margin:
        return 0.0
    if clearance < costs.slack:
        return costs.contact + weight
    share = (margin - clearance) / (margin - costs.slack)
    return weight * share * share


@njit(cache=True)
def people_cost(
    x: float,
    y: float,
    ahead: float,
    people: NDArray[np.float64],
    reach: NDArray[np.float64],
    doubt: NDArray[np.float64],
    costs: Costs,
) -> float:
    """Cost per second of (x, y) in `ahead` seconds, among people (K, 2) with radii in `reach`.

    `doubt` (K,) is within how far of there 9 in 10 of them are expected [m].
    """
    certain = costs.person_margin + costs.spread * min(ahead, SPREADING)
    total = 0.0
    for k in range(len(people)):
        dx, dy = x - people[k, 0], y - people[k, 1]
        margin = certain + costs.chance * doubt[k]
        near = reach[k] + margin
        squared = dx * dx + dy * dy
        if squared < near * near:
            clearance = math.sqrt(squared) - reach[k]
            total += proximity(clearance, margin, costs.person, costs)
    return float(total * costs.discount**ahead)


@njit(cache=True)
def wall_cost(x: float, y: float, walls: NDArray[np.float64], radius: float, costs: Costs) -> float:
    """Cost per second of (x, y) for the nearest of the walls (P, 4)."""
    reach = radius + costs.wall_margin
    nearest = reach * reach
    for p in range(len(walls)):
        dx, dy = x - walls[p, 0], y - walls[p, 1]
        along_x, along_y = walls[p, 2], walls[p, 3]
        length = along_x * along_x + along_y * along_y
        if length > 0.0:
            share = min(max((dx * along_x + dy * along_y) / length, 0.0), 1.0)
            dx, dy = dx - share * along_x, dy - share * along_y
        nearest = min(nearest, dx * dx + dy * dy)
    clearance = math.sqrt(nearest) - radius
    return proximity(clearance, costs.wall_margin, costs.wall, costs)


class Scene(NamedTuple):
    """What one robot sees while it plans.

    Attributes:
        velocity: (2,) control that the robot follows now.
        waypoint: (2,) point to pass [m].
        goal: (2,) point to reach [m].
        people: (H, K, 2) positions at the end of each rollout step [m].
        reach: (K,) sums of the radii of robot and person [m].
        doubt: (H, K) radii within which 9 in 10 of them are expected of there [m]; after
            `SPREADING` seconds they grow no more.
        walls: (P, 4) pieces of wall, each a point and the way to its other end [m].
    """

    velocity: NDArray[np.float64]
    waypoint: NDArray[np.float64]
    goal: NDArray[np.float64]
    people: NDArray[np.float64]
    reach: NDArray[np.float64]
    doubt: NDArray[np.float64]
    walls: NDArray[np.float64]


@njit(cache=True)
def at_least(left: float, steps: int, limits: Limits, costs: Costs) -> float:
    """Smallest cost of `steps` more steps with `left` metres to go: straight, at full speed."""
    stride = limits.speed * limits.dt
    moving = min(steps, int(left / stride))
    path = moving * left - stride * 0.5 * moving * (moving + 1)
    return costs.distance * limits.dt * path + costs.terminal * max(left - steps * stride, 0.0)


@njit(cache=True)
def rollout(
    controls: NDArray[np.float64],
    steering: bool,
    worst: float,
    scene: Scene,
    limits: Limits,
    costs: Costs,
) -> float:
    """Rolls controls (H, 2) out from the origin and returns the cost.

    The controls are replaced by what the robot can follow (or, when `steering`, by what heads for
    the target). The rollout ends where the goal is reached, or, with infinite cost, as soon as
    the cost is bound to exceed `worst`.
    """
    x, y, heading, total = 0.0, 0.0, 0.0, 0.0
    last_a, last_b = scene.velocity[0], scene.velocity[1]
    unit = limits.speed if limits.holonomic else limits.angular_speed
    left = way_left(x, y, scene.waypoint, scene.goal)
    turn = 0.0
    for t in range(len(controls)):
        a, b = controls[t, 0], controls[t, 1]
        if steering:
            target = scene.goal if past(x, y, scene.waypoint) else scene.waypoint
            a, b = steer(x, y, heading, target, limits)
        a, b = feasible(a, b, last_a, last_b, limits)
        controls[t, 0], controls[t, 1] = a, b
        x, y, heading = advance(x, y, heading, a, b, limits)
        left = way_left(x, y, scene.waypoint, scene.goal)
        ahead = (t + 1) * limits.dt
        target = scene.goal if past(x, y, scene.waypoint) else scene.waypoint
        turn = detour(x, y, heading, target, limits)
        rate = costs.distance * (left + turn)
        rate += people_cost(x, y, ahead, scene.people[t], scene.reach, scene.doubt[t], costs)
        rate += wall_cost(x, y, scene.walls, limits.radius, costs)
        jerk = ((a - last_a) / limits.speed) ** 2 + ((b - last_b) / unit) ** 2
        total += rate * limits.dt + costs.smoothness * jerk
        last_a, last_b = a, b
        if math.hypot(x - scene.goal[0], y - scene.goal[1]) < limits.goal_radius:
            controls[t + 1 :] = controls[t]
            return float(total)
        if total + at_least(left, len(controls) - 1 - t, limits, costs) > worst:
            return np.inf
    return float(total + costs.terminal * (left + turn))


@njit(cache=True)
def improve(
    nominal: NDArray[np.float64],
    noise: NDArray[np.float64],
    scene: Scene,
    temperature: float,
    limits: Limits,
    costs: Costs,
) -> None:
    """Replaces nominal controls (H, 2) by the mean of sampled ones, weighted by exp(-cost / T).

    Information-theoretic MPPI (Williams et al., "Information Theoretic MPC for Model-Based
    Reinforcement Learning", ICRA 2017, algorithm 2), without its control cost, and with two
    rows of the sample table given to braking and steering controllers (Trevisan and Alonso-Mora,
    "Biased-MPPI", RA-L 2024): the plan cannot get stuck on a bad warm start.

    Args:
        nominal: (H, 2) controls, changed in place.
        noise: (S, H, 2) offsets to the nominal controls; row 0 is zero.
        scene: What the robot sees.
        temperature: T, in units of cost.
        limits: What the robot can do.
        costs: Weights of the rollout cost.
    """
    samples = nominal + noise
    samples[BRAKE] = 0.0
    totals = np.empty(len(samples))
    best = np.inf
    for s in range(len(samples)):
        worst = best + NEGLIGIBLE * temperature
        totals[s] = rollout(samples[s], s == STEER, worst, scene, limits, costs)
        best = min(best, totals[s])
    weights = np.exp((best - totals) / temperature)
    weights /= weights.sum()
    nominal[:] = 0.0
    for s in range(len(samples)):
        nominal += weights[s] * samples[s]


@njit(cache=True)
def walls_seen(ranges: NDArray[np.float64], farthest: float, gap: float) -> NDArray[np.float64]:
    """Walls (P, 4), each a point and the way to the next one, that lidar rays (R,) hit.

    Points of neighboring rays less than `gap` apart belong to one wall: what does not fit through
    need not know whether there is a hole.

    Args:
        ranges: (R,) ranges of the rays [m]; ray 0 ahead, counter-clockwise.
        farthest: Rays as long as this have hit nothing that matters [m].
        gap: Smallest hole that is one [m].
    """
    count = len(ranges)
    walls = np.zeros((count, 4))
    seen = 0
    for r in range(count):
        if ranges[r] >= farthest:
            continue
        angle, turn = 2.0 * math.pi * r / count, 2.0 * math.pi * ((r + 1) % count) / count
        x, y = ranges[r] * math.cos(angle), ranges[r] * math.sin(angle)
        after = ranges[(r + 1) % count]
        dx, dy = after * math.cos(turn) - x, after * math.sin(turn) - y
        walls[seen, 0], walls[seen, 1] = x, y
        if math.hypot(dx, dy) < gap:
            walls[seen, 2], walls[seen, 3] = dx, dy
        seen += 1
    return walls[:seen]
