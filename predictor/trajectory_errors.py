"""Forecasts of every agent of every window of some recordings, against what people then did."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Final

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from crowdsim.recordings import Recording
from predictor.calibration import LEVEL, nll_of_radius
from predictor.datasets import Unit
from predictor.forecaster import CalibratedForecaster, Forecaster, ModalForecaster
from predictor.grounds import Ground
from predictor.inputs import agent_direction, seen_along
from predictor.metrics import collides, displacement_errors, misses, moves
from predictor.modal_forecast import ModalForecast
from predictor.modal_measures import measures_of_modes
from predictor.scenes import Scene, scenes

WORLDS: Final = 32
"""Scenes forecast in one call."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrajectoryErrors:
    """What was measured of M forecast trajectories.

    Attributes:
        errors: (M, F) displacement errors, in metres or pixels.
        final_offset: (M, 2) forecast minus truth at the last step, in the frame of the agent [m].
        moving: (M,) bool, who moves in its window (`metrics.moves`).
        agents: (M,) agents in the window of each trajectory.
        windows: (M,) number of the window.
        measures: Further metrics by their names, (M,) or (M, F) each, NaN where one cannot be
            told; their means are what a table shows.
        radius: (F,) how far from the truth the forecaster expects to stay [m], if it does.
    """

    errors: NDArray[np.float64]
    final_offset: NDArray[np.float64]
    moving: NDArray[np.bool_]
    agents: NDArray[np.int64]
    windows: NDArray[np.int64]
    measures: dict[str, NDArray[np.float64]]
    radius: NDArray[np.float64] | None


def trajectory_errors(
    forecaster: Forecaster,
    recordings: Sequence[Recording],
    *,
    unit: Unit = "m",
    grounds: Mapping[str, Ground] | None = None,
    progress: bool = False,
) -> TrajectoryErrors:
    """Forecast every agent of every window of some recordings.

    Args:
        forecaster: What to test.
        recordings: On what.
        unit: `px` tells errors in pixels of the pictures of the recordings.
        grounds: Where one can walk, by the names of recordings; None knows it of none.
        progress: Show a progress bar.

    Raises:
        ValueError: Another `dt` than the forecaster's, no window with an agent, or pixels where a
            recording has no picture.
    """
    radius = _full_history_radius(forecaster)
    known = {} if grounds is None else grounds
    parts: list[TrajectoryErrors] = []
    bar = tqdm(desc=recordings[0].name, unit="window", disable=not progress)
    for batch in batches(forecaster, recordings):
        for scene, (forecast, modes) in zip(batch, _forecasts(forecaster, batch), strict=True):
            measures = _measures(scene, forecast, radius, known.get(scene.recording.name))
            if modes is not None:
                measures |= _measures_of_modes(scene, modes, unit)
            parts.append(_of_scene(scene, forecast, unit, measures, number=len(parts)))
        bar.update(len(batch))
    bar.close()
    if not parts:
        raise ValueError(f"expected people to forecast in {recordings[0].name}…, found none")
    return _joined(parts, radius)


def _full_history_radius(forecaster: Forecaster) -> NDArray[np.float64] | None:
    """(F,) radii of people seen in all frames of history, as the agents of scenes are [m]."""
    if not isinstance(forecaster, CalibratedForecaster) or forecaster.radius is None:
        return None
    return np.asarray(forecaster.radius[-1])


def _of_scene(
    scene: Scene,
    forecast: NDArray[np.float64],
    unit: Unit,
    measures: dict[str, NDArray[np.float64]],
    *,
    number: int,
) -> TrajectoryErrors:
    agents = len(scene.agents)
    history, valid = scene.history[:, scene.agents], scene.valid[:, scene.agents]
    final = seen_along(
        forecast[-1] - scene.future[-1], agent_direction(history, valid), np.ones(agents, np.bool_)
    )
    return TrajectoryErrors(
        errors=displacement_errors(*_in(unit, scene, forecast, scene.future)).T,
        final_offset=final.astype(np.float64),
        moving=moves(history, scene.future),
        agents=np.full(agents, agents),
        windows=np.full(agents, number),
        measures=measures,
        radius=None,
    )


def _measures(
    scene: Scene,
    forecast: NDArray[np.float64],
    radius: NDArray[np.float64] | None,
    ground: Ground | None,
) -> dict[str, NDArray[np.float64]]:
    """Metrics besides the errors: (A,) or (A, F) each, by the names they have in a table."""
    errors = displacement_errors(forecast, scene.future).T  # (A, F)
    found = {
        "miss_rate@2m": misses(errors),
        "collision_1": collides(forecast),
        "collision_2": collides(forecast, scene.future),
        "collision_truth": collides(scene.future),
    }
    if ground is not None:
        found["off_walkable"] = ground.is_off(forecast).T
        found["off_walkable_truth"] = ground.is_off(scene.future).T
    if radius is not None:
        found[f"coverage@{LEVEL}"] = (errors <= radius).astype(np.float64)
        found["nll"] = nll_of_radius(errors, radius)
    return found


def _measures_of_modes(
    scene: Scene, modes: ModalForecast, unit: Unit
) -> dict[str, NDArray[np.float64]]:
    points = _in(unit, scene, modes.position, scene.future)
    errors = np.linalg.norm(points[0] - points[1], axis=-1)  # (M, F, A)
    return measures_of_modes(modes, scene.future, errors)


def _joined(
    parts: Sequence[TrajectoryErrors], radius: NDArray[np.float64] | None
) -> TrajectoryErrors:
    """The trajectories of all scenes; a measure that some scenes lack is unknown there."""
    names = ("errors", "final_offset", "moving", "agents", "windows")
    arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    shapes = {key: array.shape[1:] for part in parts for key, array in part.measures.items()}
    measures = {
        key: np.concatenate(
            [part.measures.get(key, np.full((len(part.errors), *shape), np.nan)) for part in parts]
        )
        for key, shape in shapes.items()
    }
    return TrajectoryErrors(**arrays, measures=measures, radius=radius)


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


def batches(forecaster: Forecaster, recordings: Sequence[Recording]) -> Iterator[list[Scene]]:
    """All scenes of some recordings as the forecaster takes them, so many as one call forecasts."""
    every = _all_scenes(forecaster, recordings)
    while batch := list(islice(every, WORLDS)):
        yield batch


def _all_scenes(forecaster: Forecaster, recordings: Sequence[Recording]) -> Iterator[Scene]:
    for recording in recordings:
        yield from scenes(
            recording,
            history_steps=forecaster.history_steps,
            forecast_steps=forecaster.forecast_steps,
            frame_dt=forecaster.frame_dt,
        )


def _forecasts(
    forecaster: Forecaster, batch: Sequence[Scene]
) -> list[tuple[NDArray[np.float64], ModalForecast | None]]:
    """Paths (F, A, 2) of the agents of each scene [m], and modes of who has some."""
    if not isinstance(forecaster, ModalForecaster) or forecaster.modes == 0:
        return [(path, None) for path in forecast_scenes(forecaster, batch)]
    found = forecaster.forecast_modes(*_worlds(batch))
    agents = [found.of_world(i).of_people(scene.agents) for i, scene in enumerate(batch)]
    return [(modes.path, modes) for modes in agents]


def forecast_scenes(forecaster: Forecaster, batch: Sequence[Scene]) -> list[NDArray[np.float64]]:
    """Forecast the agents of several scenes in one call: (F, A, 2) for each [m]."""
    path = forecaster.forecast(*_worlds(batch))
    return [path[world][:, scene.agents] for world, scene in enumerate(batch)]


def _worlds(
    batch: Sequence[Scene],
) -> tuple[
    NDArray[np.float64],
    NDArray[np.bool_],
    list[NDArray[np.uint8] | None],
    list[NDArray[np.float64] | None],
    NDArray[np.bool_],
]:
    """The scenes as the arguments of `Forecaster.forecast`, their agents selected."""
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
    return history, valid, images, homographies, select
