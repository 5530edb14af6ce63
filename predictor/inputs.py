"""From tracks in the world frame to the network's inputs: the same code trains and serves.

The agent frame has its origin at the agent's last position and +x along its last displacement,
y to the left. Neighbors and the map crop are seen in it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from predictor.config import NetworkConfig
from predictor.crops import crop_maps, has_picture
from predictor.neighbors import nearest

STANDING_EXTENT = 0.1
"""Who got no further than this away from the last position within the history stands [m]."""

LEAST_DISPLACEMENT = 0.01
"""A displacement below this has no direction [m]: recordings are rounded to millimetres."""

WORLD_X = np.array([1.0, 0.0])


@dataclass(frozen=True, kw_only=True, eq=False)
class AgentInputs:
    """What the network is given for B agents. Agent frame, metres, 0 where not valid.

    Attributes:
        history: (B, T, 2) float32 own positions; the last row is 0, 0.
        history_valid: (B, T) bool.
        neighbors: (B, K, T, 2) float32 positions of the K nearest people, nearest first.
        neighbors_valid: (B, K, T) bool.
        last_step: (B, 2) float32 last displacement per frame; 0 where seen only once.
        crop: (B, S, S, 3) uint8 RGB, or None for a model without a map. The agent is a quarter
            of the side from the left edge, half-way down, and looks to the right.
        crop_valid: (B,) bool, False where the world has no picture.
        world_from_agent: (B, 3, 3) float64 homogeneous transform.
    """

    history: NDArray[np.float32]
    history_valid: NDArray[np.bool_]
    neighbors: NDArray[np.float32]
    neighbors_valid: NDArray[np.bool_]
    last_step: NDArray[np.float32]
    crop: NDArray[np.uint8] | None
    crop_valid: NDArray[np.bool_]
    world_from_agent: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.history)

    def take(self, rows: NDArray[np.int64]) -> Self:
        """The inputs of some of the agents."""
        taken: dict[str, Any] = {}
        for field in fields(self):
            array = getattr(self, field.name)
            taken[field.name] = None if array is None else array[rows]
        return type(self)(**taken)


def check_tracks(
    history: NDArray[np.float64], valid: NDArray[np.bool_], select: NDArray[np.bool_] | None
) -> None:
    """Check what a forecaster is handed.

    Raises:
        ValueError: Shapes contradict each other or a valid position is not finite.
    """
    if history.ndim not in (3, 4) or history.shape[-1] != 2 or history.shape[-3] < 1:
        raise ValueError(f"history must be (W, T, N, 2) or (T, N, 2), got {history.shape}")
    if valid.shape != history.shape[:-1] or valid.dtype != np.bool_:
        raise ValueError(
            f"valid must be bool {history.shape[:-1]} like history, got {valid.dtype} {valid.shape}"
        )
    people = (*valid.shape[:-2], valid.shape[-1])
    if select is not None and (select.shape != people or select.dtype != np.bool_):
        raise ValueError(f"select must be bool {people}, got {select.dtype} {select.shape}")
    # Mostly all of it is finite, and picking out what is valid takes several times as long.
    if not (np.isfinite(history).all() or np.isfinite(history[valid]).all()):
        raise ValueError("history must be finite where valid, got NaN or infinity")


def last_step(
    history: NDArray[np.float64], valid: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Displacement per frame between the last two frames in which each person was seen.

    Args:
        history: (..., T, N, 2) positions [m]; the last row is now.
        valid: (..., T, N) bool.

    Returns:
        (..., N, 2) displacement per frame [m], 0 where it cannot be known, and
        (..., N) bool, True where it is known: seen now and at least once before.
    """
    earlier = valid[..., :-1, :]
    if earlier.shape[-2] == 0:
        return np.zeros_like(history[..., -1, :, :]), np.zeros_like(valid[..., -1, :])
    gap = 1 + np.argmax(earlier[..., ::-1, :], axis=-2)
    known = valid[..., -1, :] & earlier.any(axis=-2)
    row = (history.shape[-3] - 1 - gap)[..., None, :, None]
    previous = np.take_along_axis(history, row, axis=-3)[..., 0, :, :]
    step = (history[..., -1, :, :] - previous) / gap[..., None]
    return np.where(known[..., None], step, 0.0), known


def agent_direction(
    history: NDArray[np.float64],
    valid: NDArray[np.bool_],
    undirected: NDArray[np.float64] = WORLD_X,
) -> NDArray[np.float64]:
    """Unit vector along which each person is taken to look: +x of the agent frame.

    Who moves looks along the last displacement. Who stands (or has just stopped dead) looks along
    the displacement over the whole history, and where that is nothing either, along world +x.

    Args:
        history: (..., T, N, 2) positions [m], seen now.
        valid: (..., T, N) bool.
        undirected: Unit vector, or one for each of (..., N), to take instead of world +x.

    Returns:
        (..., N, 2) unit vectors.
    """
    step, _ = last_step(history, valid)
    since = np.where(valid[..., None], history[..., -1:, :, :] - history, 0.0)
    extent = np.linalg.norm(since, axis=-1).max(axis=-2)
    first = np.argmax(valid, axis=-2)[..., None, :, None]
    overall = np.take_along_axis(since, first, axis=-3)[..., 0, :, :]
    moves = (extent >= STANDING_EXTENT) & (np.linalg.norm(step, axis=-1) >= LEAST_DISPLACEMENT)
    along = np.where(moves[..., None], step, overall)
    length = np.linalg.norm(along, axis=-1, keepdims=True)
    directed = length >= LEAST_DISPLACEMENT
    return np.where(directed, along / np.where(directed, length, 1.0), undirected)


def build_inputs(
    history: NDArray[np.float64],
    valid: NDArray[np.bool_],
    agents: NDArray[np.int64],
    map_image: NDArray[np.uint8] | None,
    pixel_from_world: NDArray[np.float64] | None,
    config: NetworkConfig,
) -> AgentInputs:
    """Build the network's inputs for some people of one world.

    Args:
        history: (T, N, 2) positions in the world frame [m]; the last row is now.
        valid: (T, N) bool.
        agents: (B,) columns of the people to forecast, seen now.
        map_image: (H, W, 3) uint8 RGB picture of the ground, or None.
        pixel_from_world: (3, 3) homography into the picture, or None.
        config: What the network sees.

    Raises:
        ValueError: The history has another number of frames than `config`, or an agent is not
            seen now.
    """
    worlds = np.zeros(len(agents), dtype=np.int64)
    return build_inputs_of_worlds(
        history[None], valid[None], worlds, agents, [map_image], [pixel_from_world], config
    )


def build_inputs_of_worlds(
    history: NDArray[np.float64],
    valid: NDArray[np.bool_],
    worlds: NDArray[np.int64],
    agents: NDArray[np.int64],
    map_images: Sequence[NDArray[np.uint8] | None],
    pixel_from_world: Sequence[NDArray[np.float64] | None],
    config: NetworkConfig,
) -> AgentInputs:
    """Build the network's inputs for people of several worlds: `build_inputs` for each, at once.

    Args:
        history: (W, T, N, 2) positions in the frame of each world [m]; the last row is now.
        valid: (W, T, N) bool.
        worlds: (B,) world of each agent.
        agents: (B,) column of each agent in its world, seen now.
        map_images: W pictures (H, W, 3) uint8 RGB, or None.
        pixel_from_world: W homographies (3, 3), or None.
        config: What the network sees.

    Raises:
        ValueError: The history has another number of frames than `config`, or an agent is not
            seen now.
    """
    if history.shape[1] != config.history_steps:
        raise ValueError(f"history must have {config.history_steps} frames, got {history.shape[1]}")
    if not valid[worlds, -1, agents].all():
        raise ValueError("every agent must be seen in the last frame of the history")
    own, own_valid = history[worlds, :, agents], valid[worlds, :, agents]  # (B, T, 2), (B, T)
    others, others_valid = nearest(history, valid, worlds, agents, config.neighbors)
    origin = own[:, -1]
    inputs = inputs_around(
        own - origin[:, None],
        own_valid,
        others - origin[:, None, None],
        others_valid,
        origin,
    )
    return replace(
        inputs,
        crop=crop_maps(map_images, pixel_from_world, worlds, inputs.world_from_agent, config),
        crop_valid=has_picture(map_images, pixel_from_world)[worlds],
    )


def inputs_around(
    own: NDArray[np.float64],
    own_valid: NDArray[np.bool_],
    others: NDArray[np.float64],
    others_valid: NDArray[np.bool_],
    origin: NDArray[np.float64],
    undirected: NDArray[np.float64] = WORLD_X,
) -> AgentInputs:
    """Inputs of agents, without crops, from tracks around where the agents are now.

    Args:
        own: (B, T, 2) positions of the agents along the axes of their worlds, from `origin` [m].
        own_valid: (B, T) bool, True in the last frame.
        others: (B, K, T, 2) positions of neighbors, likewise.
        others_valid: (B, K, T) bool.
        origin: (B, 2) positions of the agents now, in the frames of their worlds [m].
        undirected: As `agent_direction`.
    """
    direction = agent_direction(own[:, :, None], own_valid[:, :, None], undirected[..., None, :])
    direction = direction[:, 0]  # (B, 2)
    step, _ = last_step(own[:, :, None], own_valid[:, :, None])  # (B, 1, 2)
    return AgentInputs(
        history=seen_along(own, direction, own_valid),
        history_valid=own_valid,
        neighbors=seen_along(others, direction, others_valid),
        neighbors_valid=others_valid,
        last_step=seen_along(step, direction, own_valid[:, -1:])[:, 0],
        crop=None,
        crop_valid=np.zeros(len(own), dtype=np.bool_),
        world_from_agent=_world_from_agent(origin, direction),
    )


def seen_along(
    offset: NDArray[np.float64], direction: NDArray[np.float64], valid: NDArray[np.bool_]
) -> NDArray[np.float32]:
    """Turn (B, ..., 2) world offsets into agent frames that look along (B, 2) directions.

    What is not `valid` (B, ...) becomes 0.

    Written element by element: a matrix product would round differently in different batches.
    """
    cos, sin = np.moveaxis(direction.reshape(len(direction), *[1] * (offset.ndim - 2), 2), -1, 0)
    x, y = offset[..., 0], offset[..., 1]
    ahead_left = np.stack([cos * x + sin * y, cos * y - sin * x], axis=-1)
    return np.where(valid[..., None], ahead_left, 0.0).astype(np.float32)


def _world_from_agent(
    origin: NDArray[np.float64], direction: NDArray[np.float64]
) -> NDArray[np.float64]:
    world_from_agent = np.zeros((len(origin), 3, 3))
    world_from_agent[:, :2, 0] = direction
    world_from_agent[:, 0, 1], world_from_agent[:, 1, 1] = -direction[:, 1], direction[:, 0]
    world_from_agent[:, :2, 2] = origin
    world_from_agent[:, 2, 2] = 1.0
    return world_from_agent


def to_world(
    points: NDArray[np.floating], world_from_agent: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Take (B, F, 2) points from the agent frames into the frames of their worlds [m]."""
    axes, origin = world_from_agent[:, :2, :2], world_from_agent[:, None, :2, 2]
    x, y = points[..., 0, None].astype(np.float64), points[..., 1, None].astype(np.float64)
    return np.asarray(origin + x * axes[:, None, :, 0] + y * axes[:, None, :, 1])
