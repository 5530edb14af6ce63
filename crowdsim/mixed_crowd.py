"""Those of a crowd whose motion is not the plain social force."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.distance_field import DistanceField
from crowdsim.forces import goal_drive
from crowdsim.headed import HeadedSocialForce, walk_ahead
from crowdsim.motion import MotionModel
from crowdsim.orca import Orca, avoid
from crowdsim.pedestrians import Pedestrians

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


class MixedCrowd:
    """Replaces the social-force accelerations of those who move by another model.

    Everybody sees everybody, whatever their models.

    Attributes:
        turning: `(N, 2)` heading [rad] and its rate [rad/s] of headed people, the only state that
            a step leaves to the next; NaN for everybody else and for who is not there.
    """

    STATE: ClassVar[tuple[str, ...]] = ("turning", "_notices_robot")

    def __init__(
        self,
        pedestrians: Pedestrians,
        *,
        notices_robot: BoolArray,
        max_speed: FloatArray,
        walls: FloatArray,
        wall_field: DistanceField,
        headed_social_force: HeadedSocialForce,
        orca: Orca,
        dt: float,
    ) -> None:
        """Sort the pedestrians by model.

        Args:
            pedestrians: who moves, and by which model.
            notices_robot: `(N,)` who is aware of the robot.
            max_speed: `(N,)` [m/s].
            walls: `(S, 2, 2)` segments [m].
            wall_field: their distances.
            headed_social_force: parameters of that model.
            orca: parameters of that model.
            dt: length of a step [s].
        """
        model = pedestrians.model
        self._headed: IntArray = np.flatnonzero(model == MotionModel.HEADED_SOCIAL_FORCE)
        self._orca: BoolArray = model == MotionModel.ORCA
        self._unyielding: IntArray = np.flatnonzero(model == MotionModel.CONSTANT_VELOCITY)
        # One row more: a robot, too, is taken to do its half.
        self._gives_way: BoolArray = np.append(model != MotionModel.CONSTANT_VELOCITY, [True])
        self._any_orca = bool(self._orca.any())
        self._people = pedestrians
        self._notices_robot = notices_robot
        self._max_speed = max_speed
        self._walls = walls
        self._wall_field = wall_field
        self._headed_parameters = headed_social_force.record()
        self._orca_parameters = orca.record()
        self._dt = dt
        self.turning: FloatArray = np.full((len(pedestrians), 2), np.nan)

    def replace(
        self,
        acceleration: FloatArray,
        bodies: FloatArray,
        present: BoolArray,
        radius: FloatArray,
        direction: FloatArray,
        noise: FloatArray,
    ) -> None:
        """Give the members of the other models their own accelerations.

        Args:
            acceleration: `(M, 2)` by the social force [m/s^2], changed in place.
            bodies: `(M, 4)` x, y, vx, vy; the N pedestrians first, then perhaps the robot.
            present: `(M,)` who is there.
            radius: `(M,)` [m].
            direction: `(M, 2)` wanted direction, shorter than 1 for who wants to be slow.
            noise: `(N, 2)` standard normal draws for this step.
        """
        people = self._people
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
            avoid(
                self._gives_way,
                self._orca,
                self._notices_robot,
                bodies,
                present,
                radius,
                direction,
                people.desired_speed,
                self._max_speed,
                noise,
                self._dt,
                self._walls,
                self._wall_field.grid,
                self._wall_field.origin,
                self._wall_field.cell,
                self._orca_parameters,
                acceleration,
            )
        if len(self._unyielding):
            walk_on(
                self._unyielding,
                bodies,
                direction,
                people.desired_speed,
                people.relaxation_time,
                acceleration,
            )


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
