"""Recorded episodes as the player in the page reads them: packed int16, and the map as an image."""

import base64
import zlib
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from crowdsim.map import Map
from crowdsim.render import render_map
from envs.evaluation.forecast_scores import forecast_columns
from envs.evaluation.replays import RecordedEpisode
from envs.trace import Trace

Bounds = tuple[float, float, float, float]
Image = NDArray[np.uint8]

OUTCOMES = {
    "goal": "goal reached",
    "collision_pedestrian": "contact with a pedestrian",
    "collision_wall": "contact with a wall",
    "timeout": "time is up",
}
IMAGE_WIDTH_PX, IMAGE_HEIGHT_PX = 900, 720
MARGIN = 6.0
"""Ground shown around the robot's path [m]."""
PAPER = 0.3
"""Share of white that a photograph is lightened with, so that what is drawn on it stands out."""
OUTSIDE_RGB = (203, 208, 214)
"""What lies beyond a photograph."""


def player_records(recorded: Sequence[RecordedEpisode], reference: str) -> dict[str, Any]:
    """Everything the player shows, as JSON.

    Args:
        recorded: Episodes; those of one scenario and seed can be shown side by side.
        reference: Arm that is shown beside the chosen one at first.

    Returns:
        `episodes` (packed traces), `views` (bounds and image) and `groups` (title, view, indices
        of its episodes, position of the reference among them or -1).
    """
    groups: dict[tuple[str, int], list[int]] = {}
    for index, episode in enumerate(recorded):
        groups.setdefault((episode.scenario, episode.seed), []).append(index)
    views: list[dict[str, Any]] = []
    listed: list[dict[str, Any]] = []
    for (scenario, seed), members in groups.items():
        arms = [recorded[index].arm for index in members]
        beside = arms.index(reference) if reference in arms and len(arms) > 1 else -1
        listed.append(
            {
                "title": f"{scenario}, seed {seed}",
                "view": len(views),
                "episodes": members,
                "compare": beside,
            }
        )
        views.append(view_of([recorded[index].trace for index in members]))
    episodes = [pack_episode(episode) for episode in recorded]
    return {"episodes": episodes, "views": views, "groups": listed}


def pack_episode(episode: RecordedEpisode) -> dict[str, Any]:
    """One episode: positions in cm, headings in mrad, ids in order of appearance (-1: absent)."""
    trace = episode.trace
    people = np.where(trace.valid[..., None], trace.position, 0.0)
    robot = np.column_stack([100 * trace.robot_position, 1000 * wrapped(trace.robot_heading)])
    packed: dict[str, Any] = {
        "arm": episode.arm,
        "outcome": trace.termination_reason,
        "outcome_text": OUTCOMES[trace.termination_reason],
        "steps": len(trace.position),
        "count": trace.position.shape[1],
        "dt": trace.dt,
        "goal": pack(100 * trace.robot_goal),
        "robot_radius": trace.robot_radius,
        "radius": np.round(trace.radius, 3).tolist(),
        "people": pack(100 * people),
        "ids": pack(np.where(trace.valid, np.unique(trace.ids, return_inverse=True)[1], -1)),
        "seen": pack(trace.visible),
        "robot": pack(robot),
        "horizon": 4.8,
    }
    if trace.forecast is not None:
        _, slots, frames, _ = trace.forecast.shape
        packed |= {
            "slots": slots,
            "frames": frames,
            "horizon": frames * trace.frame_dt,
            "forecast": pack(100 * trace.forecast),
            "columns": pack(forecast_columns(trace)),
        }
    return packed


def pack(values: ArrayLike) -> dict[str, Any]:
    """Rows as differences of int16, deflated, in base64: small, and a line of script to undo."""
    rounded = np.clip(np.rint(np.asarray(values, dtype=np.float64)), -32768, 32767).astype("<i2")
    rows = rounded.reshape(len(rounded), -1)
    differences = np.diff(rows, axis=0, prepend=np.zeros_like(rows[:1]))
    data = base64.b64encode(zlib.compress(differences.tobytes(), 9)).decode("ascii")
    return {"rows": len(rows), "data": data}


def wrapped(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles in [-pi, pi)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def view_of(traces: Sequence[Trace]) -> dict[str, Any]:
    """The part of the world that the traces happen in, with its picture from straight above."""
    map_ = traces[0].scenario.map
    bounds = view_bounds(map_, traces)
    image = view_image(map_, bounds)
    return {"bounds": [round(edge, 3) for edge in bounds], "image": data_uri(image)}


def view_bounds(map_: Map, traces: Sequence[Trace]) -> Bounds:
    """Box around the robots' paths and goals, not larger than the map [m]."""
    points = [trace.robot_goal for trace in traces]
    points += [trace.robot_position for trace in traces]
    together = np.concatenate(points)
    low = np.maximum(together.min(axis=0) - MARGIN, map_.bounds[:2])
    high = np.minimum(together.max(axis=0) + MARGIN, map_.bounds[2:])
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def view_image(map_: Map, bounds: Bounds) -> Image:
    """The map, drawn or photographed, seen from straight above within `bounds` (RGB)."""
    x_min, y_min, x_max, y_max = bounds
    scale = min(IMAGE_WIDTH_PX / (x_max - x_min), IMAGE_HEIGHT_PX / (y_max - y_min))
    source, pixel_from_world = render_map(map_, pixels_per_metre=scale)
    world_from_view = np.array(
        [
            [1 / scale, 0.0, x_min + 0.5 / scale],
            [0.0, -1 / scale, y_max - 0.5 / scale],
            [0.0, 0.0, 1.0],
        ]
    )
    size = (round((x_max - x_min) * scale), round((y_max - y_min) * scale))
    if map_.picture is not None:
        source = (255 * PAPER + (1 - PAPER) * source).astype(np.uint8)
    image = cv2.warpPerspective(
        source,
        pixel_from_world @ world_from_view,
        size,
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderValue=OUTSIDE_RGB,
    )
    return np.asarray(image, dtype=np.uint8)


def data_uri(image: Image) -> str:
    """An RGB image inside a URI: PNG or JPEG, whichever is smaller."""
    bgr = np.ascontiguousarray(image[..., ::-1])
    png = cv2.imencode(".png", bgr, [cv2.IMWRITE_PNG_COMPRESSION, 9])[1].tobytes()
    jpeg = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, 82])[1].tobytes()
    kind, data = ("png", png) if len(png) <= len(jpeg) else ("jpeg", jpeg)
    return f"data:image/{kind};base64,{base64.b64encode(data).decode('ascii')}"
