"""The running physics of one scenario: `World.step` is the simulator's main loop."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.bodies import WALL_RADIUS, Bodies
from crowdsim.contacts import keep_outside_walls, robot_clearances
from crowdsim.distance_field import distance_field
from crowdsim.forces import SocialForce, accelerations, robot_repulsion
from crowdsim.groups import add_group_forces
from crowdsim.headed import HeadedSocialForce
from crowdsim.mixed_crowd import MixedCrowd
from crowdsim.orca import Orca
from crowdsim.pedestrians import ALONE
from crowdsim.playback import Playback
from crowdsim.routes import Routes
from crowdsim.snapshot import Snapshot, Stateful

if TYPE_CHECKING:
    from crowdsim.pedestrians import Pedestrians
    from crowdsim.scenario import Scenario

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

CONTACT_GAP = 0.005
"""Surfaces this near count as touching [m]."""

LEAST_MAX_SPEED = 0.6
"""People who want to stand can still step aside this fast [m/s]."""

DEFAULT_SOCIAL_FORCE = SocialForce()
DEFAULT_HEADED_SOCIAL_FORCE = HeadedSocialForce()
DEFAULT_ORCA = Orca()


@dataclass(frozen=True, kw_only=True)
class RobotBody:
    """The robot as the crowd meets it.

    Attributes:
        radius: [m].
        mass: [kg].
        awareness: share of people who notice and feel it, 0 to 1; all bump into it either way.
        max_acceleration: how hard it drives itself towards the wanted velocity [m/s^2].
    """

    radius: float = 0.3
    mass: float = 50.0
    awareness: float = 1.0
    max_acceleration: float = 5.0

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ValueError: if a size is not positive and finite, or the awareness is no share.
        """
        if not 0 <= self.awareness <= 1:
            raise ValueError(f"robot awareness: expected 0 to 1, found {self.awareness}")
        for name in ("radius", "mass", "max_acceleration"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"robot {name}: expected a finite value > 0, found {value}")


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
        "_notices_robot",
    )

    # Attributes that hold the other parts with a state; None where a world has no such part.
    _PARTS: ClassVar[tuple[str, ...]] = ("_guide", "_mixed")

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
    ) -> None:
        """Place everybody at the start.

        Args:
            scenario: initial conditions; its recording, if any, drives the pedestrians.
            rng: source of the people's whims, and of who notices the robot.
            social_force: parameters of the forces between people.
            headed_social_force: what headed people add to them.
            orca: parameters of those who move by ORCA.
            physics_dt: seconds per step.
            robot: the robot's body; None for a world without a robot.

        Raises:
            ValueError: if two bodies start at the same place, or `physics_dt` is not positive or
                does not divide a recording's time step.
        """
        pedestrians = scenario.pedestrians
        self.scenario = scenario
        self.physics_dt = _checked_dt(physics_dt)
        self.step_count = 0
        self.held_count = 0
        self._rng = rng
        self._robot = robot
        self._model = social_force.record()
        self._walls = scenario.map.segments
        self._wall_field = distance_field(scenario.map)
        self._desired_speed = pedestrians.desired_speed.copy()
        self._relaxation_time = pedestrians.relaxation_time.copy()
        self._max_speed = np.maximum(
            social_force.max_speed_ratio * self._desired_speed, LEAST_MAX_SPEED
        )
        self._has_groups = bool((pedestrians.group != ALONE).any())
        self._notices_robot = self._draw_awareness(pedestrians)
        self._set_up_bodies(pedestrians)
        self._mixed = self._mix(pedestrians, headed_social_force, orca)
        self._guide: Routes | Playback
        if scenario.replay is None:
            self._guide = Routes(pedestrians, scenario.map, scenario.on_arrival, scenario.entrances)
        else:
            self._ids[:] = scenario.replay.ids
            self._guide = Playback(scenario.replay, scenario.replay_start, physics_dt)
            self._guide.place(0, self._bodies, self._present)
        self._measure_robot()

    def step(self, robot_velocity: Sequence[float] | FloatArray | None = None) -> None:
        """Move everybody on by `physics_dt`.

        Args:
            robot_velocity: `(2,)` velocity that the robot wants, world frame [m/s]; it gets as
                near as its acceleration and contacts let it. None is standing still.

        Raises:
            ValueError: if the velocity is not two finite numbers, or there is no robot to move.
        """
        guide = self._guide
        self._command_robot(robot_velocity)
        if isinstance(guide, Routes):
            self._choose_velocities(guide)
        moved = self._solid.step(self._bodies)
        self._take(moved)
        self.step_count += 1
        if isinstance(guide, Routes):
            guide.advance(self._bodies, self._radius, self._present, self._ids)
        else:
            guide.place(self.step_count, self._bodies, self._present)
        self._measure_robot()

    def snapshot(self) -> Snapshot:
        """Take down the state, random generator included; the world's future does not change."""
        return Snapshot.of(self._parts(), physics_dt=self.physics_dt)

    def restore(self, snapshot: Snapshot) -> None:
        """Go back, or over, to a state; from there on, the same commands give the same bits.

        The random generator becomes a copy of the saved one; the one that was handed in at the
        start is no longer used.

        Args:
            snapshot: of this world, or of one that was built from the same arguments (whatever
                the generator), be it in another process.

        Raises:
            ValueError: if it is of a world that was built from something else, as far as that
                shows; then nothing has changed.
        """
        snapshot.put(self._parts(), physics_dt=self.physics_dt)
        self._look_at_rows()
        self._measure_robot()

    def fork(self) -> World:
        """Build a second world in the same state; neither knows of the other."""
        twin = copy.copy(self)
        for name in self._PARTS:
            setattr(twin, name, copy.copy(getattr(self, name)))
        twin._solid = self._solid.another()
        twin.restore(self.snapshot())
        return twin

    @property
    def time(self) -> float:
        """Seconds since the start."""
        return self.step_count * self.physics_dt

    @property
    def positions(self) -> FloatArray:
        """Of the pedestrians `(N, 2)` [m]; far away where not `valid`."""
        return self._bodies[: self._count, :2].copy()

    @property
    def velocities(self) -> FloatArray:
        """Of the pedestrians `(N, 2)` [m/s]; 0 where not `valid`."""
        return self._bodies[: self._count, 2:].copy()

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
        return self._desired_speed.copy()

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
        total = robot_repulsion(
            self._bodies,
            self._present,
            self._radius,
            self._direction,
            self._wall_field.grid,
            self._wall_field.origin,
            self._wall_field.cell,
            self._model,
        )
        return total[-1], total[:-1]

    def _draw_awareness(self, pedestrians: Pedestrians) -> BoolArray:
        if self._robot is None:
            return pedestrians.notices_robot.copy()
        # A stream of its own: the whims do not depend on who is aware.
        (awareness_rng,) = self._rng.spawn(1)
        notices: BoolArray = awareness_rng.random(len(pedestrians)) < self._robot.awareness
        return notices & pedestrians.notices_robot

    def _mix(
        self, pedestrians: Pedestrians, headed_social_force: HeadedSocialForce, orca: Orca
    ) -> MixedCrowd | None:
        """Those who move by another model than the social force; None without any."""
        if not pedestrians.model.any():
            return None
        return MixedCrowd(
            pedestrians,
            notices_robot=self._notices_robot,
            max_speed=self._max_speed,
            walls=self._walls,
            wall_field=self._wall_field,
            headed_social_force=headed_social_force,
            orca=orca,
            dt=self.physics_dt,
        )

    def _set_up_bodies(self, pedestrians: Pedestrians) -> None:
        rows = [np.concatenate([pedestrians.position, pedestrians.velocity], axis=1)]
        radius, mass = [pedestrians.radius], [pedestrians.mass]
        if self._robot is not None:
            x, y, _ = self.scenario.robot_start
            rows.append(np.array([[x, y, 0.0, 0.0]]))
            radius.append(np.array([self._robot.radius]))
            mass.append(np.array([self._robot.mass]))
        self._bodies: FloatArray = np.concatenate(rows)  # (M, 4) x, y, vx, vy
        self._radius: FloatArray = np.concatenate(radius)
        self._count = len(pedestrians)
        self._present: BoolArray = np.ones(len(self._bodies), dtype=np.bool_)
        self._ids: IntArray = np.arange(self._count)
        self._direction: FloatArray = np.zeros((len(self._bodies), 2))
        replayed = self.scenario.replay is not None
        if not replayed:
            _refuse_shared_places(self._bodies)
        self._dynamic_from = self._count if replayed else 0
        self._solid = Bodies(
            radius=self._radius,
            mass=np.concatenate(mass),
            kinematic=np.arange(len(self._bodies)) < self._dynamic_from,
            walls=self._walls,
            dt=self.physics_dt,
        )
        self._look_at_rows()

    def _look_at_rows(self) -> None:
        # Forces look at these rows only.
        felt = slice(self._count + (self._robot is not None and self._notices_robot.any()))
        self._felt: tuple[FloatArray, BoolArray, FloatArray, FloatArray] = (
            self._bodies[felt],
            self._present[felt],
            self._radius[felt],
            self._direction[felt],
        )

    def _parts(self) -> dict[str, Stateful]:
        parts = {"world": self, **{name: getattr(self, name) for name in self._PARTS}}
        return {name: part for name, part in parts.items() if part is not None}

    def _robot_row(self) -> FloatArray:
        if self._robot is None:
            raise ValueError("this world has no robot: build it with robot=RobotBody(...)")
        row: FloatArray = self._bodies[-1]
        return row

    def _command_robot(self, velocity: Sequence[float] | FloatArray | None) -> None:
        if self._robot is None:
            if velocity is not None:
                raise ValueError("robot_velocity: expected None, for this world has no robot")
            return
        if velocity is None:
            velocity = (0.0, 0.0)
        if len(velocity) != 2:
            raise ValueError(f"robot_velocity: expected 2 numbers, found {len(velocity)}")
        vx, vy = float(velocity[0]), float(velocity[1])
        if not (math.isfinite(vx) and math.isfinite(vy)):
            raise ValueError(f"robot_velocity: expected finite numbers, found ({vx}, {vy})")
        follow(self._bodies[-1], vx, vy, self._robot.max_acceleration * self.physics_dt)

    def _choose_velocities(self, routes: Routes) -> None:
        """By the social force, or by the model of those who have another; from one snapshot."""
        routes.steer(self._bodies, self._desired_speed, self._direction)
        noise = self._rng.standard_normal((self._count, 2))
        acceleration = accelerations(
            *self._felt,
            self._desired_speed,
            self._relaxation_time,
            self._notices_robot,
            noise,
            self.physics_dt,
            self._wall_field.grid,
            self._wall_field.origin,
            self._wall_field.cell,
            self._model,
        )
        if self._has_groups:
            group = self.scenario.pedestrians.group
            add_group_forces(self._bodies, self._present, self._direction, group, acceleration)
        if self._mixed is not None:
            self._mixed.replace(acceleration, *self._felt, noise)
        accelerate(self._bodies, acceleration, self._max_speed, self.physics_dt)

    def _take(self, moved: FloatArray) -> None:
        self.held_count += keep_outside_walls(
            self._bodies,
            moved,
            self._dynamic_from,
            self._walls,
            self._wall_field.grid,
            self._wall_field.origin,
            self._wall_field.cell,
        )

    def _measure_robot(self) -> None:
        self.robot_clearance = self.robot_wall_clearance = math.inf
        if self._robot is not None:
            self.robot_clearance, wall_distance = robot_clearances(
                self._bodies, self._radius, self._present, self._walls
            )
            self.robot_wall_clearance = wall_distance - WALL_RADIUS
        self.robot_contact = self.robot_clearance <= CONTACT_GAP
        self.robot_wall_contact = self.robot_wall_clearance <= CONTACT_GAP


@njit(cache=True)
def accelerate(
    bodies: FloatArray, acceleration: FloatArray, max_speed: FloatArray, dt: float
) -> None:
    """Add `acceleration (M, 2)` to the pedestrians' velocities, up to `max_speed (N,)`."""
    for i in range(len(max_speed)):
        vx = bodies[i, 2] + acceleration[i, 0] * dt
        vy = bodies[i, 3] + acceleration[i, 1] * dt
        speed = math.hypot(vx, vy)
        scale = max_speed[i] / speed if speed > max_speed[i] else 1.0
        bodies[i, 2], bodies[i, 3] = vx * scale, vy * scale


@njit(cache=True)
def follow(body: FloatArray, vx: float, vy: float, max_change: float) -> None:
    """Bring the velocity of a body `(4,)` as near to (vx, vy) as `max_change` [m/s] allows.

    Setting it outright would undo what the contact solver did, and push the body through walls.
    """
    dx, dy = vx - body[2], vy - body[3]
    change = math.hypot(dx, dy)
    scale = max_change / change if change > max_change else 1.0
    body[2] += dx * scale
    body[3] += dy * scale


def _checked_dt(physics_dt: float) -> float:
    if not (math.isfinite(physics_dt) and physics_dt > 0):
        raise ValueError(f"physics_dt: expected > 0 s, found {physics_dt}")
    return float(physics_dt)


def _refuse_shared_places(bodies: FloatArray) -> None:
    places, counts = np.unique(bodies[:, :2], axis=0, return_counts=True)
    if (counts > 1).any():
        raise ValueError(
            f"expected everybody to start at a place of their own, found {counts.max()} bodies "
            f"at {tuple(places[counts.argmax()].tolist())}"
        )
