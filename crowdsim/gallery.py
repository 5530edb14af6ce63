"""The gallery of scenarios: one picture each, with what its function says of it."""

import inspect
import re
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from crowdsim.canvas import FOOTER_PX, Image
from crowdsim.map import Map
from crowdsim.recordings.surfaces import Surface
from crowdsim.render import render_frame, render_map
from crowdsim.robot_body import RobotBody
from crowdsim.scenario import Scenario
from crowdsim.scenarios import SCENARIOS, make_scenario
from crowdsim.wayfinding import geodesic_field
from crowdsim.world import World

FloatArray = NDArray[np.float64]

LEAD: Final = """# Scenarios

All scenarios by name, each drawn from its defaults with seed {seed} and shown after {seconds:.0f}
s: people with where they face and where they were in the last {trail:.0f} s, the robot (orange
ring) with its way, and its goal (flag). The names work everywhere:
`crowdnav evaluate --scenarios NAME`, `crowdnav render --scenario NAME`,
`crowdnav generate --scenario NAME`,
`gymnasium.make(…, scenario="NAME")`; parameters go into `scenario_parameters`. The people of every
scenario are drawn anew from the seed of the episode. Own ones go into
[scenario files](scenario_files.md).

This page is written by `python -m scripts.gallery`; a test compares it with the docstrings.
"""
SECONDS: Final = 3.0
"""When the picture is taken, counted from the start [s]."""
TRAIL: Final = 2.0
"""How much of the past is drawn [s]."""
FRAME: Final = 4
"""Physics steps between two points of a trail."""
SEED: Final = 1
ROBOT_SPEED: Final = 0.7
"""Slow, so that people are still around it [m/s]."""
LONG_SIDE_PX: Final = 760
LEAST_SCALE: Final = 24.0
"""Pixels per metre in which a person is still seen to face somewhere."""
RIM: Final = 0.8
"""How much of the buildings around the ground is shown [m]."""
STANDING: Final = 0.2
"""Who is slower faces the goal [m/s]."""


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What the function of a scenario says of it.

    Attributes:
        name: Of the scenario.
        caption: First line of the docstring.
        text: Further paragraphs.
        parameters: Name, default and meaning of each.
    """

    name: str
    caption: str
    text: str
    parameters: tuple[tuple[str, str, str], ...]


def read_entry(name: str) -> Entry:
    """Read the docstring of a scenario.

    Raises:
        ValueError: A parameter that the docstring does not explain.
    """
    function = SCENARIOS[name]
    text, _, rest = inspect.cleandoc(function.__doc__ or "").partition("\n\nArgs:\n")
    caption, _, more = text.partition("\n")
    meanings = _meanings(rest.partition("\n\n")[0])
    rows = []
    for key, parameter in inspect.signature(function).parameters.items():
        if key not in meanings:
            raise ValueError(f"{name}: expected {key} among the Args of its docstring")
        if key != "rng":
            rows.append((key, f"`{_yaml(parameter.default)}`", meanings[key]))
    return Entry(name=name, caption=caption, text=" ".join(more.split()), parameters=tuple(rows))


def _meanings(section: str) -> dict[str, str]:
    """What the `Args:` of a docstring say of each name."""
    parts = re.split(r"^ {4}(\w+): ", section, flags=re.MULTILINE)[1:]
    return {key: " ".join(text.split()) for key, text in zip(parts[::2], parts[1::2], strict=True)}


def _yaml(value: object) -> str:
    return "null" if value is None else str(value)


def page() -> str:
    """The gallery as Markdown, with pictures in a folder `scenarios` beside it."""
    lead = LEAD.format(seed=SEED, seconds=SECONDS, trail=TRAIL)
    index = " · ".join(f"[{name}](#{name})" for name in SCENARIOS)
    return "\n".join([lead, index, *(_section(read_entry(name)) for name in SCENARIOS)])


def _section(entry: Entry) -> str:
    rows = [f"| `{name}` | {default} | {text} |" for name, default, text in entry.parameters]
    return (
        "\n".join(
            [
                f"\n## {entry.name}\n",
                f"{entry.caption} {entry.text}".rstrip() + "\n",
                f"![{entry.caption}](scenarios/{entry.name}.webp)\n",
                "| parameter | default | meaning |\n|---|---|---|",
                *rows,
            ]
        )
        + "\n"
    )


def picture(name: str) -> bytes:
    """Draw a scenario some seconds into an episode; the content of a .webp file.

    Raises:
        FileNotFoundError: A replay whose data is not there.
    """
    scenario = make_scenario(name, np.random.default_rng(SEED))
    # Photographs belong to their data sets: what is shown is what bodies bump into.
    scenario = replace(scenario, map=replace(scenario.map, picture=None))
    world = World(scenario, rng=np.random.default_rng(SEED), robot=RobotBody())
    rows = _run(world, scenario)
    ok, content = cv2.imencode(
        ".webp",
        cv2.cvtColor(_draw(world, scenario, rows), cv2.COLOR_RGB2BGR),
        [cv2.IMWRITE_WEBP_QUALITY, 80],
    )
    if not ok:
        raise ValueError(f"{name}: this OpenCV cannot write WebP")
    return content.tobytes()


Row = tuple[NDArray[np.int64], FloatArray, FloatArray]
"""Who is there (id, else -1), and positions of the people and of the robot."""


def _run(world: World, scenario: Scenario) -> list[Row]:
    """Let the robot drive the shortest way; what was where in the last seconds."""
    way = geodesic_field(scenario.map, scenario.robot_goal)
    rows = []
    for step in range(round(SECONDS / world.physics_dt)):
        if step % FRAME == 0:
            rows.append(_row(world))
        world.step(ROBOT_SPEED * way.direction(world.robot_position))
    return [*rows[-round(TRAIL / world.physics_dt / FRAME) :], _row(world)]


def _row(world: World) -> Row:
    return np.where(world.valid, world.ids, -1), world.positions, world.robot_position


def _draw(world: World, scenario: Scenario, rows: list[Row]) -> Image:
    velocity, ahead = world.velocities, world.goals - world.positions
    stands = np.linalg.norm(velocity, axis=1) < STANDING
    facing = np.where(stands[:, None], ahead, velocity)
    x, y = world.robot_velocity
    position = world.robot_position
    image, pixel_from_world = _ground(scenario.map)
    frame = render_frame(
        image,
        pixel_from_world,
        positions=world.positions,
        radius=world.radius,
        valid=world.valid,
        ids=world.ids,
        headings=np.arctan2(facing[:, 1], facing[:, 0]),
        histories=[_history(rows, person) for person in range(len(world.ids))],
        robot=(position[0], position[1], float(np.arctan2(y, x))),
        robot_history=np.array([at for _, _, at in rows]),
        robot_goal=scenario.robot_goal,
        scale=1.0,
    )
    return frame[:-FOOTER_PX]


def _ground(ground: Map) -> tuple[Image, FloatArray]:
    """Picture of a map, cut to where people can be, and its homography."""
    x_min, y_min, x_max, y_max = ground.bounds
    scale = max(LONG_SIDE_PX / max(x_max - x_min, y_max - y_min), LEAST_SCALE)
    image, pixel_from_world = render_map(ground, scale)
    rim = round(RIM * scale)
    is_open = (image != Surface.BUILDING.color_rgb).any(axis=-1)
    (top, bottom), (left, right) = (
        (max(at[0] - rim, 0), at[-1] + rim)
        for at in (np.flatnonzero(is_open.any(axis=1)), np.flatnonzero(is_open.any(axis=0)))
    )
    shift = np.array([[1.0, 0.0, -left], [0.0, 1.0, -top], [0.0, 0.0, 1.0]])
    return np.ascontiguousarray(image[top:bottom, left:right]), shift @ pixel_from_world


def _history(rows: list[Row], person: int) -> FloatArray:
    """Where one person was (P, 2), as long as he or she is the same one."""
    now = rows[-1][0][person]
    return np.array([positions[person] for ids, positions, _ in rows if ids[person] == now])
