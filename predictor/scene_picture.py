"""Forecasts drawn over the ground of recorded scenes, beside what people then did."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from crowdsim.recordings import Picture, Recording
from predictor.error_plots import png, styled
from predictor.forecaster import Forecaster, ModalForecaster
from predictor.metrics import moves
from predictor.modal_forecast import ModalForecast
from predictor.scenes import Scene, scenes

PEOPLE: Final = ("#1d4f91", "#0f766e", "#7c3aed", "#be185d", "#1c7ab8", "#3f7d20", "#8c3a0e")
NEIGHBOR: Final = "#5b6472"
TRUTH: Final = "#16181d"
STRIDE: Final = 10
"""Frames between the windows of a recording that are looked through."""
MOST_MOVING: Final = 7
"""More paths than these cannot be told apart."""
MARGIN: Final = 1.5
"""Of ground around what is drawn [m]."""
PAPER: Final = 0.35
"""Share of white that the ground is lightened with."""
COLUMNS: Final = 3
"""Of panels."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DrawnScene:
    """A scene and its forecast, world frame.

    Attributes:
        scene: With A agents.
        path: (F, A, 2) forecast of them [m].
        modes: Their several futures, if the forecaster has them.
    """

    scene: Scene
    path: NDArray[np.float64]
    modes: ModalForecast | None


def liveliest(
    forecaster: Forecaster, recordings: Sequence[Recording], count: int
) -> list[DrawnScene]:
    """Forecast the scene with most moving agents, up to `MOST_MOVING`, of some recordings.

    Args:
        forecaster: Of whom.
        recordings: From where; those without a picture are left out.
        count: How many scenes at most, one of each recording, of different places if there are.
            Those in which more agents move come last.
    """
    clear: list[Scene] = []
    crowded: list[Scene] = []
    for recording in _of_different_places(recordings):
        if len(clear) == count:
            break
        scene = max(_windows(forecaster, recording), key=_liveliness, default=None)
        if scene is not None:
            (clear if _liveliness(scene) >= 0 else crowded).append(scene)
    return [_forecast(forecaster, scene) for scene in [*clear, *crowded][:count]]


def scene_picture(title: str, drawn: Sequence[DrawnScene]) -> bytes:
    """Draw scenes side by side, each cut out around its agents.

    Returns:
        PNG.
    """
    rows = -(-len(drawn) // COLUMNS)
    with styled():
        figure = Figure(figsize=(3.7 * COLUMNS, 3.7 * rows + 0.8), layout="constrained")
        panels = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
        for axes in panels:
            axes.set_axis_off()
        for axes, one in zip(islice(panels, len(drawn)), drawn, strict=True):
            _draw(axes, one)
        has_modes = any(one.modes is not None for one in drawn)
        figure.legend(handles=_legend(has_modes), loc="outside lower center", ncols=6)
        figure.suptitle(title, x=0.01, ha="left", fontsize=11)
        return png(figure)


def _of_different_places(recordings: Sequence[Recording]) -> list[Recording]:
    """Those with a picture, and first one of each place: names differ by more than a number."""
    pictured = [recording for recording in recordings if recording.picture is not None]
    places: dict[str, Recording] = {}
    for recording in pictured:
        places.setdefault(recording.name.rstrip("0123456789"), recording)
    firsts = list(places.values())
    return firsts + [recording for recording in pictured if recording not in firsts]


def _windows(forecaster: Forecaster, recording: Recording) -> Iterator[Scene]:
    return scenes(
        recording,
        history_steps=forecaster.history_steps,
        forecast_steps=forecaster.forecast_steps,
        frame_dt=forecaster.frame_dt,
        stride=STRIDE,
    )


def _liveliness(scene: Scene) -> int:
    """Moving agents; of too many, the fewer the better."""
    count = int(moves(scene.history[:, scene.agents], scene.future).sum())
    return count if count <= MOST_MOVING else -count


def _forecast(forecaster: Forecaster, scene: Scene) -> DrawnScene:
    select = np.zeros(scene.history.shape[1], dtype=np.bool_)
    select[scene.agents] = True
    recording = scene.recording
    seen = (scene.history, scene.valid, recording.map_image, recording.pixel_from_world, select)
    if isinstance(forecaster, ModalForecaster) and forecaster.modes > 0:
        modes = forecaster.forecast_modes(*seen).of_people(scene.agents)
        return DrawnScene(scene=scene, path=modes.path, modes=modes)
    path = forecaster.forecast(*seen)[:, scene.agents]
    return DrawnScene(scene=scene, path=path, modes=None)


def _draw(axes: Axes, drawn: DrawnScene) -> None:
    scene, picture = drawn.scene, drawn.scene.recording.picture
    if picture is None:
        raise ValueError(f"{scene.recording.name}: expected a picture to draw on, found none")
    lightened = picture.image + PAPER * (255.0 - picture.image)
    axes.imshow(lightened.astype(np.uint8), interpolation="bilinear")
    for person in range(scene.history.shape[1]):
        seen = scene.history[scene.valid[:, person], person]
        axes.plot(*_pixels(picture, seen).T, color=NEIGHBOR, linewidth=1.2, alpha=0.7)
    moving = moves(scene.history[:, scene.agents], scene.future)
    for agent, person in enumerate(scene.agents.tolist()):
        color = PEOPLE[moving[:agent].sum() % len(PEOPLE)] if moving[agent] else NEIGHBOR
        if drawn.modes is not None:
            _draw_modes(axes, picture, drawn.modes, agent, color)
        _draw_agent(axes, picture, scene, agent, person, drawn.path[:, agent], color)
    shown = np.concatenate([scene.history[:, scene.agents], scene.future])[:, moving]
    _cut_out(axes, picture, shown)
    axes.set_title(scene.recording.name, fontsize=9, loc="left")


def _draw_agent(
    axes: Axes,
    picture: Picture,
    scene: Scene,
    agent: int,
    person: int,
    path: NDArray[np.float64],
    color: str,
) -> None:
    history = _pixels(picture, scene.history[:, person])
    truth = _pixels(picture, np.concatenate([scene.history[-1:, person], scene.future[:, agent]]))
    axes.plot(*history.T, color=color, linewidth=2.4, solid_capstyle="round")
    axes.plot(*truth.T, color="white", linewidth=3.2, alpha=0.8)
    axes.plot(*truth.T, color=TRUTH, linewidth=1.3)
    axes.plot(*_pixels(picture, path).T, "o", color=color, markersize=3.6, **RIM)
    axes.plot(*history[-1], "o", color=color, markersize=8.0, **RIM)


def _draw_modes(axes: Axes, picture: Picture, modes: ModalForecast, agent: int, color: str) -> None:
    """Thin paths, the fainter the less probable."""
    for path, probability in zip(
        modes.position[:, :, agent], modes.probability[:, agent].tolist(), strict=True
    ):
        alpha = 0.35 + 0.6 * probability
        axes.plot(*_pixels(picture, path).T, color=color, linewidth=1.2, alpha=alpha)


RIM: Final[dict[str, Any]] = {"markeredgecolor": "white", "markeredgewidth": 0.7}


def _pixels(picture: Picture, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(P, 2) pixels of (P, 2) world points."""
    matrix = picture.pixel_from_world
    seen = points @ matrix[:, :2].T + matrix[:, 2]
    return np.asarray(seen[:, :2] / seen[:, 2:])


def _cut_out(axes: Axes, picture: Picture, points: NDArray[np.float64]) -> None:
    """Show the square of the picture around (T, A, 2) points, with a margin."""
    flat = points.reshape(-1, 2)
    corners = [flat + MARGIN * np.array(side) for side in ((1, 1), (1, -1), (-1, 1), (-1, -1))]
    pixels = _pixels(picture, np.concatenate(corners))
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    middle, half = 0.5 * (low + high), 0.5 * float((high - low).max())
    axes.set_xlim(middle[0] - half, middle[0] + half)
    axes.set_ylim(middle[1] + half, middle[1] - half)


def _legend(has_modes: bool) -> list[Line2D]:
    color = PEOPLE[0]
    entries = [
        Line2D([], [], color=color, linewidth=2.4, label="seen"),
        Line2D([], [], color=TRUTH, linewidth=1.3, label="then walked"),
        Line2D([], [], color=color, marker="o", linestyle="", markersize=4, label="forecast"),
        Line2D([], [], color=NEIGHBOR, linewidth=1.2, label="others, and who stands"),
    ]
    if has_modes:
        entries.append(Line2D([], [], color=color, linewidth=1.1, alpha=0.6, label="modes"))
    return entries
