"""Solid bodies and walls in a pymunk space, read and written in batches.

Where the bodies are and how fast they move is all that a step hands to the next one. pymunk keeps
more than that, and so a space that was built anew would drift metres away from one that has been
running: impulses of the contacts that last, a velocity that undoes overlaps, and the shape of its
search tree, which decides in which order contacts are solved. Here the last part of each step moves
the bodies without looking at contacts, which uses that velocity up and drops the impulses; and a
spatial hash is filled anew in every step.
"""

from __future__ import annotations

import copy
from functools import cached_property

import numpy as np
import pymunk
import pymunk.batch
from numpy.typing import NDArray

from crowdsim.coasting import coast
from crowdsim.distance_field import distance_field
from crowdsim.map import Map

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

WALL_RADIUS = 0.05
"""Half the thickness of walls [m]."""

SKIN = 0.0025
"""Bodies and walls are thicker by this for the solver: what sinks in are skins, not bodies [m]."""

OVERLAP_TOLERANCE = 0.002
"""Overlap that the solver leaves alone, so that contacts do not flicker [m]."""

OVERLAP_LEFT = 0.1
"""Share of an overlap that is still there after the part of a step that follows its solution."""

SOLVED_PARTS = (0.4, 0.4)
"""Parts of a physics step, each of which ends with solving the contacts."""

FREE_PART = 0.2
"""The rest of it. More of it lets bodies sink into each other, less leaves old overlaps."""

CELL = 1.5
"""Edge of the spatial hash's cells [m]."""

CELLS_PER_BODY = 4
"""Size of its table."""

SPARSE = 150
"""In larger crowds somebody always touches somebody: nobody looks whether nobody does."""

_FIELDS = pymunk.batch.BodyFields.POSITION | pymunk.batch.BodyFields.VELOCITY


class Bodies:
    """A fixed pool of round bodies among walls; they never rotate, are never added or removed.

    Attributes:
        dynamic_from: rows before this one go where they are told and cannot be pushed.
    """

    def __init__(
        self,
        *,
        radius: FloatArray,
        mass: FloatArray,
        dynamic_from: int,
        world_map: Map,
        dt: float,
    ) -> None:
        """Take down who there is; the contact solver is built when it is first needed.

        Args:
            radius: `(M,)` [m].
            mass: `(M,)` [kg].
            dynamic_from: rows before this one go where they are told and cannot be pushed.
            world_map: whose walls stop them.
            dt: seconds per step.
        """
        self._mass, self.dynamic_from = mass, dynamic_from
        self._solver_radius: FloatArray = radius + SKIN
        self._wall_reach = WALL_RADIUS + SKIN
        self._walls, self._wall_field = world_map.segments, distance_field(world_map)
        self._parts: FloatArray = dt * np.array([*SOLVED_PARTS, FREE_PART])

    @property
    def coasting(self) -> tuple[bool, FloatArray, FloatArray, float]:
        """What `free_steps` takes: whether to look at all, radii, parts of a step, walls' reach."""
        is_sparse = len(self._mass) <= SPARSE
        return is_sparse, self._solver_radius, self._parts, self._wall_reach

    def coast(self, bodies: FloatArray, present: BoolArray) -> bool:
        """Move bodies on by one step if that needs no solver, for nobody touches anything.

        Args:
            bodies: `(M, 4)` x, y, vx, vy; then changed in place, but for kinematic ones.
            present: `(M,)` who is there; the others stand far from everybody.

        Returns:
            Whether they moved.
        """
        is_sparse, solver_radius, parts, wall_reach = self.coasting
        return is_sparse and coast(
            bodies,
            present,
            solver_radius,
            self.dynamic_from,
            parts,
            wall_reach,
            self._wall_field.grid,
            self._wall_field.origin,
            self._wall_field.cell,
        )

    def solve(self, bodies: FloatArray) -> FloatArray:
        """Move bodies `(M, 4)` on by one step, and let contacts push back.

        Returns:
            `(M, 4)` where they are then and how fast; a view that the next one overwrites.
        """
        return self._solver.solve(bodies)

    def inherit(self, former: Bodies) -> None:
        """Take over the contact solver of bodies that no longer move, if it fits.

        Nothing in it but sizes and masses outlasts a solution, and to set these takes a small part
        of the time of building another one.
        """
        fits = former._walls is self._walls and len(former._mass) == len(self._mass)
        alike = former.dynamic_from == self.dynamic_from and (former._parts == self._parts).all()
        solver = vars(former).pop("_solver", None)
        if solver is not None and fits and alike:
            solver.refit(self._solver_radius, self._mass)
            vars(self)["_solver"] = solver

    def another(self) -> Bodies:
        """Give the same bodies and walls, with a contact solver of their own."""
        twin = copy.copy(self)
        vars(twin).pop("_solver", None)
        return twin

    @cached_property
    def _solver(self) -> _ContactSolver:
        return _ContactSolver(
            self._solver_radius,
            self._mass,
            self.dynamic_from,
            self._walls,
            self._wall_reach,
            self._parts,
        )


class _ContactSolver:
    """Bodies and walls in pymunk.

    pymunk keeps body order only as long as nothing is removed, so absent people stay in the pool,
    far away.
    """

    def __init__(
        self,
        radius: FloatArray,
        mass: FloatArray,
        dynamic_from: int,
        walls: FloatArray,
        wall_reach: float,
        parts: FloatArray,
    ) -> None:
        *self._solved_dt, self._free_dt = parts.tolist()
        self._space = pymunk.Space()
        self._space.use_spatial_hash(CELL, CELLS_PER_BODY * len(radius) + 1)
        self._space.collision_slop = OVERLAP_TOLERANCE
        self._space.collision_bias = OVERLAP_LEFT ** (1 / self._solved_dt[-1])
        self._persistence = self._space.collision_persistence
        self._pool = [
            self._add(row, float(radius[row]), None if row < dynamic_from else float(mass[row]))
            for row in range(len(radius))
        ]
        ground = self._space.static_body
        self._space.add(*(pymunk.Segment(ground, a, b, wall_reach) for a, b in walls.tolist()))
        # The last row is pymunk's static body, to which the walls belong: it stays at zero.
        self._written: FloatArray = np.zeros((len(radius) + 1, 4))
        self._write_buffer, self._read_buffer = pymunk.batch.Buffer(), pymunk.batch.Buffer()
        self._write_buffer.set_float_buf(self._written)
        pymunk.batch.get_space_bodies(self._space, _FIELDS, self._read_buffer)
        # The pool never grows, so pymunk's memory behind this view never moves.
        self._read: FloatArray = np.frombuffer(self._read_buffer.float_buf()).reshape(-1, 4)

    def solve(self, bodies: FloatArray) -> FloatArray:
        """Do what `Bodies.solve` says."""
        self._written[:-1] = bodies
        pymunk.batch.set_space_bodies(self._space, _FIELDS, self._write_buffer)
        for part in self._solved_dt:
            self._space.step(part)
        self._space.collision_persistence = 0  # drops all contacts, those of this part included
        self._space.step(self._free_dt)
        self._space.collision_persistence = self._persistence
        self._read_buffer.clear()
        pymunk.batch.get_space_bodies(self._space, _FIELDS, self._read_buffer)
        return self._read[:-1]

    def refit(self, radius: FloatArray, mass: FloatArray) -> None:
        """Take other sizes `(M,)` [m] and masses `(M,)` [kg]; kinematic bodies have none."""
        for row, (body, circle) in enumerate(self._pool):
            circle.unsafe_set_radius(float(radius[row]))
            if body.body_type == pymunk.Body.DYNAMIC:
                body.mass = float(mass[row])

    def _add(
        self, row: int, radius: float, mass: float | None
    ) -> tuple[pymunk.Body, pymunk.Circle]:
        """Add a body and its circle; nothing can push it if it has no mass."""
        if mass is None:
            body = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        else:
            body = pymunk.Body(mass, float("inf"))
        # Chipmunk never forgives two bodies at one place, not even before the first step.
        body.position = (1e6 + 10.0 * row, 1e6)
        circle = pymunk.Circle(body, radius)
        self._space.add(body, circle)
        return body, circle
