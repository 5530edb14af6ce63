"""A trained network as a forecaster: all people of all worlds in one batch."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Self, cast

import numpy as np
import torch
from numpy.typing import NDArray

from predictor.ablation import EVERYTHING, Ablation, ablated
from predictor.calibration import radius_of
from predictor.checkpoint import load_checkpoint
from predictor.horizon import bounded, speed_limit
from predictor.inputs import AgentInputs, build_inputs_of_worlds, check_tracks, to_world
from predictor.networks import Network, name_of
from predictor.tensors import tensors

Image = NDArray[np.uint8] | None
Homography = NDArray[np.float64] | None

ROW_MULTIPLE = 8
"""Batches are padded to this: float32 products are then bit-equal per row for any batch size."""

CHUNK = 256
"""Agents in one pass of the network; bounds its memory, and keeps it in the cache."""


class NetworkForecaster:
    """Any trained network behind the interface of `predictor.forecaster.Forecaster`.

    Beyond the steps that the network was trained for it is rolled on: it is given its own
    forecasts of everyone as history, and the map around where they got to. Nobody is forecast to be
    faster than `predictor.horizon.speed_limit` says.

    Args:
        network: Trained network.
        forecast_steps: Frames to forecast; None for those the network was trained for.
        radius: (F,) how far from the truth it stayed on validation (`predictor.calibration`) [m],
            for the frames that it was trained for; None where nobody measured it.
        ablation: What of its inputs it is shown.

    Attributes:
        radius: That of the frames that are forecast; None beyond those it was trained for.
    """

    def __init__(
        self,
        network: Network,
        *,
        forecast_steps: int | None = None,
        radius: NDArray[np.float64] | None = None,
        ablation: Ablation = EVERYTHING,
    ) -> None:
        self.network = network.eval()
        self._ablation = ablation
        self.name = name_of(network.config)
        self.frame_dt = network.config.frame_dt
        self.history_steps = network.config.history_steps
        self.forecast_steps = (
            network.config.forecast_steps if forecast_steps is None else forecast_steps
        )
        rolled = self.forecast_steps > network.config.forecast_steps
        self.radius = None if radius is None or rolled else radius[: self.forecast_steps]

    @classmethod
    def from_checkpoint(
        cls, path: Path, *, forecast_steps: int | None = None, ablation: Ablation = EVERYTHING
    ) -> Self:
        """Load a checkpoint; raises as `predictor.checkpoint.load_checkpoint` does."""
        network, about = load_checkpoint(path)
        radius = radius_of(about, network.config.forecast_steps)
        return cls(network, forecast_steps=forecast_steps, radius=radius, ablation=ablation)

    def forecast(
        self,
        history: NDArray[np.float64],
        valid: NDArray[np.bool_],
        map_images: Sequence[NDArray[np.uint8] | None] | NDArray[np.uint8] | None = None,
        pixel_from_world: Sequence[NDArray[np.float64] | None] | NDArray[np.float64] | None = None,
        select: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.float64]:
        """Forecast as `Forecaster.forecast` says."""
        check_tracks(history, valid, select)
        if history.ndim == 3:
            path = self.forecast(
                history[None],
                valid[None],
                [cast(Image, map_images)],
                [cast(Homography, pixel_from_world)],
                None if select is None else select[None],
            )
            return np.asarray(path[0])
        count = len(history)
        images = [None] * count if map_images is None else list(map_images)
        homographies = [None] * count if pixel_from_world is None else list(pixel_from_world)
        if len(images) != count or len(homographies) != count:
            raise ValueError(
                f"expected {count} map images and homographies like worlds, "
                f"got {len(images)} and {len(homographies)}"
            )
        asked = valid[:, -1] if select is None else select & valid[:, -1]
        return self._roll(history, valid, asked, images, homographies)

    def _roll(
        self,
        history: NDArray[np.float64],
        valid: NDArray[np.bool_],
        asked: NDArray[np.bool_],
        images: Sequence[Image],
        homographies: Sequence[Homography],
    ) -> NDArray[np.float64]:
        """Pass after pass until `forecast_steps` are there: (W, F, N, 2)."""
        config = self.network.config
        seen = np.where(valid[..., None], history, 0.0)
        now = seen[:, -1:]
        longest = self.frame_dt * speed_limit(seen, valid, self.frame_dt)  # (W, N)
        passes = math.ceil(self.forecast_steps / config.forecast_steps)
        # who is rolled on needs the forecasts of everyone, not only of those asked for
        chosen = asked if passes == 1 else valid[:, -1]
        paths = []
        for _ in range(passes):
            path = self._pass(seen, valid, chosen, images, homographies)
            path = bounded(path, seen[:, -1], longest)
            paths.append(path)
            seen = np.concatenate([seen, path], axis=1)[:, -config.history_steps :]
            later = np.repeat(valid[:, -1:], config.forecast_steps, axis=1)
            valid = np.concatenate([valid, later], axis=1)[:, -config.history_steps :]
        whole = np.concatenate(paths, axis=1)[:, : self.forecast_steps]
        return np.where(asked[:, None, :, None], whole, now)

    def _pass(
        self,
        history: NDArray[np.float64],
        valid: NDArray[np.bool_],
        chosen: NDArray[np.bool_],
        images: Sequence[Image],
        homographies: Sequence[Homography],
    ) -> NDArray[np.float64]:
        """One pass of the network for the chosen; the others stay."""
        config = self.network.config
        path = np.repeat(history[:, -1:], config.forecast_steps, axis=1)
        worlds, agents = np.nonzero(chosen)
        for start in range(0, len(worlds), CHUNK):
            w, n = worlds[start : start + CHUNK], agents[start : start + CHUNK]
            inputs = build_inputs_of_worlds(history, valid, w, n, images, homographies, config)
            inputs = ablated(inputs, self._ablation, w, images, homographies, config)
            path[w, :, n] = to_world(self._forward(inputs), inputs.world_from_agent)
        return path

    def _forward(self, inputs: AgentInputs) -> NDArray[np.float32]:
        """(B, F, 2) paths in the agent frames."""
        count = len(inputs)
        padded = math.ceil(count / ROW_MULTIPLE) * ROW_MULTIPLE
        rows = np.minimum(np.arange(padded), count - 1)
        with torch.inference_mode():
            _, path = self.network(**tensors(inputs.take(rows)))
        return cast("NDArray[np.float32]", path[:count].numpy())
