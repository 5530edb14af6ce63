"""One forecast laid open: what the network was given, where it looked, and what that did."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Final

import numpy as np
from numpy.typing import NDArray

from crowdsim.recordings import Recording
from predictor.ablation import EVERYTHING, Ablation
from predictor.attention import Attended, attended
from predictor.crops import crop_maps
from predictor.forecaster import make_forecaster
from predictor.inputs import AgentInputs, build_inputs
from predictor.model import IterativeAttention
from predictor.network_forecaster import NetworkForecaster
from predictor.scenes import Scene, scenes

VIEW_SIDE: Final = 16.0
"""Side of the picture of the surroundings [m]; the agent stands at a quarter of it."""
VIEW_PX: Final = 800

SHOWN: Final = {
    "forecast": EVERYTHING,
    "without map": Ablation(ground="none"),
    "without neighbors": Ablation(neighbors=False),
}
"""Forecasts that are compared."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Explanation:
    """A forecast of one agent. Agent frame, metres.

    Attributes:
        inputs: What the network was given, of this agent alone.
        attended: Where it looked.
        forecasts: Of the network as it is, and with a stream switched off, each (F, 2).
        future: (F, 2) where the agent then was.
        view: (S, S, 3) uint8 RGB surroundings, laid out as a crop of side `VIEW_SIDE`; None without
            a picture.
        crop_side: Side of what the network sees of the map [m]; None if it sees none.
    """

    inputs: AgentInputs
    attended: Attended
    forecasts: dict[str, NDArray[np.float64]]
    future: NDArray[np.float64]
    view: NDArray[np.uint8] | None
    crop_side: float | None


def attentive_network(spec: str) -> IterativeAttention:
    """The network of a forecaster, by its name as in `predictor.forecaster.make_forecaster`.

    Raises:
        FileNotFoundError: The checkpoint is not there.
        ValueError: Unknown name, a damaged checkpoint, or a forecaster without attention.
    """
    forecaster = make_forecaster(spec)
    network = forecaster.network if isinstance(forecaster, NetworkForecaster) else None
    if not isinstance(network, IterativeAttention):
        raise ValueError(f"expected a network that attends, such as iterative_attention: {spec!r}")
    return network


def explain(
    network: IterativeAttention, recordings: Sequence[Recording], *, scene: int, agent: int
) -> Explanation:
    """Lay open the forecast of one agent.

    Args:
        network: In `eval` mode.
        recordings: Crowds.
        scene: Number of the window, counted over all recordings from 0.
        agent: Number of the agent in it, from 0.

    Raises:
        ValueError: There is no such scene or agent.
    """
    found, config = _scene(network, recordings, scene), network.config
    if agent >= len(found.agents):
        raise ValueError(f"expected an agent below {len(found.agents)} in the scene, got {agent}")
    image, homography = found.recording.map_image, found.recording.pixel_from_world
    column = found.agents[[agent]]
    inputs = build_inputs(found.history, found.valid, column, image, homography, config)
    world_from_agent, now = inputs.world_from_agent[0], np.zeros(1, dtype=np.int64)
    wider = replace(config, variant="patch", crop_side=VIEW_SIDE, crop_px=VIEW_PX)
    view = crop_maps([image], [homography], now, inputs.world_from_agent, wider)
    sees_map = config.variant != "none" and image is not None
    return Explanation(
        inputs=inputs,
        attended=attended(network, inputs),
        forecasts={
            label: _in_frame(_forecast(network, ablation, found, int(column[0])), world_from_agent)
            for label, ablation in SHOWN.items()
            if sees_map or ablation.ground == "real"
        },
        future=_in_frame(found.future[:, agent], world_from_agent),
        view=None if image is None or view is None else view[0],
        crop_side=config.crop_side if sees_map else None,
    )


def _scene(network: IterativeAttention, recordings: Sequence[Recording], number: int) -> Scene:
    config = network.config
    every = (
        scene
        for recording in recordings
        for scene in scenes(
            recording,
            history_steps=config.history_steps,
            forecast_steps=config.forecast_steps,
            frame_dt=config.frame_dt,
        )
    )
    scene = next(islice(every, number, None), None)
    if scene is None:
        raise ValueError(f"expected the number of a scene in the data, got {number}")
    return scene


def _forecast(
    network: IterativeAttention, ablation: Ablation, scene: Scene, column: int
) -> NDArray[np.float64]:
    """(F, 2) positions of one person, in the world frame."""
    select = np.arange(scene.valid.shape[1]) == column
    picture = scene.recording.map_image, scene.recording.pixel_from_world
    forecaster = NetworkForecaster(network, ablation=ablation)
    return forecaster.forecast(scene.history, scene.valid, *picture, select)[:, column]


def _in_frame(
    points: NDArray[np.float64], world_from_agent: NDArray[np.float64]
) -> NDArray[np.float64]:
    """World points (F, 2) in the frame of the agent."""
    axes, origin = world_from_agent[:2, :2], world_from_agent[:2, 2]
    return (points - origin) @ axes
