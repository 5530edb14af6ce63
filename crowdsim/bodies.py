"""Solid bodies and walls in a pymunk space, read and written in batches."""

import numpy as np
import pymunk
import pymunk.batch
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

WALL_RADIUS = 0.05
"""Half the thickness of walls [m]."""

OVERLAP_TOLERANCE = 0.005
"""Overlap that the solver leaves alone, so that contacts do not flicker [m]."""

OVERLAP_LEFT_PER_SOLVER_STEP = 0.5
"""Share of an overlap that is still there after one solver step."""

SOLVER_STEPS = 2
"""Solver steps per physics step; they halve the overlap in dense crowds."""

_FIELDS = pymunk.batch.BodyFields.POSITION | pymunk.batch.BodyFields.VELOCITY


class Bodies:
    """A fixed pool of round bodies among walls; they never rotate, are never added or removed.

    pymunk keeps body order only as long as nothing is removed, so absent people stay in the pool,
    far away.
    """

    def __init__(
        self,
        *,
        radius: FloatArray,
        mass: FloatArray,
        kinematic: BoolArray,
        walls: FloatArray,
        dt: float,
    ) -> None:
        """Build the space.

        Args:
            radius: `(M,)` [m].
            mass: `(M,)` [kg].
            kinematic: `(M,)` bodies that go where they are told and cannot be pushed.
            walls: `(S, 2, 2)` segments [m].
            dt: seconds per step.
        """
        self._solver_dt = dt / SOLVER_STEPS
        self._space = pymunk.Space()
        self._space.collision_slop = OVERLAP_TOLERANCE
        self._space.collision_bias = OVERLAP_LEFT_PER_SOLVER_STEP ** (1 / self._solver_dt)
        for body_radius, body_mass, told in zip(radius, mass, kinematic, strict=True):
            self._add(float(body_radius), float(body_mass), bool(told))
        ground = self._space.static_body
        for start, end in walls.tolist():
            self._space.add(pymunk.Segment(ground, start, end, WALL_RADIUS))
        # The last row is pymunk's static body, to which the walls belong: it stays at zero.
        self._written: FloatArray = np.zeros((len(radius) + 1, 4))
        self._write_buffer, self._read_buffer = pymunk.batch.Buffer(), pymunk.batch.Buffer()
        self._write_buffer.set_float_buf(self._written)
        pymunk.batch.get_space_bodies(self._space, _FIELDS, self._read_buffer)
        # The pool never grows, so pymunk's memory behind this view never moves.
        self._read: FloatArray = np.frombuffer(self._read_buffer.float_buf()).reshape(-1, 4)

    def step(self, bodies: FloatArray) -> FloatArray:
        """Move bodies `(M, 4)` (x, y, vx, vy) on by one step, and let contacts push back.

        Returns:
            `(M, 4)` where they are then and how fast; a view that the next step overwrites.
        """
        self._written[:-1] = bodies
        pymunk.batch.set_space_bodies(self._space, _FIELDS, self._write_buffer)
        for _ in range(SOLVER_STEPS):
            self._space.step(self._solver_dt)
        self._read_buffer.clear()
        pymunk.batch.get_space_bodies(self._space, _FIELDS, self._read_buffer)
        return self._read[:-1]

    def _add(self, radius: float, mass: float, kinematic: bool) -> None:
        if kinematic:
            body = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        else:
            body = pymunk.Body(mass, float("inf"))
        # Chipmunk never forgives two bodies at one place, not even before the first step.
        body.position = (1e6 + 10.0 * len(self._space.bodies), 1e6)
        self._space.add(body, pymunk.Circle(body, radius))
