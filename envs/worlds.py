"""W worlds side by side: their physics one by one, their state as arrays over W."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crowdsim.robot_body import RobotBody
from crowdsim.scenario import Scenario
from crowdsim.world import World
from envs.config import CrowdNavConfig
from envs.robots import Robot, RobotState
from envs.trace import CollisionRole

Floats = NDArray[np.float64]

FASTEST_APPROACH = 5.0
"""People and robot do not come near each other faster than this [m/s]."""


@dataclass(eq=False)
class Crowd:
    """Pedestrians of W worlds in N columns; a world with fewer leaves the last ones invalid.

    Attributes:
        position: (W, N, 2) [m], world frame. Meaningless where not valid.
        velocity: (W, N, 2) [m/s].
        valid: (W, N).
        ids: (W, N), -1 in columns that the world does not have.
        radius: (W, N) [m].
    """

    position: Floats
    velocity: Floats
    valid: NDArray[np.bool_]
    ids: NDArray[np.int64]
    radius: Floats

    @classmethod
    def empty(cls, worlds: int, columns: int) -> "Crowd":
        """Columns without anybody in them."""
        return cls(
            position=np.zeros((worlds, columns, 2)),
            velocity=np.zeros((worlds, columns, 2)),
            valid=np.zeros((worlds, columns), dtype=np.bool_),
            ids=np.full((worlds, columns), -1, dtype=np.int64),
            radius=np.zeros((worlds, columns)),
        )

    @property
    def columns(self) -> int:
        """Number of columns N."""
        return len(self.valid[0])

    def widened(self, columns: int) -> "Crowd":
        """Returns the same crowd with more columns."""
        wider = Crowd.empty(len(self.valid), columns)
        for name, values in vars(self).items():
            getattr(wider, name)[:, : self.columns] = values
        return wider

    def restart(self, world: int, source: World) -> None:
        """Takes the pedestrians of a world that has just been built."""
        self.valid[world] = False
        self.ids[world] = -1
        self.radius[world, : len(source.ids)] = source.radius
        self.read(world, source)

    def read(self, world: int, source: World) -> None:
        """Takes one world's pedestrians as they are now."""
        count = len(source.ids)
        self.position[world, :count] = source.positions
        self.velocity[world, :count] = source.velocities
        self.valid[world, :count] = source.valid
        self.ids[world, :count] = source.ids


class Worlds:
    """Runs the physics of W worlds for one policy period at a time and notes the contacts.

    Attributes:
        crowd: Pedestrians as they are now.
        robots: Robots as they are now.
        clearance_pedestrian: (W,) smallest clearance to a pedestrian during the last period [m],
            infinite where there is none.
        clearance_wall: (W,) likewise to walls and obstacles.
        touched_pedestrian: (W,), whether the robot touched a pedestrian during the last period.
        touched_wall: (W,) likewise for walls and obstacles.
        collision_role: Per world, who ran into whom in the first such contact; None without one.
        social_work: (W,) as in `envs.trace.Trace`; kept only with `record`, else 0.
    """

    def __init__(self, config: CrowdNavConfig, count: int, *, record: bool):
        self._config = config
        self._record = record
        self._body = RobotBody(
            radius=config.robot_radius,
            awareness=config.robot_awareness if config.robot_visible else 0.0,
            max_acceleration=config.max_acceleration,
        )
        self._in_reach = FASTEST_APPROACH * config.physics_dt
        self._worlds: dict[int, World] = {}
        self.crowd = Crowd.empty(count, 1)
        self.robots = RobotState.zeros(count)
        self.clearance_pedestrian = np.full(count, np.inf)
        self.clearance_wall = np.full(count, np.inf)
        self.touched_pedestrian = np.zeros(count, dtype=np.bool_)
        self.touched_wall = np.zeros(count, dtype=np.bool_)
        self.collision_role: list[CollisionRole | None] = [None] * count
        self.social_work = np.zeros(count)

    @property
    def touched(self) -> NDArray[np.bool_]:
        """(W,), whether the robot touched anybody or anything during the last period."""
        return self.touched_pedestrian | self.touched_wall

    def running(self, world: int) -> World:
        """Returns the simulator of one world; read it or fork it, do not step it."""
        return self._worlds[world]

    def restart(self, world: int, scenario: Scenario, rng: np.random.Generator) -> None:
        """Builds one world anew; the others stay as they are."""
        if len(scenario.pedestrians) > self.crowd.columns:
            self.crowd = self.crowd.widened(len(scenario.pedestrians))
        running = World(scenario, rng=rng, physics_dt=self._config.physics_dt, robot=self._body)
        self._worlds[world] = running
        self.crowd.restart(world, running)
        self.robots.restart(world, scenario.robot_start)
        self._begin_period(world, running)

    def step(self, robot: Robot) -> None:
        """Runs one policy period with the commands that `robots` holds."""
        config = self._config
        # Plain numbers: the loop below runs for every world and physics step.
        velocities = robot.drive(self.robots, config.physics_dt, config.physics_steps).tolist()
        for world, running in self._worlds.items():
            self._begin_period(world, running)
            for velocity in velocities[world]:
                self._physics_step(world, running, velocity)
            self._read(world, running)

    def _begin_period(self, world: int, running: World) -> None:
        self.clearance_pedestrian[world] = running.robot_clearance
        self.clearance_wall[world] = running.robot_wall_clearance
        self.touched_pedestrian[world] = False
        self.touched_wall[world] = False
        self.collision_role[world] = None
        self.social_work[world] = 0.0

    def _physics_step(self, world: int, running: World, robot_velocity: list[float]) -> None:
        if running.robot_clearance < self._in_reach:
            self._read(world, running)  # a contact may follow: keep the state before it
        running.step(robot_velocity)
        if running.robot_clearance < self.clearance_pedestrian[world]:
            self.clearance_pedestrian[world] = running.robot_clearance
        if running.robot_wall_clearance < self.clearance_wall[world]:
            self.clearance_wall[world] = running.robot_wall_clearance
        if running.robot_wall_contact:
            self.touched_wall[world] = True
        if running.robot_contact and not self.touched_pedestrian[world]:
            self.touched_pedestrian[world] = True
            self.collision_role[world] = self._role(world)
        if self._record:
            self.social_work[world] += _social_force(running) * self._config.physics_dt

    def _read(self, world: int, running: World) -> None:
        self.crowd.read(world, running)
        self.robots.position[world] = running.robot_position
        self.robots.velocity[world] = running.robot_velocity

    def _role(self, world: int) -> CollisionRole:
        """Who moved faster toward the other just before they touched.

        The running world has already been through the contact, which has changed velocities; what
        was read last is the state before it.
        """
        crowd, robots = self.crowd, self.robots
        toward = crowd.position[world] - robots.position[world]
        distance = np.sqrt((toward**2).sum(axis=-1))
        gap = np.where(crowd.valid[world], distance - crowd.radius[world], np.inf)
        person = gap.argmin()
        by_robot = np.dot(robots.velocity[world], toward[person])
        by_person = -np.dot(crowd.velocity[world, person], toward[person])
        return "robot_on_person" if by_robot >= by_person else "person_on_robot"


def _social_force(running: World) -> float:
    """Magnitudes of the social forces on the robot and by the robot, summed [m/s^2]."""
    on_robot, on_pedestrians = running.robot_social_forces()
    forces = np.concatenate((on_robot[None], on_pedestrians))
    return float(np.sqrt((forces**2).sum(axis=-1)).sum())
