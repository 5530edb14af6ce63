"""Pictures and videos of single episodes, drawn by the simulator's renderer."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from crowdsim import render
from crowdsim.recordings.store import write_atomic
from crowdsim.render import render_frame, render_map
from envs.evaluation.forecast_scores import forecast_columns
from envs.report.records import OUTCOMES
from envs.trace import Trace

Image = NDArray[np.uint8]
Floats = NDArray[np.float64]

HISTORY_SECONDS = 2.8
END_SECONDS = 1.0
"""How long a video rests on its last frame."""
VIDEO_SIDE_PX = 800
"""Longer side of a video; encoding takes most of the time and grows with the area."""


def write_video(trace: Trace, path: Path, *, title: str = "") -> None:
    """Writes the episode as a .webm video in real time.

    Args:
        trace: What happened.
        path: Where to; must end in .webm.
        title: Said below the picture.
    """
    render.write_video(path, frames(trace, title), fps=1.0 / trace.dt)


def write_picture(trace: Trace, path: Path, *, row: int | None = None, title: str = "") -> None:
    """Writes one moment of the episode as .png.

    Args:
        trace: What happened.
        path: Where to.
        row: Which row of the trace; None takes the busiest (`busiest_row`).
        title: Said below the picture.
    """
    chosen = busiest_row(trace) if row is None else row
    image = draw(trace, chosen, render_map(trace.scenario.map), title)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes())


def frames(trace: Trace, title: str = "") -> Iterator[Image]:
    """RGB frames of the episode, one per row, the last one held for a second."""
    picture = render_map(trace.scenario.map)
    scale = VIDEO_SIDE_PX / max(picture[0].shape[:2])
    last = len(trace.position) - 1
    for row in range(last):
        yield draw(trace, row, picture, title, scale)
    yield from [draw(trace, last, picture, title, scale)] * (1 + round(END_SECONDS / trace.dt))


def draw(
    trace: Trace,
    row: int,
    picture: tuple[Image, Floats],
    title: str = "",
    scale: float | None = None,
) -> Image:
    """One row of the trace as an RGB image over its map.

    Args:
        trace: What happened.
        row: Which moment.
        picture: What `crowdsim.render.render_map` gives for the map.
        title: Said below the picture.
        scale: Enlargement of the map, as `crowdsim.render.render_frame` takes it.
    """
    people = range(trace.position.shape[1])
    pose = (*trace.robot_position[row].tolist(), float(trace.robot_heading[row]))
    return render_frame(
        *picture,
        positions=trace.position[row],
        radius=trace.radius,
        valid=trace.valid[row],
        ids=trace.ids[row],
        headings=np.arctan2(trace.velocity[row, :, 1], trace.velocity[row, :, 0]),
        histories=[history(trace, row, person) for person in people],
        forecasts=forecasts(trace, row),
        robot=pose,
        robot_radius=trace.robot_radius,
        robot_history=trace.robot_position[: row + 1],
        robot_goal=(float(trace.robot_goal[row, 0]), float(trace.robot_goal[row, 1])),
        text=_text(trace, row, title),
        scale=scale,
    )


def history(trace: Trace, row: int, person: int) -> Floats:
    """(P, 2) recent path of one column, oldest first, as long as it was the same person."""
    first = max(0, row - round(HISTORY_SECONDS / trace.dt))
    same = trace.valid[first : row + 1, person] & (
        trace.ids[first : row + 1, person] == trace.ids[row, person]
    )
    others = np.flatnonzero(~same)
    begin = first + int(others[-1]) + 1 if others.size else first
    return trace.position[begin : row + 1, person]


def forecasts(trace: Trace, row: int) -> list[Floats]:
    """Per pedestrian column the (F, 2) forecast made at `row`, empty where there is none."""
    drawn: list[Floats] = [np.empty((0, 2)) for _ in range(trace.position.shape[1])]
    if trace.forecast is not None:
        for slot, column in enumerate(forecast_columns(trace)[row].tolist()):
            if column >= 0:
                drawn[column] = trace.forecast[row, slot]
    return drawn


def busiest_row(trace: Trace) -> int:
    """The row in which most people are near the robot, among those with a whole history."""
    first = min(round(HISTORY_SECONDS / trace.dt), len(trace.position) - 1)
    distance = np.linalg.norm(trace.position - trace.robot_position[:, None], axis=-1)
    near = np.where(trace.valid, np.exp(-distance / 2.0), 0.0).sum(axis=1)
    return first + int(near[first:].argmax())


def _text(trace: Trace, row: int, title: str) -> str:
    seconds = f"{row * trace.dt:4.1f} s"
    ended = f"  {OUTCOMES[trace.termination_reason]}" if row == len(trace.position) - 1 else ""
    return f"{title}  {seconds}{ended}" if title else f"{seconds}{ended}"
