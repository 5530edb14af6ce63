"""A trained network as a forecaster: all people of all worlds in one batch."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Self, cast

import numpy as np
import torch
from numpy.typing import NDArray

from predictor.ablation import EVERYTHING, Ablation, ablated
from predictor.calibration import radius_of, temperature_of
from predictor.checkpoint import load_checkpoint
from predictor.config import ModelConfig
from predictor.horizon import bounded, speed_limit
from predictor.inputs import AgentInputs, build_inputs_of_worlds, check_tracks, to_world
from predictor.mirrored import Mirrored
from predictor.modal_forecast import ModalForecast, covariance_in_world, scaled, standing
from predictor.model import IterativeAttention
from predictor.modes import ordered
from predictor.networks import Network, name_of
from predictor.onnx_network import OnnxNetwork, load_onnx
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
        network: Trained network, or an exported one.
        forecast_steps: Frames to forecast; None for those the network was trained for.
        radius: (T, R) how far from the truth it stayed on validation (`predictor.calibration`) [m],
            for the first R frames and each length of history; None where nobody measured it.
        temperature: (F,) factors on the covariances of its modes (`predictor.calibration`), for
            the frames that it was trained for; None where nobody measured them.
        ablation: What of its inputs it is shown.

    Attributes:
        radius: (T, F) of the frames that are forecast; None where it is not known for all of them.
        modes: How many modes `forecast_modes` gives; 0 if the network has none, where frames are
            forecast beyond those that it was trained for, and where forecasts are averaged.
    """

    def __init__(
        self,
        network: Network | OnnxNetwork,
        *,
        forecast_steps: int | None = None,
        radius: NDArray[np.float64] | None = None,
        temperature: NDArray[np.float64] | None = None,
        ablation: Ablation = EVERYTHING,
    ) -> None:
        shown = Mirrored(network) if ablation.mirrored else network
        self.network: Network | OnnxNetwork | Mirrored = shown.eval()
        self._ablation = ablation
        self.name = name_of(network.config)
        self.frame_dt = network.config.frame_dt
        self.history_steps = network.config.history_steps
        self.forecast_steps = (
            network.config.forecast_steps if forecast_steps is None else forecast_steps
        )
        rolled = self.forecast_steps > network.config.forecast_steps
        if radius is not None:
            known = radius.shape[1] >= self.forecast_steps
            radius = radius[:, : self.forecast_steps] if known else None
        self.radius = radius
        config = network.config
        one_path = rolled or ablation.mirrored
        self.modes = config.modes if isinstance(config, ModelConfig) and not one_path else 0
        self._temperature = 1.0 if temperature is None else temperature[: self.forecast_steps]

    @classmethod
    def from_checkpoint(
        cls, path: Path, *, forecast_steps: int | None = None, ablation: Ablation = EVERYTHING
    ) -> Self:
        """Load a checkpoint, or an exported network where the suffix is `.onnx`.

        Raises:
            As `predictor.checkpoint.load_checkpoint` and `predictor.onnx_network.load_onnx`.
        """
        network: Network | OnnxNetwork
        network, about = load_onnx(path) if path.suffix == ".onnx" else load_checkpoint(path)
        history_steps, steps = network.config.history_steps, network.config.forecast_steps
        return cls(
            network,
            forecast_steps=forecast_steps,
            radius=radius_of(about, history_steps, steps),
            temperature=temperature_of(about, steps),
            ablation=ablation,
        )

    def forecast(
        self,
        history: NDArray[np.float64],
        valid: NDArray[np.bool_],
        map_images: Sequence[NDArray[np.uint8] | None] | NDArray[np.uint8] | None = None,
        pixel_from_world: Sequence[NDArray[np.float64] | None] | NDArray[np.float64] | None = None,
        select: NDArray[np.bool_] | None = None,
    ) -> NDArray[np.float64]:
        """Forecast as `Forecaster.forecast` says."""
        worlds = _worlds(history, valid, map_images, pixel_from_world, select)
        path = self._roll(*worlds)
        return np.asarray(path[0]) if history.ndim == 3 else path

    def forecast_modes(
        self,
        history: NDArray[np.float64],
        valid: NDArray[np.bool_],
        map_images: Sequence[NDArray[np.uint8] | None] | NDArray[np.uint8] | None = None,
        pixel_from_world: Sequence[NDArray[np.float64] | None] | NDArray[np.float64] | None = None,
        select: NDArray[np.bool_] | None = None,
    ) -> ModalForecast:
        """Forecast as `predictor.forecaster.ModalForecaster.forecast_modes` says."""
        if self.modes == 0:
            raise ValueError(f"expected a forecaster with modes, found {self.name} without")
        worlds = _worlds(history, valid, map_images, pixel_from_world, select)
        found = self._modes(*worlds)
        return found.of_world(0) if history.ndim == 3 else found

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
        for w, n, inputs in self._chunks(history, valid, chosen, images, homographies):
            path[w, :, n] = to_world(self._forward(inputs), inputs.world_from_agent)
        return path

    def _modes(
        self,
        history: NDArray[np.float64],
        valid: NDArray[np.bool_],
        asked: NDArray[np.bool_],
        images: Sequence[Image],
        homographies: Sequence[Homography],
    ) -> ModalForecast:
        """One pass of the network for those asked for; the others stay."""
        seen = np.where(valid[..., None], history, 0.0)
        found = standing(seen[:, -1], self.modes, self.network.config.forecast_steps)
        for w, n, inputs in self._chunks(seen, valid, asked, images, homographies):
            path, position, probability, covariance = self._forward_modes(inputs)
            frame = inputs.world_from_agent
            found.path[w, :, n] = to_world(path, frame)
            flat = position.reshape(len(position), -1, 2)
            found.position[w, :, :, n] = to_world(flat, frame).reshape(position.shape)
            found.probability[w, :, n] = probability
            found.covariance[w, :, :, n] = covariance_in_world(covariance, frame)
        longest = self.frame_dt * speed_limit(seen, valid, self.frame_dt)  # (W, N)
        found = found.with_positions(lambda path: bounded(path, seen[:, -1], longest))
        return scaled(found.until(self.forecast_steps), self._temperature)

    def _chunks(
        self,
        history: NDArray[np.float64],
        valid: NDArray[np.bool_],
        chosen: NDArray[np.bool_],
        images: Sequence[Image],
        homographies: Sequence[Homography],
    ) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], AgentInputs]]:
        """Worlds, columns and inputs of the chosen, for one pass of the network after the other."""
        config = self.network.config
        worlds, agents = np.nonzero(chosen)
        for start in range(0, len(worlds), CHUNK):
            w, n = worlds[start : start + CHUNK], agents[start : start + CHUNK]
            inputs = build_inputs_of_worlds(history, valid, w, n, images, homographies, config)
            yield w, n, ablated(inputs, self._ablation, w, images, homographies, config)

    def _forward(self, inputs: AgentInputs) -> NDArray[np.float32]:
        """(B, F, 2) paths in the agent frames."""
        with torch.inference_mode():
            _, path = self.network(**tensors(_padded(inputs)))
        return cast("NDArray[np.float32]", path[: len(inputs)].numpy())

    def _forward_modes(
        self, inputs: AgentInputs
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float64], NDArray[np.float32]]:
        """(B, F, 2) paths, (B, M, F, 2) modes, their probabilities and covariances."""
        network = cast(IterativeAttention | OnnxNetwork, self.network)  # no other has modes
        with torch.inference_mode():
            _, path, modes = network.forward_modes(**tensors(_padded(inputs)))
        count = len(inputs)
        position, probability, covariance = ordered(modes)
        return path[:count].numpy(), position[:count], probability[:count], covariance[:count]


def _worlds(
    history: NDArray[np.float64],
    valid: NDArray[np.bool_],
    map_images: Sequence[Image] | Image,
    pixel_from_world: Sequence[Homography] | Homography,
    select: NDArray[np.bool_] | None,
) -> tuple[
    NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], list[Image], list[Homography]
]:
    """Tracks, who is asked for, pictures and homographies of W worlds, checked."""
    check_tracks(history, valid, select)
    if history.ndim == 3:
        history, valid = history[None], valid[None]
        images, homographies = [cast(Image, map_images)], [cast(Homography, pixel_from_world)]
        select = None if select is None else select[None]
    else:
        images = [None] * len(history) if map_images is None else list(map_images)
        homographies = [None] * len(history) if pixel_from_world is None else list(pixel_from_world)
    if len(images) != len(history) or len(homographies) != len(history):
        raise ValueError(
            f"expected {len(history)} map images and homographies like worlds, "
            f"got {len(images)} and {len(homographies)}"
        )
    asked = valid[:, -1] if select is None else select & valid[:, -1]
    return history, valid, asked, images, homographies


def _padded(inputs: AgentInputs) -> AgentInputs:
    """The inputs with the last agent repeated up to a multiple of `ROW_MULTIPLE`."""
    padded = math.ceil(len(inputs) / ROW_MULTIPLE) * ROW_MULTIPLE
    return inputs.take(np.minimum(np.arange(padded), len(inputs) - 1))
