"""Pictures: the map as a network sees it, and a scene as a person likes to look at it."""

import contextlib
import itertools
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import skimage.draw
from numpy.typing import NDArray

from crowdsim.canvas import PALETTE_RGB, ROBOT_RGB, Canvas, Image, Matrix, project, with_footer
from crowdsim.map import Map

WALL_RGB: Final = (70, 62, 58)
WALL_WIDTH: Final = 0.1
"""Width that walls are drawn with [m]."""


def render_map(map_: Map, pixels_per_metre: float = 10.0) -> tuple[Image, Matrix]:
    """Picture of the ground as the predictor sees it: the photograph, or surfaces and walls.

    A pixel has the color of the surface at its centre, so the picture agrees with
    `Map.walkable`; walls are lines at least one pixel wide.

    Args:
        map_: What to draw.
        pixels_per_metre: Resolution of a drawn map; a photograph keeps its own.

    Returns:
        (H, W, 3) uint8 RGB image, row 0 at +y, and (3, 3) `pixel_from_world`, where whole pixel
        coordinates are pixel centres.

    Raises:
        ValueError: The resolution is not positive.
    """
    if map_.picture is not None:
        return map_.picture.image, map_.picture.pixel_from_world
    if not pixels_per_metre > 0.0:
        raise ValueError(f"pixels_per_metre must be positive, got {pixels_per_metre}")
    x_min, y_min, x_max, y_max = map_.bounds
    height = round((y_max - y_min) * pixels_per_metre)
    width = round((x_max - x_min) * pixels_per_metre)
    pixel_from_world = np.array(
        [
            [pixels_per_metre, 0.0, -pixels_per_metre * x_min - 0.5],
            [0.0, -pixels_per_metre, pixels_per_metre * y_max - 0.5],
            [0.0, 0.0, 1.0],
        ]
    )
    image = np.empty((max(height, 1), max(width, 1), 3), dtype=np.uint8)
    image[:] = map_.background.color_rgb
    for surface, polygon in map_.surfaces:
        u, v = project(pixel_from_world, polygon).T
        inside = skimage.draw.polygon(v, u, image.shape[:2])  # type: ignore[no-untyped-call]
        image[inside] = surface.color_rgb
    wall_px = max(1, round(WALL_WIDTH * pixels_per_metre))
    for wall in project(pixel_from_world, map_.walls):
        start, end = np.rint(wall).astype(int).tolist()
        cv2.line(image, start, end, WALL_RGB, wall_px)
    return image, pixel_from_world


def render_frame(
    map_image: Image,
    pixel_from_world: Matrix,
    *,
    positions: NDArray[np.float64],
    radius: NDArray[np.float64],
    valid: NDArray[np.bool_],
    ids: NDArray[np.int64] | None = None,
    headings: NDArray[np.float64] | None = None,
    histories: Sequence[NDArray[np.float64]] = (),
    forecasts: Sequence[NDArray[np.float64]] = (),
    forecast_radii: Sequence[NDArray[np.float64]] = (),
    robot: tuple[float, float, float] | None = None,
    robot_radius: float = 0.3,
    robot_history: NDArray[np.float64] | None = None,
    robot_goal: tuple[float, float] | None = None,
    text: str = "",
    scale: float | None = None,
) -> Image:
    """Draw one moment of a world over its map. World metres, headings CCW from +x.

    Args:
        map_image: (H, W, 3) uint8 RGB, from `render_map` or a photograph; it is left as it is.
        pixel_from_world: (3, 3) homography into it, perspective ones included.
        positions: (N, 2) of the people.
        radius: (N,) of the people.
        valid: (N,) bool, who is drawn.
        ids: (N,) decide the colors; the row numbers if None.
        headings: (N,) where they face; no mark if None.
        histories: One (P, 2) path per person, oldest first, any length; or none at all.
        forecasts: One (F, 2) path per person, nearest first, any length; or none at all.
        forecast_radii: One (F,) per forecast, within which the person is expected; or none at all.
        robot: x, y, heading.
        robot_radius: Its radius.
        robot_history: (P, 2) path of the robot, oldest first.
        robot_goal: Where it wants to go.
        text: Written below the picture, beside the legend.
        scale: Enlargement of the map; None makes the longer side about 1,100 pixels.

    Returns:
        (H', W', 3) uint8 RGB, both sides even, with a footer of `FOOTER_PX` rows.
    """
    canvas = Canvas(map_image, pixel_from_world, scale)
    names = np.arange(len(positions)) if ids is None else ids
    colors = [PALETTE_RGB[int(name) % len(PALETTE_RGB)] for name in names]
    drawn = np.flatnonzero(valid)
    for person in drawn[drawn < len(forecast_radii)]:
        canvas.cloud(forecasts[person], forecast_radii[person], colors[person])
    for person in drawn[drawn < len(histories)]:
        canvas.fading_line(histories[person], colors[person])
    if robot_history is not None:
        canvas.fading_line(robot_history, ROBOT_RGB)
    if robot_goal is not None:
        canvas.goal(robot_goal)
    for person in drawn[drawn < len(forecasts)]:
        canvas.dotted_line(forecasts[person], colors[person])
    for person in drawn:
        heading = None if headings is None else float(headings[person])
        canvas.body(positions[person], float(radius[person]), heading, colors[person])
    if robot is not None:
        canvas.robot(robot, robot_radius)
    legend = ["person"] + ["history"] * (len(histories) > 0) + ["forecast"] * (len(forecasts) > 0)
    legend += ["robot"] * (robot is not None) + ["goal"] * (robot_goal is not None)
    return with_footer(canvas.image, text, legend)


def write_video(path: Path | str, frames: Iterable[Image], fps: float) -> None:
    """Write RGB frames as VP9 in a .webm file, which every browser plays.

    The file appears under its name only when it is complete.

    Args:
        path: Where to; must end in .webm.
        frames: (H, W, 3) uint8 RGB pictures of one size, even sides.
        fps: Frames per second.

    Raises:
        ValueError: Wrong suffix, no frame, frames of different sizes, or odd sides.
        RuntimeError: This OpenCV cannot write VP9.
    """
    path = Path(path)
    if path.suffix != ".webm":
        raise ValueError(f"a video's name must end in .webm, got {path.name}")
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.stem}.part.webm")
    try:
        _encode(temporary, iter(frames), fps)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def _encode(path: Path, frames: Iterator[Image], fps: float) -> None:
    first = next(frames, None)
    if first is None:
        raise ValueError("a video needs at least one frame, got none")
    height, width = first.shape[:2]
    if height % 2 or width % 2:
        raise ValueError(f"frames must have even sides, got {height} x {width}")
    with _quiet_stderr():
        writer = cv2.VideoWriter(
            str(path), cv2.VideoWriter.fourcc(*"VP90"), float(fps), (width, height)
        )
    if not writer.isOpened():
        raise RuntimeError("this OpenCV cannot write VP9 video (no FFmpeg in it)")
    try:
        for frame in itertools.chain([first], frames):
            if frame.shape != first.shape:
                raise ValueError(f"frames must all be {first.shape}, got {frame.shape}")
            writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))
    finally:
        writer.release()


@contextlib.contextmanager
def _quiet_stderr() -> Iterator[None]:
    """Drop what OpenCV's C code prints: it complains about the tag of every .webm and goes on."""
    saved = os.dup(2)
    try:
        with Path(os.devnull).open("w") as nowhere:
            os.dup2(nowhere.fileno(), 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)
