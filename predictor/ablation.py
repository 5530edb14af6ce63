"""What a network is not shown, or shown wrongly, to learn what it makes use of.

Asked for by the ending of a forecaster's name: `iterative_attention@wrong_map`. Endings add up.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from predictor.config import NetworkConfig
from predictor.crops import crop_maps
from predictor.inputs import AgentInputs

Ground = Literal["real", "none", "blank", "rotated", "wrong"]

STEP_FRAMES: Final = 2
"""Frames of its own history that are left to an agent without history: its last step."""


@dataclass(frozen=True, kw_only=True)
class Ablation:
    """What a network is shown of what there is.

    Attributes:
        ground: The picture around the agent: `real`; `none`; `blank`, all in the colour of the
            ground that the agent stands on; `rotated`, turned by 90° about the agent; `wrong`, of
            another place in the same picture, half its size away along both sides (beyond an edge
            it goes on at the other).
        neighbors: Whether other people are shown.
        history: Whether more than the last step is shown of the agent's own history.
        mirrored: Whether all is shown a second time with left and right exchanged, and the two
            forecasts are averaged (`predictor.mirrored`).
    """

    ground: Ground = "real"
    neighbors: bool = True
    history: bool = True
    mirrored: bool = False


EVERYTHING: Final = Ablation()

ENDINGS: Final[dict[str, dict[str, Any]]] = {
    "@no_map": {"ground": "none"},
    "@blank_map": {"ground": "blank"},
    "@rotated_map": {"ground": "rotated"},
    "@wrong_map": {"ground": "wrong"},
    "@no_neighbors": {"neighbors": False},
    "@no_history": {"history": False},
    "@mirrored": {"mirrored": True},
}
"""Endings of names, and what each changes in an `Ablation`."""


def split_endings(spec: str) -> tuple[str, Ablation]:
    """The name of a forecaster without its endings, and what they ask for.

    Raises:
        ValueError: Two endings contradict each other, or one is there twice.
    """
    name, changes = spec, dict[str, Any]()
    while (ending := next((end for end in ENDINGS if name.endswith(end)), None)) is not None:
        name = name.removesuffix(ending)
        if not changes.keys().isdisjoint(ENDINGS[ending]):
            raise ValueError(f"expected one ending about the same, found several in {spec!r}")
        changes |= ENDINGS[ending]
    return name, Ablation(**changes)


def ablated(
    inputs: AgentInputs,
    ablation: Ablation,
    worlds: NDArray[np.int64],
    map_images: Sequence[NDArray[np.uint8] | None],
    pixel_from_world: Sequence[NDArray[np.float64] | None],
    config: NetworkConfig,
) -> AgentInputs:
    """The inputs of agents as an ablation shows them; each agent's alone decide about its own.

    Args:
        inputs: As `predictor.inputs.build_inputs_of_worlds` builds them.
        ablation: What to change.
        worlds: (B,) world of each agent.
        map_images: W pictures (H, W, 3) uint8 RGB, or None.
        pixel_from_world: W homographies (3, 3), or None.
        config: What the network sees.
    """
    if not ablation.neighbors:
        inputs = _without_neighbors(inputs)
    if not ablation.history:
        inputs = _without_history(inputs)
    if inputs.crop is None or ablation.ground == "real":
        return inputs
    if ablation.ground == "none":
        return replace(inputs, crop_valid=np.zeros_like(inputs.crop_valid))
    if ablation.ground == "blank":
        return replace(inputs, crop=_blank(inputs.crop))
    looking = inputs.world_from_agent @ _QUARTER_TURN
    if ablation.ground == "wrong":
        looking = _elsewhere(inputs.world_from_agent, worlds, map_images, pixel_from_world)
    return replace(inputs, crop=crop_maps(map_images, pixel_from_world, worlds, looking, config))


_QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def _without_neighbors(inputs: AgentInputs) -> AgentInputs:
    return replace(
        inputs,
        neighbors=np.zeros_like(inputs.neighbors),
        neighbors_valid=np.zeros_like(inputs.neighbors_valid),
    )


def _without_history(inputs: AgentInputs) -> AgentInputs:
    history, valid = inputs.history.copy(), inputs.history_valid.copy()
    history[:, :-STEP_FRAMES], valid[:, :-STEP_FRAMES] = 0.0, False
    return replace(inputs, history=history, history_valid=valid)


def _blank(crop: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(B, S, S, 3) pictures all in the colour that is where the agent stands."""
    size = crop.shape[1]
    return np.broadcast_to(crop[:, size // 2, size // 4, None, None], crop.shape).copy()


def _elsewhere(
    world_from_agent: NDArray[np.float64],
    worlds: NDArray[np.int64],
    map_images: Sequence[NDArray[np.uint8] | None],
    pixel_from_world: Sequence[NDArray[np.float64] | None],
) -> NDArray[np.float64]:
    """(B, 3, 3) transforms of agents that stand half a picture away, and look the same way."""
    moved = world_from_agent.copy()
    for row, world in enumerate(worlds):
        image, homography = map_images[world], pixel_from_world[world]
        if image is not None and homography is not None:
            u, v, scale = homography @ moved[row, :, 2]
            height, width = image.shape[:2]
            there = [(u / scale + 0.5 * width) % width, (v / scale + 0.5 * height) % height, 1.0]
            x, y, scale = np.linalg.solve(homography, there)
            moved[row, :2, 2] = x / scale, y / scale
    return moved
