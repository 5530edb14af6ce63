"""What one episode was like: the navigation metrics of social robotics, from its trace.

Every function takes a `Trace` (rows at `trace.dt`, row 0 is the reset) and answers for that episode
alone; SI units, distances surface to surface unless said otherwise. NaN means that the quantity
does not exist in this episode (no pedestrian, no success, no twin run), never that it is zero.
`METRICS` names, defines and sources each key of `navigation_metrics`.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from envs.evaluation.forecast_scores import scored_forecasts
from envs.evaluation.path_metrics import path_quality, progress, ways_reached
from envs.trace import Trace, TwinTrace

Value: TypeAlias = bool | int | float | str | None
Floats: TypeAlias = NDArray[np.float64]

COLLISION_COURSE_LIMIT = 10.0
"""A time to collision is looked for this far ahead [s]; none found counts as this much."""

ZONES = {"intimate": 0.45, "personal": 1.2, "social": 3.6}
"""Outer radius [m] of the zones around a person (Hall 1966)."""

INTRUSION_HORIZONS = (1.2, 4.8)
"""How far ahead [s] people's true paths are looked at for `intrusion_ratio@H`."""

DELAY_WINDOW, DELAY_AHEAD, DELAY_TOLERANCE = 10.0, 2.0, 0.05
"""People may be up to 10 s late or 2 s early, judged by twin positions equally near to 0.05 m."""


def navigation_metrics(trace: Trace, twin: TwinTrace | None = None) -> dict[str, Value]:
    """All metrics of one episode, by the keys of `METRICS`.

    Args:
        trace: What happened.
        twin: The same people without the robot; None where there is no such run (a replay, whose
            people cannot react), which leaves the two pedestrian effects missing. They are in
            missions too: after minutes the two crowds have nothing to do with each other.
    """
    metrics: dict[str, Value] = {}
    metrics |= outcome(trace)
    metrics |= mission(trace)
    metrics |= path_quality(trace)
    metrics |= motion(trace)
    metrics |= proximity(trace)
    for horizon in INTRUSION_HORIZONS:
        metrics |= intrusion(trace, horizon)
    metrics |= progress(trace)
    metrics["social_work"] = social_work(trace)
    beside = None if trace.mission else twin
    metrics["pedestrian_delay"] = np.nan if beside is None else pedestrian_delay(trace, beside)
    metrics["pedestrian_displacement"] = (
        np.nan if beside is None else pedestrian_displacement(trace, beside)
    )
    return metrics | forecast_errors(trace)


def outcome(trace: Trace) -> dict[str, Value]:
    """How the episode ended, and how long each way took; a failure is charged the time limit."""
    seconds = np.array([(way.stop - 1 - way.start) * trace.dt for way in trace.ways])
    reached = ways_reached(trace)
    return {
        "success": trace.termination_reason == "goal",
        "collision_pedestrian": trace.termination_reason == "collision_pedestrian",
        "collision_wall": trace.termination_reason == "collision_wall",
        "timeout": trace.termination_reason == "timeout",
        "collision_role": trace.collision_role,
        "time_to_goal": _mean_of_finite(seconds[reached]),
        "time_to_goal_penalized": float(np.where(reached, seconds, trace.time_limit).mean()),
    }


def mission(trace: Trace) -> dict[str, Value]:
    """How many goals a mission reached, and for how long it went well; NaN for a single way."""
    return {
        "goals_reached": float(ways_reached(trace).sum()) if trace.mission else np.nan,
        "time_without_contact": trace.duration if trace.mission else np.nan,
    }


def motion(trace: Trace) -> dict[str, Value]:
    """Mean and maximum of the robot's speed, acceleration and jerk (norms, finite differences)."""
    acceleration = np.diff(trace.robot_velocity, axis=0) / trace.dt
    jerk = np.diff(acceleration, axis=0) / trace.dt
    metrics: dict[str, Value] = {}
    for name, vectors in (
        ("speed", trace.robot_velocity),
        ("acceleration", acceleration),
        ("jerk", jerk),
    ):
        norms = np.linalg.norm(vectors, axis=1)
        metrics[f"{name}_mean"] = float(norms.mean()) if len(norms) else np.nan
        metrics[f"{name}_max"] = float(norms.max()) if len(norms) else np.nan
    return metrics


def proximity(trace: Trace) -> dict[str, Value]:
    """Distances to people and walls, and shares of time in each zone around people."""
    people = trace.clearance_pedestrian
    walls = trace.clearance_wall
    shares: dict[str, Value] = {
        f"{zone}_zone_share": float((people < radius).mean()) for zone, radius in ZONES.items()
    }
    return {
        "clearance_min": _finite(people.min()),
        "clearance_mean": _mean_of_finite(people),
        "wall_clearance_min": _finite(walls.min()),
        "wall_clearance_mean": _mean_of_finite(walls),
        "time_to_collision_min": float(time_to_collision(trace).min()),
        "space_compliance_0.5": float((people > 0.5).mean()),
        **shares,
    }


def time_to_collision(trace: Trace) -> Floats:
    """(T,) time until the first contact if everybody kept their velocity [s].

    Both radii count: contact is where the centres are the sum of radii apart. 0 in contact,
    `COLLISION_COURSE_LIMIT` where nobody is on a collision course within that time.
    """
    offset = trace.position - trace.robot_position[:, None]
    approach = trace.velocity - trace.robot_velocity[:, None]
    reach = trace.radius + trace.robot_radius
    a = (approach**2).sum(-1)
    b = (offset * approach).sum(-1)
    c = (offset**2).sum(-1) - reach**2
    discriminant = b**2 - a * c
    meets = (discriminant >= 0) & (b < 0) & (a > 1e-12)
    with np.errstate(divide="ignore", invalid="ignore"):
        seconds = (-b - np.sqrt(np.maximum(discriminant, 0))) / a
    seconds = np.where(meets, seconds, COLLISION_COURSE_LIMIT)
    seconds = np.where(c <= 0, 0.0, seconds)
    seconds = np.where(trace.valid, seconds, COLLISION_COURSE_LIMIT)
    first: Floats = seconds.min(axis=1, initial=COLLISION_COURSE_LIMIT)
    return first


def intrusion(trace: Trace, horizon: float) -> dict[str, Value]:
    """Whether the robot stands in the way that people are about to walk (Liu et al. 2023).

    A step intrudes where the robot, now, touches the strip that any pedestrian truly sweeps over
    the next `horizon` seconds. Near the end of the episode only the recorded part is known.

    Args:
        trace: What happened.
        horizon: How far ahead the true paths are followed [s].

    Returns:
        `intrusion_ratio@H`, the share of intruding steps, and `social_distance@H`, the mean
        clearance to the nearest pedestrian during them [m] (NaN without any).
    """
    inside = distance_to_true_paths(trace, horizon) < trace.robot_radius
    return {
        f"intrusion_ratio@{horizon:g}": float(inside.mean()),
        f"social_distance@{horizon:g}": _mean_of_finite(trace.clearance_pedestrian[inside]),
    }


def distance_to_true_paths(trace: Trace, horizon: float) -> Floats:
    """(T,) from the robot's centre to the nearest strip a pedestrian is about to sweep [m].

    Negative inside a strip's core; `inf` where nobody is there.
    """
    position, same = trace.position, trace.valid.copy()
    steps = len(position)
    nearest = np.linalg.norm(position - trace.robot_position[:, None], axis=-1)
    nearest = np.where(same, nearest, np.inf)
    for k in range(1, min(round(horizon / trace.dt), steps - 1) + 1):
        now, later, before = slice(0, steps - k), slice(k, steps), slice(k - 1, steps - 1)
        same = same[now] & trace.valid[later] & (trace.ids[now] == trace.ids[later])
        distance = _distance_to_segments(
            trace.robot_position[now, None], position[before], position[later]
        )
        nearest[now] = np.where(same, np.minimum(nearest[now], distance), nearest[now])
    outermost: Floats = (nearest - trace.radius).min(axis=1, initial=np.inf)
    return outermost


def social_work(trace: Trace) -> float:
    """Social forces on the robot and by the robot on people, over the whole episode [m/s]."""
    return float(trace.social_work.sum())


def pedestrian_displacement(trace: Trace, twin: TwinTrace) -> float:
    """Mean distance of people from where they would be without the robot, over all steps [m]."""
    steps = min(len(trace.position), len(twin.position))
    both = trace.valid[:steps] & twin.valid[:steps] & (trace.ids[:steps] == twin.ids[:steps])
    moved = np.linalg.norm(trace.position[:steps] - twin.position[:steps], axis=-1)
    return _mean_of_finite(moved[both])


def pedestrian_delay(trace: Trace, twin: TwinTrace) -> float:
    """Mean time by which people are late on their own undisturbed paths at the end [s].

    Each person's last position is looked up on the path walked in the twin run; the difference of
    the two times is the delay, negative for somebody who gained. The twin should run `DELAY_AHEAD`
    longer than the episode.
    """
    end = len(trace.position) - 1
    back, ahead = round(DELAY_WINDOW / trace.dt), round(DELAY_AHEAD / trace.dt)
    rows = np.arange(max(0, end - back), min(len(twin.position), end + ahead + 1))
    distance = np.linalg.norm(twin.position[rows] - trace.position[end], axis=-1)
    known = twin.valid[rows] & (twin.ids[rows] == trace.ids[end]) & trace.valid[end]
    distance = np.where(known, distance, np.inf)
    # People who stand are equally near to many rows; of those the one nearest in time counts.
    near = distance <= distance.min(axis=0) + DELAY_TOLERANCE
    late = end - rows
    candidates = np.where(near & known, np.abs(late)[:, None], back + 1)
    chosen = late[candidates.argmin(axis=0)] * trace.dt
    return _mean_of_finite(chosen[known.any(axis=0)])


def forecast_errors(trace: Trace) -> dict[str, Value]:
    """Error of the forecasts the robot saw against what people then did, in the closed loop.

    Only forecasts whose whole horizon lies within the episode count, for people who stayed.

    Returns:
        `forecast_ade`, `forecast_fde` [m], `forecast_count` of (step, pedestrian) pairs behind
        them, and `forecast_ms`, the mean wall time per step [ms].
    """
    errors = scored_forecasts(trace).error
    count = len(errors)
    return {
        "forecast_ade": float(errors.mean()) if count else np.nan,
        "forecast_fde": float(errors[:, -1].mean()) if count else np.nan,
        "forecast_count": count,
        "forecast_ms": _mean_of_finite(trace.forecast_seconds) * 1e3,
    }


def _distance_to_segments(point: Floats, start: Floats, end: Floats) -> Floats:
    """Distance of points (…, 2) to segments from start to end (…, 2)."""
    along = end - start
    squared = np.maximum((along**2).sum(-1), 1e-12)
    share = np.clip(((point - start) * along).sum(-1) / squared, 0.0, 1.0)
    distance: Floats = np.linalg.norm(point - start - share[..., None] * along, axis=-1)
    return distance


def _finite(value: float) -> float:
    """The value, or NaN for an infinite one (nobody there)."""
    return float(value) if np.isfinite(value) else np.nan


def _mean_of_finite(values: Floats) -> float:
    """Mean of the finite values, NaN without any."""
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else np.nan
