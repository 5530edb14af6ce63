"""How everybody in a crowd accelerates, each by a model of motion of their own."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.distance_field import distance_field
from crowdsim.forces import SocialForce, accelerations, goal_drive, robot_repulsion
from crowdsim.groups import add_group_forces
from crowdsim.headed import HeadedSocialForce, walk_ahead
from crowdsim.line_of_sight import screens
from crowdsim.map import Map
from crowdsim.motion import MotionModel
from crowdsim.orca import Orca, avoid
from crowdsim.pedestrians import ALONE, Pedestrians

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

LEAST_MAX_SPEED = 0.6
"""People who want to stand can still step aside this fast [m/s]."""

LONGEST_STEP = 1.0
"""Nobody moves farther than this in one step [m]."""


class MixedCrowd:
    """The social force for all, and what replaces it for those who move by another model.

    Everybody sees everybody, whatever their models.

    Attributes:
        desired_speed: `(N,)` [m/s].
        max_speed: `(N,)` [m/s].
        notices_robot: `(N,)` who is aware of the robot.
        screens: the walls that may stand between people.
        turning: `(N, 2)` heading [rad] and its rate [rad/s] of headed people, the only state that
            a step leaves to the next; NaN for everybody else and for who is not there.
    """

    STATE: ClassVar[tuple[str, ...]] = ("turning", "notices_robot")

    def __init__(
        self,
        pedestrians: Pedestrians,
        *,
        notices_robot: BoolArray,
        world_map: Map,
        social_force: SocialForce,
        headed_social_force: HeadedSocialForce,
        orca: Orca,
        dt: float,
    ) -> None:
        """Sort the pedestrians by model.

        Args:
            pedestrians: who moves, and by which model.
            notices_robot: `(N,)` who is aware of the robot.
            world_map: whose walls are felt, and hide people.
            social_force: parameters of the forces between people.
            headed_social_force: what headed people add to them.
            orca: parameters of those who move by ORCA.
            dt: length of a step [s].
        """
        model = pedestrians.model
        self._headed: IntArray = np.flatnonzero(model == MotionModel.HEADED_SOCIAL_FORCE)
        self._orca: BoolArray = model == MotionModel.ORCA
        self._unyielding: IntArray = np.flatnonzero(model == MotionModel.CONSTANT_VELOCITY)
        # One row more: a robot, too, is taken to do its half.
        self._gives_way: BoolArray = np.append(model != MotionModel.CONSTANT_VELOCITY, [True])
        self._any_orca = bool(self._orca.any())
        self._has_groups = bool((pedestrians.group != ALONE).any())
        self._people = pedestrians
        self._walls = world_map.segments
        self._wall_field = distance_field(world_map)
        ranges = [LONGEST_STEP, social_force.interaction_range]
        ranges += [orca.interaction_range] if self._any_orca else []
        self.screens = screens(world_map, max(ranges))
        self._social_force_parameters = social_force.record()
        self._headed_parameters = headed_social_force.record()
        self._orca_parameters = orca.record()
        self._dt = dt
        self.desired_speed = pedestrians.desired_speed
        self.max_speed: FloatArray = np.maximum(
            social_force.max_speed_ratio * pedestrians.desired_speed, LEAST_MAX_SPEED
        )
        self.notices_robot = notices_robot
        self.turning: FloatArray = np.full((len(pedestrians), 2), np.nan)

    @property
    def is_plain(self) -> bool:
        """Whether everybody moves by the social force, alone."""
        others = len(self._headed) + len(self._unyielding)
        return not (others or self._any_orca or self._has_groups)

    @property
    def social_force_arguments(self) -> tuple[Any, ...]:
        """What `forces.accelerations` and `accelerate` have to know, as `free_steps` takes it."""
        return (
            self.desired_speed,
            self._people.relaxation_time,
            self.max_speed,
            self.notices_robot,
            self._wall_field.grid,
            self._wall_field.origin,
            self._wall_field.cell,
            self.screens,
            self._social_force_parameters,
        )

    def accelerations(
        self,
        bodies: FloatArray,
        present: BoolArray,
        radius: FloatArray,
        direction: FloatArray,
        noise: FloatArray,
    ) -> FloatArray:
        """Accelerations `(M, 2)` [m/s^2], computed from one snapshot.

        Args:
            bodies: `(M, 4)` x, y, vx, vy; the N pedestrians first, then perhaps the robot.
            present: `(M,)` who is there.
            radius: `(M,)` [m].
            direction: `(M, 2)` wanted direction, shorter than 1 for who wants to be slow.
            noise: `(N, 2)` standard normal draws for this step.
        """
        people = self._people
        desired_speed, relaxation_time, _, notices_robot, *ground = self.social_force_arguments
        acceleration = accelerations(
            bodies,
            present,
            radius,
            direction,
            desired_speed,
            relaxation_time,
            notices_robot,
            noise,
            self._dt,
            *ground,
        )
        if self._has_groups:
            add_group_forces(bodies, present, direction, people.group, acceleration)
        if len(self._headed):
            walk_ahead(
                self._headed,
                bodies,
                present,
                direction,
                people.desired_speed,
                people.relaxation_time,
                people.mass,
                self._dt,
                self._headed_parameters,
                self.turning,
                acceleration,
            )
        if self._any_orca:
            self._avoid(bodies, present, radius, direction, noise, acceleration)
        if len(self._unyielding):
            walk_on(
                self._unyielding,
                bodies,
                direction,
                people.desired_speed,
                people.relaxation_time,
                acceleration,
            )
        return acceleration

    def robot_repulsion(
        self, bodies: FloatArray, present: BoolArray, radius: FloatArray, direction: FloatArray
    ) -> FloatArray:
        """Social forces `(M, 2)` [m/s^2] between the robot, the last row, and each other body.

        Everybody is taken to notice it whom no wall hides; the last row is what it feels itself.
        """
        return robot_repulsion(
            bodies,
            present,
            radius,
            direction,
            self._wall_field.grid,
            self._wall_field.origin,
            self._wall_field.cell,
            self.screens,
            self._social_force_parameters,
        )

    def _avoid(
        self,
        bodies: FloatArray,
        present: BoolArray,
        radius: FloatArray,
        direction: FloatArray,
        noise: FloatArray,
        acceleration: FloatArray,
    ) -> None:
        avoid(
            self._gives_way,
            self._orca,
            self.notices_robot,
            bodies,
            present,
            radius,
            direction,
            self._people.desired_speed,
            self.max_speed,
            noise,
            self._dt,
            self._walls,
            self._wall_field.grid,
            self._wall_field.origin,
            self._wall_field.cell,
            self.screens,
            self._orca_parameters,
            acceleration,
        )


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
def walk_on(
    members: IntArray,
    bodies: FloatArray,
    direction: FloatArray,
    desired_speed: FloatArray,
    relaxation_time: FloatArray,
    acceleration: FloatArray,
) -> None:
    """Leave the members nothing but their goal drive: they keep their velocity until the waypoint.

    Args:
        members: `(C,)` who moves by constant velocity.
        bodies: `(M, 4)` x, y, vx, vy.
        direction: `(M, 2)` wanted direction.
        desired_speed: `(N,)` [m/s].
        relaxation_time: `(N,)` time in which the velocity is taken up again after a contact [s].
        acceleration: `(M, 2)` [m/s^2], changed in place.
    """
    for i in members:
        for axis in range(2):
            acceleration[i, axis] = goal_drive(
                desired_speed[i], direction[i, axis], bodies[i, 2 + axis], relaxation_time[i]
            )
