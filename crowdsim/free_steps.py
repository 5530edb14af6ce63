"""Steps of people who move by the social force alone, as many in a row as need no contact solver.

The work of a step between two of Python's calls is some microseconds, and so is each call: what
can be done in one goes in one.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.coasting import coast
from crowdsim.contacts import robot_clearances
from crowdsim.forces import accelerations
from crowdsim.line_of_sight import Screens
from crowdsim.mixed_crowd import accelerate
from crowdsim.robot_body import follow
from crowdsim.routes import advance, steer
from crowdsim.wayfinding import AnchorArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


@njit(cache=True, error_model="numpy")
def free_steps(
    first: int,
    step_count: int,
    next_id: int,
    commands: FloatArray,
    noise: FloatArray,
    states: FloatArray,
    clearances: FloatArray,
    has_robot: bool,
    robot_change: float,
    dt: float,
    bodies: FloatArray,
    present: BoolArray,
    radius: FloatArray,
    direction: FloatArray,
    ids: IntArray,
    felt: int,
    walls: FloatArray,
    desired_speed: FloatArray,
    relaxation_time: FloatArray,
    max_speed: FloatArray,
    notices_robot: BoolArray,
    wall_grid: FloatArray,
    wall_origin: FloatArray,
    wall_cell: float,
    screens: Screens,
    model: NDArray[np.void],
    points: FloatArray,
    legs: IntArray,
    onward: IntArray,
    enters_at: IntArray,
    start_velocity: FloatArray,
    on_arrival: IntArray,
    fields: IntArray,
    anchors: AnchorArray,
    field_origin: FloatArray,
    is_sparse: bool,
    solver_radius: FloatArray,
    parts: FloatArray,
    wall_reach: float,
) -> tuple[int, int]:
    """Make steps from number `first` on, up to the first in which anybody touches anything.

    Of that one, velocities are new and places are not yet: the contact solver goes on from there.

    Args:
        first: which of the S steps of this run comes first.
        step_count: steps of the world before this run.
        next_id: what `Routes.advance` keeps.
        commands: `(S, 2)` velocities that the robot wants [m/s].
        noise: `(S, N, 2)` standard normal draws.
        states: `(S + 1, M, 4)` where bodies are written, as they are if `first` is 0, and after
            each step.
        clearances: `(S + 1, 2)` where those of the robot are written, as `robot_clearances` has
            them.
        has_robot: whether the last body is one.
        robot_change: most that its velocity changes in a step [m/s].
        dt: length of a step [s].
        bodies: `(M, 4)` x, y, vx, vy; as is who is there, changed in place.
        present: `(M,)` who is there.
        radius: `(M,)` [m].
        direction: `(M, 2)` wanted directions.
        ids: `(N,)` who the pedestrians are.
        felt: how many of the bodies the pedestrians feel.
        walls: `(K, 2, 2)` segments [m].
        desired_speed: as are all up to `model`, what `accelerations` and `accelerate` take.
        relaxation_time: likewise.
        max_speed: likewise.
        notices_robot: likewise.
        wall_grid: likewise.
        wall_origin: likewise.
        wall_cell: likewise.
        screens: likewise.
        model: likewise.
        points: as are all up to `field_origin`, what `steer` and `advance` take.
        legs: likewise.
        onward: likewise.
        enters_at: likewise.
        start_velocity: likewise.
        on_arrival: likewise.
        fields: likewise.
        anchors: likewise.
        field_origin: likewise.
        is_sparse: whether it is worth a look whether nobody touches anybody.
        solver_radius: as are the last three, what `coast` takes.
        parts: likewise.
        wall_reach: likewise.

    Returns:
        Number of the step that is left to the solver, S if all are made; and the next unused id.
    """
    if first == 0:
        _note(bodies, radius, present, walls, has_robot, states[0], clearances[0])
    for step in range(first, len(commands)):
        if has_robot:
            follow(bodies[-1], commands[step, 0], commands[step, 1], robot_change)
        steer(
            bodies,
            desired_speed,
            points,
            legs,
            fields,
            anchors,
            field_origin,
            on_arrival,
            direction,
        )
        acceleration = accelerations(
            bodies[:felt],
            present[:felt],
            radius[:felt],
            direction[:felt],
            desired_speed,
            relaxation_time,
            notices_robot,
            noise[step],
            dt,
            wall_grid,
            wall_origin,
            wall_cell,
            screens,
            model,
        )
        accelerate(bodies, acceleration, max_speed, dt)
        if not is_sparse or not coast(
            bodies, present, solver_radius, 0, parts, wall_reach, wall_grid, wall_origin, wall_cell
        ):
            return step, next_id
        next_id = advance(
            step_count + step + 1,
            bodies,
            radius,
            present,
            ids,
            next_id,
            points,
            legs,
            onward,
            enters_at,
            start_velocity,
            on_arrival,
        )
        _note(bodies, radius, present, walls, has_robot, states[step + 1], clearances[step + 1])
    return len(commands), next_id


@njit(cache=True, error_model="numpy")
def _note(
    bodies: FloatArray,
    radius: FloatArray,
    present: BoolArray,
    walls: FloatArray,
    has_robot: bool,
    state: FloatArray,
    clearance: FloatArray,
) -> None:
    state[:] = bodies
    clearance[:] = np.inf
    if has_robot:
        clearance[0], clearance[1] = robot_clearances(bodies, radius, present, walls)
