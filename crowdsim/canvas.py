"""Strokes of the pictures that people look at: bodies, paths, flags, a footer with a legend."""

import math
from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

Image = NDArray[np.uint8]
Matrix = NDArray[np.float64]
Color = tuple[int, int, int]

PALETTE_RGB: Final = (
    (38, 84, 164),
    (0, 128, 128),
    (108, 72, 160),
    (28, 118, 190),
    (56, 122, 62),
    (148, 52, 122),
)
"""Colors of people, by their id; warm ones are left to the robot."""
ROBOT_RGB: Final = (226, 96, 22)
INK_RGB: Final = (38, 40, 48)
WHITE_RGB: Final = (255, 255, 255)
PAPER: Final = 0.22
"""Share of white that the map is lightened with, so that what is drawn on it stands out."""
CLOUD: Final = 0.16
"""Share of a person's color where the person may be in future."""
LONG_SIDE_PX: Final = 1100
"""A frame is enlarged to at least this, unless told otherwise."""
FOOTER_PX: Final = 40
SUBPIXEL_BITS: Final = 4
FONT: Final = cv2.FONT_HERSHEY_SIMPLEX
FONT_SCALE: Final = 0.5


def project(target_from_source: Matrix, points: ArrayLike) -> NDArray[np.float64]:
    """Map points (..., 2) through a (3, 3) homography."""
    points = np.asarray(points, dtype=np.float64)
    moved = points @ target_from_source[:, :2].T + target_from_source[:, 2]  # (..., 3)
    return np.asarray(moved[..., :2] / moved[..., 2:])


class Canvas:
    """An enlarged, lightened copy of the map and the strokes that are drawn on it."""

    def __init__(self, map_image: Image, pixel_from_world: Matrix, scale: float | None) -> None:
        height, width = map_image.shape[:2]
        if scale is None:
            scale = max(1.0, LONG_SIDE_PX / max(height, width))
        size = (2 * round(0.5 * scale * width), 2 * round(0.5 * scale * height))
        enlarged = cv2.resize(map_image, size, interpolation=cv2.INTER_CUBIC)
        white = np.full_like(enlarged, 255)
        paper = cv2.addWeighted(enlarged, 1.0 - PAPER, white, PAPER, 0.0)
        self.image: Image = np.asarray(paper, dtype=np.uint8)
        # Whole coordinates are pixel centres: the corner of the picture is at -1/2.
        shift = 0.5 * (scale - 1.0)
        enlarge = np.array([[scale, 0.0, shift], [0.0, scale, shift], [0.0, 0.0, 1.0]])
        self.pixel_from_world = enlarge @ pixel_from_world
        self._area_factor = abs(float(np.linalg.det(self.pixel_from_world)))

    def scale_at(self, point: NDArray[np.float64]) -> float:
        """Pixels per metre around a world point: root of the homography's area factor."""
        x, y = point.tolist()
        along_x, along_y, constant = self.pixel_from_world[2].tolist()
        depth = along_x * x + along_y * y + constant
        return math.sqrt(self._area_factor / abs(depth) ** 3)

    # Strokes are short and many: plain numbers are several times faster than arrays of two.

    def under(self, pixel: NDArray[np.float64], color: Color, alpha: float) -> list[int]:
        """The color mixed with what lies at a pixel."""
        height, width = self.image.shape[:2]
        u, v = pixel.tolist()
        column, row = min(max(round(u), 0), width - 1), min(max(round(v), 0), height - 1)
        below = self.image[row, column].tolist()
        return [round(alpha * c + (1.0 - alpha) * b) for c, b in zip(color, below, strict=True)]

    def disc(
        self, pixel: NDArray[np.float64], radius_px: float, color: Sequence[int], width: int = -1
    ) -> None:
        """A filled circle, or a ring of some pixels' width."""
        center, fine = _fixed(pixel), round(radius_px * 2**SUBPIXEL_BITS)
        cv2.circle(self.image, center, fine, color, width, cv2.LINE_AA, SUBPIXEL_BITS)

    def polygon(self, pixels: NDArray[np.float64], color: Sequence[int]) -> None:
        """A filled polygon (P, 2)."""
        corners = np.array([_fixed(pixel) for pixel in pixels], dtype=np.int32)
        cv2.fillPoly(self.image, [corners], color, cv2.LINE_AA, SUBPIXEL_BITS)

    def line(self, ends: NDArray[np.float64], color: Sequence[int], width: int) -> None:
        """A straight line between two pixels (2, 2)."""
        start, end = _fixed(ends[0]), _fixed(ends[1])
        cv2.line(self.image, start, end, color, width, cv2.LINE_AA, SUBPIXEL_BITS)

    def fading_line(self, path: NDArray[np.float64], color: Color) -> None:
        """A path that fades towards its beginning, on a casing that dark photographs need."""
        pixels = project(self.pixel_from_world, path)
        middles = 0.5 * (pixels[:-1] + pixels[1:])
        for shade, alpha, casing in ((WHITE_RGB, 0.5, 2), (color, 0.75, 0)):
            for index, middle in enumerate(middles):
                age = (index + 1) / len(pixels)
                mixed = self.under(middle, shade, alpha * age)
                self.line(pixels[index : index + 2], mixed, 1 + round(2.0 * age) + casing)

    def dotted_line(self, path: NDArray[np.float64], color: Color) -> None:
        """Dots that fade towards the end."""
        pixels = project(self.pixel_from_world, path)
        for index, pixel in enumerate(pixels):
            ahead = index / max(len(pixels) - 1, 1)
            size = 0.11 * self.scale_at(path[index]) * (1.0 - 0.35 * ahead)
            self.disc(pixel, max(size, 2.2) + 1.0, self.under(pixel, WHITE_RGB, 0.75))
            self.disc(pixel, max(size, 2.2), self.under(pixel, color, 0.95 - 0.55 * ahead))

    def cloud(self, path: NDArray[np.float64], radius: NDArray[np.float64], color: Color) -> None:
        """Where somebody is going to be: translucent discs of growing radius (F,) along a path."""
        overlay = self.image.copy()
        pixels = project(self.pixel_from_world, path)
        for point, pixel, reach in zip(path, pixels, radius.tolist(), strict=True):
            size = round(reach * self.scale_at(point) * 2**SUBPIXEL_BITS)
            cv2.circle(overlay, _fixed(pixel), size, color, -1, cv2.LINE_AA, SUBPIXEL_BITS)
        mixed = cv2.addWeighted(overlay, CLOUD, self.image, 1.0 - CLOUD, 0.0)
        self.image = np.asarray(mixed, dtype=np.uint8)

    def body(
        self,
        position: NDArray[np.float64],
        radius: float,
        heading: float | None,
        color: Color,
    ) -> None:
        """A disc with a nose."""
        pixel = project(self.pixel_from_world, position)
        radius_px = radius * self.scale_at(position)
        if heading is not None:
            self.nose(position, radius, heading, color)
        self.disc(pixel, radius_px, color)
        self.disc(pixel, radius_px, WHITE_RGB, width=max(1, round(0.14 * radius_px)))

    def nose(
        self,
        position: NDArray[np.float64],
        radius: float,
        heading: float,
        color: Color,
    ) -> None:
        """A triangle in front of a disc, with a white rim; it follows the perspective."""
        for reach, rim in ((1.75, WHITE_RGB), (1.55, color)):
            angles = heading + np.array([0.0, 0.62, -0.62])
            lengths = radius * np.array([reach, 1.0, 1.0])
            outline = np.column_stack([np.cos(angles), np.sin(angles)]) * lengths[:, None]
            self.polygon(project(self.pixel_from_world, position + outline), rim)

    def robot(self, pose: tuple[float, float, float], radius: float) -> None:
        """A dark disc with a colored ring and an arrow."""
        position = np.array(pose[:2])
        pixel, radius_px = (
            project(self.pixel_from_world, position),
            radius * self.scale_at(position),
        )
        self.disc(pixel, radius_px + 2.0, WHITE_RGB)
        self.disc(pixel, radius_px, ROBOT_RGB)
        self.disc(pixel, 0.78 * radius_px, INK_RGB)
        angles = pose[2] + np.array([0.0, 2.5, math.pi, -2.5])
        lengths = radius * np.array([0.66, 0.6, 0.22, 0.6])
        arrow = np.column_stack([np.cos(angles), np.sin(angles)]) * lengths[:, None]
        self.polygon(project(self.pixel_from_world, position + arrow), WHITE_RGB)

    def goal(self, goal: tuple[float, float]) -> None:
        """A flag in a ring; the flag stands upright in the picture."""
        position = np.array(goal)
        foot, size = project(self.pixel_from_world, position), self.scale_at(position)
        self.disc(foot, 0.45 * size, WHITE_RGB, width=5)
        self.disc(foot, 0.45 * size, ROBOT_RGB, width=2)
        _flag(self.image, foot, size)


def _flag(image: Image, foot: NDArray[np.float64], size: float) -> None:
    top = foot - [0.0, 1.15 * size]
    pennant = top + size * np.array([(0.0, 0.0), (0.62, 0.22), (0.0, 0.46)])
    corners = np.array([_fixed(pixel) for pixel in pennant], dtype=np.int32)
    for color, width in ((WHITE_RGB, 6), (INK_RGB, 3)):
        cv2.line(image, _fixed(foot), _fixed(top), color, width, cv2.LINE_AA, SUBPIXEL_BITS)
    cv2.fillPoly(image, [corners], ROBOT_RGB, cv2.LINE_AA, SUBPIXEL_BITS)


def _fixed(pixel: NDArray[np.float64]) -> list[int]:
    """Pixel coordinates with `SUBPIXEL_BITS` binary places, as OpenCV takes them."""
    # Far outside, a fixed-point coordinate would overflow OpenCV's 32 bits.
    return [round(min(max(value, -1e5), 1e5) * 2**SUBPIXEL_BITS) for value in pixel.tolist()]


def with_footer(image: Image, text: str, legend: Sequence[str]) -> Image:
    """The picture above a white strip with the text on the left, the legend on the right."""
    width = image.shape[1]
    footer = np.full((FOOTER_PX, width, 3), 255, dtype=np.uint8)
    footer[0] = 215
    text_px = _write(footer, 14, text)
    left = width - 14 - sum(_entry_px(entry) for entry in legend)
    if left > text_px:
        for entry in legend:
            _symbol(footer, left + 12, entry)
            _write(footer, left + 30, entry)
            left += _entry_px(entry)
    return np.concatenate([image, footer])


def _write(footer: Image, left: int, text: str) -> int:
    """Write text into the footer; returns where it ends."""
    cv2.putText(footer, text, (left, 26), FONT, FONT_SCALE, INK_RGB, 1, cv2.LINE_AA)
    return left + _text_px(text)


def _text_px(text: str) -> int:
    return int(cv2.getTextSize(text, FONT, FONT_SCALE, 1)[0][0])


def _entry_px(entry: str) -> int:
    return _text_px(entry) + 50


def _symbol(footer: Image, left: int, entry: str) -> None:
    """A small picture of a legend entry around (left, middle of the footer)."""
    middle, color = FOOTER_PX // 2, PALETTE_RGB[0]
    if entry == "history":
        cv2.line(footer, (left - 10, middle), (left + 10, middle), color, 2, cv2.LINE_AA)
    elif entry == "forecast":
        for x in (left - 8, left, left + 8):
            cv2.circle(footer, (x, middle), 3, color, -1, cv2.LINE_AA)
    elif entry == "goal":
        _flag(footer, np.array([left - 3.0, middle + 11.0]), 19.0)
    else:
        is_robot = entry == "robot"
        cv2.circle(footer, (left, middle), 8, ROBOT_RGB if is_robot else color, -1, cv2.LINE_AA)
        if is_robot:
            cv2.circle(footer, (left, middle), 6, INK_RGB, -1, cv2.LINE_AA)
