"""Training windows: extracted once into arrays, augmented and given their map crops in batches."""

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings import Recording
from predictor.config import ModelConfig
from predictor.crops import crop_maps
from predictor.inputs import AgentInputs, build_inputs
from predictor.scenes import Scene, scenes


@dataclass(frozen=True, kw_only=True, eq=False)
class Windows:
    """M training windows, one for each agent of each scene.

    Attributes:
        inputs: Inputs of the M agents, still without crops.
        future: (M, F, 2) float32 true later positions in the agent frame [m].
        recording: (M,) number of the recording that a window was cut from.
        images: Picture of each recording, or None.
        homographies: Homography of each recording, or None.
        config: What the network sees.
    """

    inputs: AgentInputs
    future: NDArray[np.float32]
    recording: NDArray[np.int64]
    images: list[NDArray[np.uint8] | None]
    homographies: list[NDArray[np.float64] | None]
    config: ModelConfig

    def __len__(self) -> int:
        return len(self.future)

    def batch(
        self, rows: NDArray[np.int64], stretch: NDArray[np.float64] | None = None
    ) -> tuple[AgentInputs, NDArray[np.float32]]:
        """Inputs with crops, and futures, of some windows.

        Args:
            rows: (B,) which windows.
            stretch: (B, 2) factors on x and y of the agent frame, crop included: -1 on y mirrors,
                equal ones scale. None leaves all as it was.
        """
        inputs, future = self.inputs.take(rows), self.future[rows]
        if stretch is not None:
            inputs, future = _stretched(inputs, stretch), future * _over(future, stretch)
        crop = crop_maps(
            self.images,
            self.homographies,
            self.recording[rows],
            inputs.world_from_agent,
            self.config,
        )
        return replace(inputs, crop=crop), future


def _over(points: NDArray[np.float32], stretch: NDArray[np.float64]) -> NDArray[np.float32]:
    """(B, 2) factors, shaped to multiply (B, ..., 2) points."""
    factors = stretch.astype(np.float32)
    return factors.reshape(len(stretch), *[1] * (points.ndim - 2), 2)


def _stretched(inputs: AgentInputs, stretch: NDArray[np.float64]) -> AgentInputs:
    return replace(
        inputs,
        history=inputs.history * _over(inputs.history, stretch),
        neighbors=inputs.neighbors * _over(inputs.neighbors, stretch),
        last_step=inputs.last_step * _over(inputs.last_step, stretch),
        world_from_agent=inputs.world_from_agent
        / np.concatenate([stretch, np.ones((len(stretch), 1))], axis=1)[:, None],
    )


def extract_windows(
    recordings: list[Recording],
    config: ModelConfig,
    *,
    stride: int = 1,
    truncate: float = 0.0,
    rng: np.random.Generator | None = None,
) -> Windows:
    """Cut recordings into windows and build the inputs of every agent.

    Args:
        recordings: Crowds, `config.frame_dt` apart.
        config: What the network sees.
        stride: Frames between the beginnings of two windows.
        truncate: Share of scenes whose first 1 to T-1 frames are hidden from everyone.
        rng: Draws what is hidden, and turns each scene by a random angle: who stands is seen along
            world +x, which must not mean anything. None (validation, tests): neither.

    Raises:
        ValueError: There is no window, or a recording has another `dt`.
    """
    parts: list[tuple[AgentInputs, NDArray[np.float32], int]] = []
    # crops are cut batch by batch: kept, they would take 12 kB a window
    blind = replace(config, variant="none")
    for number, recording in enumerate(recordings):
        for scene in scenes(
            recording,
            history_steps=config.history_steps,
            forecast_steps=config.forecast_steps,
            frame_dt=config.frame_dt,
            stride=stride,
        ):
            parts.append((*_scene_windows(scene, blind, truncate, rng), number))
    if not parts:
        steps = config.history_steps + config.forecast_steps
        raise ValueError(f"expected people who stay for {steps} frames, found none in the data")
    return Windows(
        inputs=_joined(part[0] for part in parts),
        future=np.concatenate([part[1] for part in parts]),
        recording=np.repeat([part[2] for part in parts], [len(part[1]) for part in parts]),
        images=[recording.map_image for recording in recordings],
        homographies=[recording.pixel_from_world for recording in recordings],
        config=config,
    )


def _scene_windows(
    scene: Scene, config: ModelConfig, truncate: float, rng: np.random.Generator | None
) -> tuple[AgentInputs, NDArray[np.float32]]:
    """Inputs and futures of the agents of one scene, in the frames of that scene's world."""
    valid, turn = scene.valid, np.eye(3)
    if rng is not None:
        turn = _rotation(rng.uniform(-np.pi, np.pi))
        if rng.random() < truncate:
            valid = valid.copy()
            valid[: rng.integers(1, config.history_steps)] = False
    picture = scene.recording.map_image, scene.recording.pixel_from_world
    history = scene.history @ turn[:2, :2].T
    inputs = build_inputs(history, valid, scene.agents, *picture, config)
    world_from_agent = turn.T @ inputs.world_from_agent
    future = _to_agent(scene.future.swapaxes(0, 1), world_from_agent)
    return replace(inputs, world_from_agent=world_from_agent), future


def _rotation(angle: float) -> NDArray[np.float64]:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def _to_agent(
    points: NDArray[np.float64], world_from_agent: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Take (A, F, 2) world points into the agents' frames."""
    axes, origin = world_from_agent[:, :2, :2], world_from_agent[:, None, :2, 2]
    return np.asarray((points - origin) @ axes, dtype=np.float32)


def _joined(parts: Iterable[AgentInputs]) -> AgentInputs:
    every = list(parts)
    arrays = {
        field.name: np.concatenate([getattr(part, field.name) for part in every])
        for field in fields(AgentInputs)
        if field.name != "crop"
    }
    return AgentInputs(crop=None, **arrays)
