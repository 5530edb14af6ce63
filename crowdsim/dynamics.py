"""How the bodies of a world move: what `World.step` and `World.run` do, step by step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crowdsim.behaviour import Distractions
from crowdsim.bodies import Bodies
from crowdsim.contacts import keep_outside_walls, robot_clearances
from crowdsim.free_steps import free_steps
from crowdsim.mixed_crowd import MixedCrowd, accelerate
from crowdsim.passage import Passage
from crowdsim.playback import Playback
from crowdsim.robot_body import RobotBody, follow
from crowdsim.routes import Routes

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class Dynamics:
    """N pedestrians, and perhaps a robot in the last of the M rows; no state besides its parts'.

    A step changes the velocities to what everybody wants, moves everybody straight on, or lets the
    contact solver do so where somebody touches anything, and sends on who has arrived. Where people
    have nothing on their minds but their ways and each other, one call of a kernel (`free_steps`)
    makes all steps up to one that needs the solver; else each step is made of several calls.

    Attributes:
        bodies: `(M, 4)` x, y, vx, vy; changed in place, as are the next four.
        present: `(M,)` who is there.
        direction: `(M, 2)` where they want to go.
        ids: `(N,)` who they are.
        radius: `(M,)` [m].
        walls: `(K, 2, 2)` segments [m].
        robot: what drives the last row; None without a robot.
        guide: leads the pedestrians.
        crowd: how they avoid each other.
        distractions: what else they do, if anything.
        solid: moves them.
        dt: length of a step [s].
    """

    bodies: FloatArray
    present: BoolArray
    direction: FloatArray
    ids: IntArray
    radius: FloatArray
    walls: FloatArray
    robot: RobotBody | None
    guide: Routes | Playback
    crowd: MixedCrowd
    distractions: Distractions | None
    solid: Bodies
    dt: float

    def run(
        self, commands: FloatArray, rng: np.random.Generator, steps_before: int
    ) -> tuple[Passage, int]:
        """Make a step per command.

        Args:
            commands: `(S, 2)` velocities that the robot wants [m/s].
            rng: source of people's whims.
            steps_before: steps of the world so far.

        Returns:
            What happened, and how often somebody had to be held back from crossing a wall.
        """
        passage = Passage.of(len(commands), len(self.bodies))
        advance = self._free_steps if self._is_free else self._steps_by_parts
        noise = self._noise(len(commands), rng)
        step, held = advance(0, steps_before, commands, noise, passage), 0
        while step < len(commands):
            moved = self.solid.solve(self.bodies)
            first, screens = self.solid.dynamic_from, self.crowd.screens
            held += keep_outside_walls(self.bodies, moved, first, screens)
            self._end_step(step, steps_before, passage)
            step = advance(step + 1, steps_before, commands, noise, passage)
        return passage, held

    def clearances(self) -> tuple[float, float]:
        """Gaps between the robot and the nearest pedestrian, and wall [m]; infinite without."""
        if self.robot is None:
            return math.inf, math.inf
        gaps: tuple[float, float] = robot_clearances(
            self.bodies, self.radius, self.present, self.walls
        )
        return gaps

    def _noise(self, steps: int, rng: np.random.Generator) -> FloatArray:
        """Draws `(S, N, 2)`; none for recorded people, who have no whims."""
        people = len(self.ids) if isinstance(self.guide, Routes) else 0
        return rng.standard_normal((steps, people, 2))

    @cached_property
    def _is_free(self) -> bool:
        is_led = isinstance(self.guide, Routes)
        return is_led and self.distractions is None and self.crowd.is_plain

    @cached_property
    def _felt(self) -> int:
        """How many rows the forces look at."""
        robot_is_felt = self.robot is not None and self.crowd.notices_robot.any()
        return len(self.ids) + int(robot_is_felt)

    @cached_property
    def _unchanging(self) -> tuple[Any, ...]:
        """What `free_steps` takes besides what is new in each run."""
        assert isinstance(self.guide, Routes)
        return (
            self.robot is not None,
            self._robot_change,
            self.dt,
            self.bodies,
            self.present,
            self.radius,
            self.direction,
            self.ids,
            self._felt,
            self.walls,
            *self.crowd.social_force_arguments,
            *self.guide.arrays,
            *self.solid.coasting,
        )

    @property
    def _robot_change(self) -> float:
        """Most that the robot's velocity changes in a step [m/s]."""
        return 0.0 if self.robot is None else self.robot.max_acceleration * self.dt

    def _free_steps(
        self,
        first: int,
        steps_before: int,
        commands: FloatArray,
        noise: FloatArray,
        passage: Passage,
    ) -> int:
        """Make steps from number `first` on; returns the one that needs the solver, or S."""
        guide = self.guide
        assert isinstance(guide, Routes)
        step, guide.next_id = free_steps(
            first,
            steps_before,
            guide.next_id,
            commands,
            noise,
            passage.states,
            passage.clearances,
            *self._unchanging,
        )
        return int(step)

    def _steps_by_parts(
        self,
        first: int,
        steps_before: int,
        commands: FloatArray,
        noise: FloatArray,
        passage: Passage,
    ) -> int:
        """Do the same in more calls."""
        if first == 0:
            passage.note(0, self.bodies, self.clearances())
        for step in range(first, len(commands)):
            if self.robot is not None:
                vx, vy = commands[step]
                follow(self.bodies[-1], vx, vy, self._robot_change)
            if isinstance(self.guide, Routes):
                self._walk(self.guide, noise[step])
            if not self.solid.coast(self.bodies, self.present):
                return step
            self._end_step(step, steps_before, passage)
        return len(commands)

    def _walk(self, routes: Routes, noise: FloatArray) -> None:
        """Change people's velocities as they want to."""
        bodies, present, direction = self.bodies, self.present, self.direction
        routes.steer(bodies, self.crowd.desired_speed, direction)
        if self.distractions is not None:
            self.distractions.distract(routes, bodies, present, direction)
        felt = slice(self._felt)
        acceleration = self.crowd.accelerations(
            bodies[felt], present[felt], self.radius[felt], direction[felt], noise
        )
        accelerate(bodies, acceleration, self.crowd.max_speed, self.dt)

    def _end_step(self, step: int, steps_before: int, passage: Passage) -> None:
        """Let people arrive, and take down what the step of that number in the run led to."""
        count, guide = steps_before + step + 1, self.guide
        if isinstance(guide, Routes):
            guide.advance(count, self.bodies, self.radius, self.present, self.ids)
        else:
            guide.place(count, self.bodies, self.present)
        passage.note(step + 1, self.bodies, self.clearances())
