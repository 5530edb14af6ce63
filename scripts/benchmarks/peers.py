"""Other crowd simulators, each walking the same counterflow by its own model.

Routing is kept as cheap as each interface allows. What a peer needs and ours does not is said in
its class; nothing of it runs while the clock does, unless a step cannot do without.
"""

import contextlib
import logging
import tempfile
from collections.abc import Iterator
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, Protocol

import numpy as np
import shapely
from numpy.typing import NDArray

from crowdsim.map import Map
from crowdsim.orca import Orca
from crowdsim.scenario import Scenario

FloatArray = NDArray[np.float64]

INSTALL: Final = "pip install 'crowdnav-testbed[bench]'"
DT: Final = 0.05
"""Length of a step wherever the model allows it: that of `World` [s]."""
ARRIVED: Final = 0.6
"""Who is this near turns round [m]; PySocialForce stops people at 0.5 m."""
MAX_SPEED: Final = 1.3
"""Largest speed, as a multiple of the desired one, of a peer that wants to be told."""


class Peer(Protocol):
    """A crowd simulated by somebody else's code.

    Attributes:
        dt: Seconds per step.
    """

    dt: float

    def __init__(self, scenario: Scenario) -> None:
        """Place the people of a counterflow."""

    def step(self) -> tuple[FloatArray, FloatArray]:
        """Move on by `dt` and read back positions (N, 2) [m] and velocities (N, 2) [m/s]."""


class _JuPedSim:
    """JuPedSim: compiled, a closed walkable polygon, people on journeys from stage to stage.

    In the open, the polygon ends `FREE` metres beyond the people. Walls between rows are slits
    that end just before the sides, for the polygon must be one piece. Two waypoints per person,
    each leading to the other, cost less than steering from Python. No velocity is kept by its
    fastest model, so displacements are divided by `dt` for both.
    """

    FREE: Final = 10.0
    SLIT: Final = 0.02
    """Width of the slits [m]."""
    GAP: Final = 0.1
    """Between a slit and the sides; too narrow for anybody [m]."""
    MODEL: str
    dt = DT

    def __init__(self, scenario: Scenario) -> None:
        """Place the people of a counterflow."""
        import jupedsim

        people = scenario.pedestrians
        self._simulation = jupedsim.Simulation(
            model=getattr(jupedsim, self.MODEL)(),
            geometry=self._walkable(scenario.map),
            dt=self.dt,
        )
        parameters = getattr(jupedsim, f"{self.MODEL}AgentParameters")
        for row, start in enumerate(people.position.tolist()):
            journey, stage = self._journey(jupedsim, people.waypoints[row, 0].tolist(), start)
            agent = parameters(
                position=start,
                journey_id=journey,
                stage_id=stage,
                desired_speed=float(people.desired_speed[row]),
                radius=float(people.radius[row]),
            )
            self._simulation.add_agent(agent)
        self._positions: FloatArray = people.position.copy()

    def step(self) -> tuple[FloatArray, FloatArray]:
        """Move on by `dt` and read back positions (N, 2) [m] and velocities (N, 2) [m/s]."""
        self._simulation.iterate()
        positions = np.array([agent.position for agent in self._simulation.agents()])
        velocities = (positions - self._positions) / self.dt
        self._positions = positions
        return positions, velocities

    def _journey(self, jupedsim: Any, goal: list[float], start: list[float]) -> tuple[int, int]:
        """Go back and forth for ever; returns the journey and its first stage."""
        there, back = (
            self._simulation.add_waypoint_stage(tuple(end), ARRIVED) for end in (goal, start)
        )
        journey = jupedsim.JourneyDescription([there, back])
        fixed = jupedsim.Transition.create_fixed_transition
        journey.set_transition_for_stage(there, fixed(back))
        journey.set_transition_for_stage(back, fixed(there))
        return self._simulation.add_journey(journey), there

    def _walkable(self, map_: Map) -> shapely.Polygon:
        box = shapely.box(*map_.bounds)
        if len(map_.walls) == 0:
            return box.buffer(self.FREE, join_style="mitre")
        walls = shapely.MultiLineString(list(map_.walls)).difference(box.exterior.buffer(self.GAP))
        return box.difference(walls.buffer(0.5 * self.SLIT, cap_style="flat"))


class JuPedSimSocialForce(_JuPedSim):
    """Its social force (Helbing, Farkas and Vicsek 2000).

    Bodies are so stiff that people jump off the ground with steps of 0.05 s, which ends the run;
    0.01 s is its default.
    """

    MODEL = "SocialForceModel"
    dt = 0.01


class JuPedSimCollisionFreeSpeed(_JuPedSim):
    """The fastest of its other models (Tordeux, Chraibi and Seyfried 2016)."""

    MODEL = "CollisionFreeSpeedModel"


class Pyrvo:
    """pyrvo: the RVO2 library (ORCA) bound agent by agent; preferred velocities are the user's.

    They are computed in NumPy for all and handed over one by one in every step, as its examples
    do. Ranges and horizons are those of our own ORCA.
    """

    dt = DT

    def __init__(self, scenario: Scenario) -> None:
        """Place the people of a counterflow."""
        import pyrvo

        people, orca = scenario.pedestrians, Orca()
        common = (orca.interaction_range, orca.neighbors, orca.horizon, orca.wall_horizon)
        radius, max_speed = people.radius.tolist(), (MAX_SPEED * people.desired_speed).tolist()
        self._simulation = pyrvo.RVOSimulator(DT, *common, radius[0], max_speed[0])
        for row, start in enumerate(people.position.tolist()):
            self._simulation.add_agent(start, *common, radius[row], max_speed[row])
        for wall in scenario.map.walls:
            self._simulation.add_obstacle(wall.tolist())
        self._simulation.process_obstacles()
        self._speed = people.desired_speed
        self._positions: FloatArray = people.position.copy()
        self._goal, self._other = people.waypoints[:, 0].copy(), people.position.copy()

    def step(self) -> tuple[FloatArray, FloatArray]:
        """Move on by `dt` and read back positions (N, 2) [m] and velocities (N, 2) [m/s]."""
        simulation, people = self._simulation, range(len(self._speed))
        way = self._goal - self._positions
        distance = np.sqrt(np.square(way).sum(axis=1))
        _turn_round(distance < ARRIVED, self._goal, self._other)
        wanted = (way * (self._speed / distance)[:, None]).tolist()
        for person in people:
            simulation.set_agent_pref_velocity(person, wanted[person])
        simulation.do_step()
        places = [simulation.get_agent_position(person) for person in people]
        self._positions = np.array([(place.x, place.y) for place in places])
        moves = [simulation.get_agent_velocity(person) for person in people]
        return self._positions, np.array([(move.x, move.y) for move in moves])


class PySocialForce:
    """PySocialForce: Moussaïd's social force in NumPy and numba; everybody feels everybody.

    Walls are rows of points 0.1 m apart, its default. It keeps every state ever reached; they are
    dropped here. Who arrives stops, so goals are swapped just before.
    """

    dt = DT

    def __init__(self, scenario: Scenario) -> None:
        """Place the people of a counterflow."""
        people = scenario.pedestrians
        state = np.concatenate([people.position, people.velocity, people.waypoints[:, 0]], axis=1)
        ends = [(start[0], end[0], start[1], end[1]) for start, end in scenario.map.walls]
        with _scratch_folder() as folder, _own_logging():
            import pysocialforce

            settings = folder / "settings.toml"
            settings.write_text(f"step_width = {DT}\n[scene]\nenable_group = false\n")
            self._simulation = pysocialforce.Simulator(
                state, obstacles=ends or None, config_file=str(settings)
            )
        self._other = people.position.copy()

    def step(self) -> tuple[FloatArray, FloatArray]:
        """Move on by `dt` and read back positions (N, 2) [m] and velocities (N, 2) [m/s]."""
        people = self._simulation.step().peds
        people.ped_states.clear()
        people.group_states.clear()
        goal = people.state[:, 4:6]
        distance = np.sqrt(np.square(goal - people.pos()).sum(axis=1))
        _turn_round(distance < ARRIVED, goal, self._other)
        return people.pos().copy(), people.vel().copy()


PEERS: Final[dict[str, tuple[str, type[Peer]]]] = {
    "jupedsim SFM": ("jupedsim", JuPedSimSocialForce),
    "jupedsim CFSM": ("jupedsim", JuPedSimCollisionFreeSpeed),
    "pyrvo ORCA": ("pyrvo", Pyrvo),
    "pysocialforce": ("pysocialforce", PySocialForce),
}
"""By name: the package that it needs, and the simulator."""


def installed_version(name: str) -> str | None:
    """Version of a peer; None if its package is not installed."""
    package, _ = PEERS[name]
    return None if find_spec(package) is None else version(package)


def _turn_round(arrived: NDArray[np.bool_], goal: FloatArray, other: FloatArray) -> None:
    """Swap both ends of the way of those who arrived."""
    if arrived.any():
        goal[arrived], other[arrived] = other[arrived], goal[arrived]


@contextlib.contextmanager
def _scratch_folder() -> Iterator[Path]:
    """Work in a folder that vanishes: PySocialForce opens a log file wherever it is imported."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        yield Path(folder)


@contextlib.contextmanager
def _own_logging() -> Iterator[None]:
    """Undo what PySocialForce does to everybody's logging when it is imported."""
    root = logging.getLogger()
    level, handlers = root.level, list(root.handlers)
    try:
        yield
    finally:
        root.setLevel(level)
        for handler in set(root.handlers) - set(handlers):
            root.removeHandler(handler)
            handler.close()
