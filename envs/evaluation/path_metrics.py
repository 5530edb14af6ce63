"""How a robot went its ways: length, turning and progress against the shortest path on the map."""

import numpy as np
from numpy.typing import NDArray

from crowdsim.wayfinding import geodesic_field
from envs.trace import Trace

Floats = NDArray[np.float64]

STALLED_SPEED = 0.05
"""Below this speed [m/s] the robot stands."""

PROGRESS_WINDOW, PROGRESS_NEEDED = 5.0, 0.5
"""A robot that gets less than 0.5 m nearer to its goal in 5 s fails to progress."""


def ways_reached(trace: Trace) -> NDArray[np.bool_]:
    """(L,), which of the ways led to their goals: all but perhaps the last."""
    reached = np.ones(len(trace.ways), dtype=np.bool_)
    reached[-1] = trace.termination_reason == "goal"
    return reached


def path_quality(trace: Trace) -> dict[str, float]:
    """Length and turning of the robot's path against the shortest ones on the map."""
    lengths = np.array([_length(trace.robot_position[way]) for way in trace.ways])
    efficiency = trace.shortest_path_lengths / np.maximum(
        np.maximum(lengths, trace.shortest_path_lengths), 1e-9
    )
    unnecessary = sum(
        max(0.0, _turned(trace.robot_heading[way]) - shortest_path_turning(trace, way))
        for way in trace.ways
    )
    length = float(lengths.sum())
    return {
        "path_length": length,
        "spl": float(np.where(ways_reached(trace), efficiency, 0.0).mean()),
        "path_irregularity": unnecessary / length if length > 0.1 else np.nan,
        "cumulative_heading_change": _turned(trace.robot_heading),
    }


def shortest_path_turning(trace: Trace, way: slice, spacing: float = 0.5) -> float:
    """Rotation that the shortest path of a way asks for from its first heading on [rad]."""
    first = way.start
    field = geodesic_field(trace.scenario.map, trace.robot_goal[first])
    path = field.path(trace.robot_position[first], spacing)
    pieces = np.diff(path, axis=0)
    bearings = np.arctan2(pieces[:, 1], pieces[:, 0])[np.linalg.norm(pieces, axis=1) > 1e-6]
    return _turned(np.concatenate([trace.robot_heading[first : first + 1], bearings]))


def progress(trace: Trace) -> dict[str, float]:
    """Time spent standing [s], and the number of 5 s windows without progress to the goal."""
    speed = np.linalg.norm(np.diff(trace.robot_position, axis=0), axis=1) / trace.dt
    return {
        "stalled_time": float((speed < STALLED_SPEED).sum() * trace.dt),
        "failure_to_progress": sum(_windows_without_progress(trace, way) for way in trace.ways),
    }


def _windows_without_progress(trace: Trace, way: slice) -> int:
    field = geodesic_field(trace.scenario.map, trace.robot_goal[way.start])
    window = round(PROGRESS_WINDOW / trace.dt)
    remaining = field.distance(trace.robot_position[way][::window])
    gained = remaining[:-1] - remaining[1:]
    return int((gained < PROGRESS_NEEDED).sum())


def _length(path: Floats) -> float:
    """Of a path (T, 2) [m]."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def _turned(headings: Floats) -> float:
    """Sum of the turns between headings (T,) that follow each other [rad]."""
    return float(np.abs(_wrapped(np.diff(headings))).sum())


def _wrapped(angle: Floats) -> Floats:
    """Angles in (-pi, pi]."""
    return -((np.pi - angle) % (2 * np.pi) - np.pi)
