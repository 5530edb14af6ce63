"""Time of pictures: the crops that a predictor sees, maps, and frames that people look at."""

from collections.abc import Callable
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from crowdsim.maps import PLACES, make_place
from crowdsim.render import render_frame, render_map
from predictor.config import ModelConfig
from predictor.crops import crop_maps
from predictor.inputs import build_inputs
from scripts.benchmarks.timing import seconds_per_call

AGENTS: Final = (50, 200)
PLACE: Final = "square"
NETWORK: Final = ModelConfig(variant="patch")
FRAME_DT: Final = NETWORK.frame_dt
RADIUS: Final = 0.25


def pictures(seed: int) -> dict[str, list[dict[str, Any]]]:
    """Measure pictures of the generated places; people stand anywhere in a town square.

    `crops` is what each agent sees of the map, by the paper's network; `inputs` adds its own and
    its neighbors' tracks. `render_frame` draws all people with histories and forecasts.
    `render_map` draws a place anew, which its callers do once.

    Returns:
        `pictures`: rows with `what`, `agents` (0 where they do not matter) and `ms`.
    """
    cv2.setNumThreads(1)
    works = {(what, agents): work for agents in AGENTS for what, work in of_people(agents, seed)}
    works |= {(f"render_map {kind}", 0): of_place(kind, seed) for kind in PLACES}
    return {
        "pictures": [
            {"what": what, "agents": agents, "ms": round(1e3 * seconds_per_call(work), 3)}
            for (what, agents), work in works.items()
        ]
    }


def of_place(kind: str, layout: int) -> Callable[[], object]:
    """Drawing the map of a place."""
    map_ = make_place(kind, layout).map
    return lambda: render_map(map_)


def of_people(agents: int, seed: int) -> list[tuple[str, Callable[[], object]]]:
    """What is drawn of so many people, by name."""
    map_ = make_place(PLACE, seed).map
    image, pixel_from_world = render_map(map_)
    rng = np.random.default_rng(seed)
    now = rng.uniform(map_.bounds[:2], map_.bounds[2:], (agents, 2))
    velocity = rng.normal(0.0, 1.0, (agents, 2))
    past, future = _walked(now, velocity, -7, 1), _walked(now, velocity, 1, 13)  # (T, N, 2)
    seen, everybody = np.ones(past.shape[:2], dtype=np.bool_), np.arange(agents)
    poses = build_inputs(past, seen, everybody, image, pixel_from_world, NETWORK).world_from_agent
    worlds = np.zeros(agents, dtype=np.int64)
    return [
        ("crops", lambda: crop_maps([image], [pixel_from_world], worlds, poses, NETWORK)),
        ("inputs", lambda: build_inputs(past, seen, everybody, image, pixel_from_world, NETWORK)),
        (
            "render_frame",
            lambda: render_frame(
                image,
                pixel_from_world,
                positions=now,
                radius=np.full(agents, RADIUS),
                valid=seen[-1],
                headings=np.arctan2(velocity[:, 1], velocity[:, 0]),
                histories=list(past.swapaxes(0, 1)),
                forecasts=list(future.swapaxes(0, 1)),
            ),
        ),
    ]


def _walked(
    now: NDArray[np.float64], velocity: NDArray[np.float64], first: int, beyond: int
) -> NDArray[np.float64]:
    """(T, N, 2) where people are in the frames `first` to before `beyond`, counted from now."""
    return now + velocity * (FRAME_DT * np.arange(first, beyond)[:, None, None])
