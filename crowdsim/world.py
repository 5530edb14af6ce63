"""The running physics of one scenario: `World.step` is the simulator's main loop.

What a step consists of is in `crowdsim.dynamics`.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from crowdsim.behaviour import Distractions
from crowdsim.bodies import SKIN, Bodies
from crowdsim.dynamics import Dynamics
from crowdsim.forces import SocialForce
from crowdsim.headed import HeadedSocialForce
from crowdsim.mixed_crowd import MixedCrowd
from crowdsim.orca import Orca
from crowdsim.passage import Passage
from crowdsim.playback import Playback
from crowdsim.robot_body import RobotBody, wanted_velocity
from crowdsim.routes import Routes, park
from crowdsim.snapshot import Snapshot, Stateful, fingerprint
from crowdsim.starts import draw_awareness, planned_routes, starting_bodies

if TYPE_CHECKING:
    from crowdsim.scenario import Scenario

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

CONTACT_GAP = 2 * SKIN + 0.005
"""Surfaces this near count as touching: their skins have met, give or take a rebound [m]."""

DEFAULT_SOCIAL_FORCE = SocialForce()
DEFAULT_HEADED_SOCIAL_FORCE = HeadedSocialForce()
DEFAULT_ORCA = Orca()


class World:
    """A crowd, and perhaps a robot, moving on a map.

    The same scenario, generator state and commands give the same bits, in any process on the same
    machine architecture. All arrays that it gives out are fresh copies.

    Attributes:
        scenario: what the world started from.
        physics_dt: seconds per step.
        step_count: steps so far.
        robot_contact: whether the robot touches a pedestrian after the last step.
        robot_wall_contact: whether it touches a wall.
        robot_clearance: gap to the nearest pedestrian [m], inf without any, < 0 when overlapping.
        robot_wall_clearance: gap to the nearest wall's surface [m], likewise.
        held_count: how often somebody had to be held back from crossing a wall.
    """

    STATE: ClassVar[tuple[str, ...]] = (
        "step_count",
        "held_count",
        "_rng",
        "_bodies",
        "_present",
        "_ids",
        "_direction",
    )

    # Attributes that hold the other parts with a state; None where a world has no such part.
    _PARTS: ClassVar[tuple[str, ...]] = ("_guide", "_crowd", "_distractions")

    def __init__(
        self,
        scenario: Scenario,
        *,
        rng: np.random.Generator,
        social_force: SocialForce = DEFAULT_SOCIAL_FORCE,
        headed_social_force: HeadedSocialForce = DEFAULT_HEADED_SOCIAL_FORCE,
        orca: Orca = DEFAULT_ORCA,
        physics_dt: float = 0.05,
        robot: RobotBody | None = None,
        former: World | None = None,
    ) -> None:
        """Place everybody at the start.

        Args:
            scenario: initial conditions; its recording, if any, drives the pedestrians.
            rng: source of the people's whims, of who notices the robot, and of distractions.
            social_force: parameters of the forces between people.
            headed_social_force: what headed people add to them.
            orca: parameters of those who move by ORCA.
            physics_dt: seconds per step.
            robot: the robot's body; None for a world without a robot.
            former: a world that will not move any more. One with as many bodies on the same map
                leaves its contact solver to this one, which then starts sooner, with the same bits.

        Raises:
            ValueError: if two bodies start inside each other, or `physics_dt` is not positive or
                does not divide a recording's time step.
        """
        if not (math.isfinite(physics_dt) and physics_dt > 0):
            raise ValueError(f"physics_dt: expected > 0 s, found {physics_dt}")
        pedestrians = scenario.pedestrians
        self.scenario = scenario
        self.physics_dt = float(physics_dt)
        self.step_count = 0
        self.held_count = 0
        self._rng = rng
        # Streams of their own: the whims depend neither on who is aware nor on distractions.
        awareness_rng, behaviour_rng = rng.spawn(2)
        self._robot = robot
        self._models = (social_force, headed_social_force, orca)
        bodies, radius, mass, present = starting_bodies(scenario, robot)
        self._bodies, self._radius, self._present = bodies, radius, present
        self._count = len(pedestrians)
        self._ids: IntArray = np.arange(self._count)
        self._direction: FloatArray = np.zeros((len(bodies), 2))
        self._solid = Bodies(
            radius=radius,
            mass=mass,
            dynamic_from=0 if scenario.replay is None else self._count,
            world_map=scenario.map,
            dt=self.physics_dt,
        )
        if former is not None:
            self._solid.inherit(former._solid)
        self._crowd = MixedCrowd(
            pedestrians,
            notices_robot=draw_awareness(awareness_rng, pedestrians, robot),
            world_map=scenario.map,
            social_force=social_force,
            headed_social_force=headed_social_force,
            orca=orca,
            dt=self.physics_dt,
        )
        self._distractions = None
        if scenario.behaviour is not None:
            self._distractions = Distractions(
                scenario.behaviour, pedestrians.group, rng=behaviour_rng, dt=self.physics_dt
            )
        self._guide: Routes | Playback
        if scenario.replay is None:
            self._guide = planned_routes(scenario, self.physics_dt)
        else:
            self._ids[:] = scenario.replay.ids
            self._guide = Playback(scenario.replay, scenario.replay_start, physics_dt)
            self._guide.place(0, self._bodies, self._present)
        self._look_at_state()

    def step(self, robot_velocity: Sequence[float] | FloatArray | None = None) -> None:
        """Move everybody on by `physics_dt`.

        Args:
            robot_velocity: `(2,)` velocity that the robot wants, world frame [m/s]; it gets as
                near as its acceleration and contacts let it. None is standing still.

        Raises:
            ValueError: if the velocity is not two finite numbers, or there is no robot to move.
        """
        if self._robot is None and robot_velocity is not None:
            raise ValueError("robot_velocity: expected None, for this world has no robot")
        self._run(np.array([wanted_velocity(robot_velocity)]))

    def run(self, robot_velocities: FloatArray) -> Passage:
        """Make as many steps as there are velocities; the same as `step` with one after another.

        Args:
            robot_velocities: `(S, 2)` that the robot wants, world frame [m/s].

        Raises:
            ValueError: if they are not pairs of finite numbers, or there is no robot to move.
        """
        self._robot_row()
        if robot_velocities.shape[1:] != (2,) or not np.isfinite(robot_velocities).all():
            raise ValueError(
                f"robot_velocities: expected (S, 2) finite numbers, found {robot_velocities}"
            )
        return self._run(robot_velocities)

    def snapshot(self) -> Snapshot:
        """Take down the state, random generator included; the world's future does not change."""
        return Snapshot.of(self._parts(), origin=self._origin)

    def restore(self, snapshot: Snapshot) -> None:
        """Go back, or over, to a state; from there on, the same commands give the same bits.

        The random generator becomes a copy of the saved one; the one that was handed in at the
        start is no longer used.

        Args:
            snapshot: of this world, or of one that was built from the same arguments (whatever
                the generator), be it in another process.

        Raises:
            ValueError: if it is of a world that was built from something else; then nothing has
                changed.
        """
        snapshot.put(self._parts(), origin=self._origin)
        self._look_at_state()

    def fork(self) -> World:
        """Build a second world in the same state; neither knows of the other."""
        twin = copy.copy(self)
        for name in self._PARTS:
            setattr(twin, name, copy.copy(getattr(self, name)))
        twin._solid = self._solid.another()
        twin.restore(self.snapshot())
        return twin

    def without_robot(self) -> World:
        """Fork this world and take the robot out of the fork, where nobody meets it any more.

        Raises:
            ValueError: if there is no robot.
        """
        self._robot_row()
        twin = self.fork()
        robot = self._count
        twin._present[robot] = False
        park(twin._bodies, robot)
        twin._look_at_state()
        return twin

    @property
    def time(self) -> float:
        """Seconds since the start."""
        return self.step_count * self.physics_dt

    @property
    def positions(self) -> FloatArray:
        """Of the pedestrians `(N, 2)` [m]; far away where not `valid`."""
        return self._people[0].copy()

    @property
    def velocities(self) -> FloatArray:
        """Of the pedestrians `(N, 2)` [m/s]; 0 where not `valid`."""
        return self._people[1].copy()

    @property
    def valid(self) -> BoolArray:
        """Which pedestrians are there `(N,)`."""
        return self._present[: self._count].copy()

    @property
    def ids(self) -> IntArray:
        """Who the pedestrians are `(N,)`; somebody who enters anew has a new id."""
        return self._ids.copy()

    @property
    def radius(self) -> FloatArray:
        """Of the pedestrians `(N,)` [m]."""
        return self._radius[: self._count].copy()

    @property
    def desired_speed(self) -> FloatArray:
        """Of the pedestrians `(N,)` [m/s]."""
        return self.scenario.pedestrians.desired_speed.copy()

    @property
    def goals(self) -> FloatArray:
        """Waypoints `(N, 2)` being walked to now, or where recorded people end [m]."""
        return self._guide.goals

    @property
    def robot_position(self) -> FloatArray:
        """`(2,)` [m].

        Raises:
            ValueError: if there is no robot.
        """
        return self._robot_row()[:2].copy()

    @property
    def robot_velocity(self) -> FloatArray:
        """`(2,)` [m/s], after the contacts of the last step.

        Raises:
            ValueError: if there is no robot.
        """
        return self._robot_row()[2:].copy()

    def robot_social_forces(self) -> tuple[FloatArray, FloatArray]:
        """Repulsion that the robot feels, were it a pedestrian, and the one that it causes.

        Everybody is taken to notice it whom no wall hides: this measures nearness, not motion.

        Returns:
            on_robot: `(2,)` sum over the pedestrians [m/s^2].
            on_pedestrians: `(N, 2)` [m/s^2], 0 where not `valid`.

        Raises:
            ValueError: if there is no robot.
        """
        velocity = self._robot_row()[2:]
        speed = np.hypot(*velocity)
        self._direction[-1] = velocity / speed if speed > 0 else 0.0
        total = self._crowd.robot_repulsion(
            self._bodies, self._present, self._radius, self._direction
        )
        return total[-1], total[:-1]

    def _parts(self) -> dict[str, Stateful]:
        parts = {"world": self, **{name: getattr(self, name) for name in self._PARTS}}
        return {name: part for name, part in parts.items() if part is not None}

    @cached_property
    def _origin(self) -> dict[str, str]:
        return {
            "physics_dt": repr(self.physics_dt),
            "robot": repr(self._robot),
            "models": repr(self._models),
            "scenario": f"{self.scenario.name} {fingerprint(self.scenario)}",
        }

    def _robot_row(self) -> FloatArray:
        if self._robot is None:
            raise ValueError("this world has no robot: build it with robot=RobotBody(...)")
        row: FloatArray = self._bodies[-1]
        return row

    def _run(self, commands: FloatArray) -> Passage:
        passage, held = self._dynamics.run(commands, self._rng, self.step_count)
        self.step_count += len(commands)
        self.held_count += held
        self._take(*passage.clearances[-1].tolist())
        return passage

    def _look_at_state(self) -> None:
        """Look at the arrays of the state, which `restore` has replaced."""
        people = self._bodies[: self._count]
        self._people: tuple[FloatArray, FloatArray] = people[:, :2], people[:, 2:]
        self._dynamics = Dynamics(
            bodies=self._bodies,
            present=self._present,
            direction=self._direction,
            ids=self._ids,
            radius=self._radius,
            walls=self.scenario.map.segments,
            robot=self._robot,
            guide=self._guide,
            crowd=self._crowd,
            distractions=self._distractions,
            solid=self._solid,
            dt=self.physics_dt,
        )
        self._take(*self._dynamics.clearances())

    def _take(self, clearance: float, wall_clearance: float) -> None:
        self.robot_clearance, self.robot_wall_clearance = clearance, wall_clearance
        self.robot_contact = clearance <= CONTACT_GAP
        self.robot_wall_contact = wall_clearance <= CONTACT_GAP
