"""Forecasts of every agent of every window of some recordings, against what people then did."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Final

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from crowdsim.recordings import Recording
from predictor.datasets import Unit
from predictor.forecaster import CalibratedForecaster, Forecaster
from predictor.metrics import displacement_errors, moves
from predictor.scenes import Scene, scenes

WORLDS: Final = 32
"""Scenes forecast in one call."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrajectoryErrors:
    """Errors of M forecast trajectories.

    Attributes:
        errors: (M, F) displacement errors, in metres or pixels.
        moving: (M,) bool, who moves in its window (`metrics.moves`).
        agents: (M,) agents in the window of each trajectory.
        windows: (M,) number of the window.
        radius: (F,) how far from the truth the forecaster expects to stay [m], if it does.
        within: (M, F) bool, who stayed within that radius; None without one.
    """

    errors: NDArray[np.float64]
    moving: NDArray[np.bool_]
    agents: NDArray[np.int64]
    windows: NDArray[np.int64]
    radius: NDArray[np.float64] | None
    within: NDArray[np.bool_] | None


def trajectory_errors(
    forecaster: Forecaster,
    recordings: Sequence[Recording],
    *,
    unit: Unit = "m",
    progress: bool = False,
) -> TrajectoryErrors:
    """Forecast every agent of every window of some recordings.

    Args:
        forecaster: What to test.
        recordings: On what.
        unit: `px` tells errors in pixels of the pictures of the recordings.
        progress: Show a progress bar.

    Raises:
        ValueError: Another `dt` than the forecaster's, no window with an agent, or pixels where a
            recording has no picture.
    """
    radius = forecaster.radius if isinstance(forecaster, CalibratedForecaster) else None
    errors, metres, moving, agents = [], [], [], []
    bar = tqdm(desc=recordings[0].name, unit="window", disable=not progress)
    for chunk in _chunks(_all_scenes(forecaster, recordings)):
        for scene, forecast in zip(chunk, forecast_scenes(forecaster, chunk), strict=True):
            metres.append(displacement_errors(forecast, scene.future).T)
            errors.append(displacement_errors(*_in(unit, scene, forecast, scene.future)).T)
            moving.append(moves(scene.history[:, scene.agents], scene.future))
            agents.append(len(scene.agents))
        bar.update(len(chunk))
    bar.close()
    if not errors:
        raise ValueError(f"expected people to forecast in {recordings[0].name}…, found none")
    return TrajectoryErrors(
        errors=np.concatenate(errors),
        moving=np.concatenate(moving),
        agents=np.repeat(agents, agents),
        windows=np.repeat(np.arange(len(agents)), agents),
        radius=radius,
        within=None if radius is None else np.concatenate(metres) <= radius,
    )


def _in(unit: Unit, scene: Scene, *points: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """World points [m] in the unit of the errors."""
    if unit == "m":
        return list(points)
    homography = scene.recording.pixel_from_world
    if homography is None:
        raise ValueError(f"{scene.recording.name}: errors in pixels need a picture, found none")
    projected = [to_homogeneous @ homography.T for to_homogeneous in map(_homogeneous, points)]
    return [p[..., :2] / p[..., 2:] for p in projected]


def _homogeneous(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.concatenate([points, np.ones((*points.shape[:-1], 1))], axis=-1)


def _all_scenes(forecaster: Forecaster, recordings: Sequence[Recording]) -> Iterator[Scene]:
    for recording in recordings:
        yield from scenes(
            recording,
            history_steps=forecaster.history_steps,
            forecast_steps=forecaster.forecast_steps,
            frame_dt=forecaster.frame_dt,
        )


def _chunks(every: Iterator[Scene]) -> Iterator[list[Scene]]:
    while chunk := list(islice(every, WORLDS)):
        yield chunk


def forecast_scenes(forecaster: Forecaster, batch: Sequence[Scene]) -> list[NDArray[np.float64]]:
    """Forecast the agents of several scenes in one call: (F, A, 2) for each [m]."""
    steps, people = len(batch[0].history), max(scene.history.shape[1] for scene in batch)
    history = np.zeros((len(batch), steps, people, 2))
    valid = np.zeros((len(batch), steps, people), dtype=np.bool_)
    select = np.zeros((len(batch), people), dtype=np.bool_)
    for world, scene in enumerate(batch):
        history[world, :, : scene.history.shape[1]] = scene.history
        valid[world, :, : scene.history.shape[1]] = scene.valid
        select[world, scene.agents] = True
    images = [scene.recording.map_image for scene in batch]
    homographies = [scene.recording.pixel_from_world for scene in batch]
    path = forecaster.forecast(history, valid, images, homographies, select)
    return [path[world][:, scene.agents] for world, scene in enumerate(batch)]
