"""W worlds side by side: their physics one by one, their state as arrays over W."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crowdsim.passage import Passage
from crowdsim.robot_body import RobotBody
from crowdsim.scenario import Scenario
from crowdsim.world import CONTACT_GAP, World
from envs.config import CrowdNavConfig
from envs.robots import Robot, RobotState
from envs.trace import CollisionRole

Floats = NDArray[np.float64]


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
        self.read(world, source, np.concatenate((source.positions, source.velocities), axis=1))

    def read(self, world: int, source: World, people: Floats) -> None:
        """Takes one world's pedestrians as they are now, `people` (N, 4) being x, y, vx, vy."""
        count = len(people)
        self.position[world, :count] = people[:, :2]
        self.velocity[world, :count] = people[:, 2:]
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
        self._worlds: dict[int, World] = {}
        self._passages: dict[int, Passage] = {}
        self._gaps = np.full((count, config.physics_steps + 1, 2), np.inf)
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
        running = World(
            scenario,
            rng=rng,
            physics_dt=self._config.physics_dt,
            robot=self._body,
            former=self._worlds.get(world),
        )
        self._worlds[world] = running
        self._passages.pop(world, None)
        self.crowd.restart(world, running)
        self.robots.restart(world, scenario.robot_start)
        self.clearance_pedestrian[world] = running.robot_clearance
        self.clearance_wall[world] = running.robot_wall_clearance
        self.touched_pedestrian[world] = self.touched_wall[world] = False
        self.collision_role[world] = None
        self.social_work[world] = 0.0

    def step(self, robot: Robot) -> None:
        """Runs one policy period with the commands that `robots` holds."""
        config = self._config
        velocities = robot.drive(self.robots, config.physics_dt, config.physics_steps)
        run = self._run_recorded if self._record else self._run
        for world, running in self._worlds.items():
            passage = run(world, running, velocities[world])
            self._passages[world] = passage
            self._gaps[world] = passage.clearances
            self._read(world, running, passage.states[-1])
        self._judge()

    def people_before(self, world: int, seconds: float) -> Floats:
        """Returns where the people of one world were (N, 2) so long ago [m].

        Bodies move evenly within a physics step, so that nothing is lost between its ends.

        Args:
            world: Which.
            seconds: How long ago, at most a policy period; right after a restart it is now.
        """
        if world not in self._passages:
            return self.crowd.position[world, : len(self._worlds[world].ids)]
        people = self._passages[world].states[:, :-1, :2]
        steps = seconds / self._config.physics_dt
        later = len(people) - 1 - int(steps)
        share = steps - int(steps)
        earlier = max(later - 1, 0)
        return np.asarray(people[later] + share * (people[earlier] - people[later]))

    def _run(self, _: int, running: World, velocities: Floats) -> Passage:
        return running.run(velocities)

    def _run_recorded(self, world: int, running: World, velocities: Floats) -> Passage:
        """Adds up the social forces after every step on the way."""
        self.social_work[world] = 0.0
        passages = []
        for velocity in velocities:
            passages.append(running.run(velocity[None]))
            self.social_work[world] += _social_force(running) * self._config.physics_dt
        return Passage.joined(passages)

    def _read(self, world: int, running: World, state: Floats) -> None:
        """Takes one world as it is now, `state` (N + 1, 4) being x, y, vx, vy, the robot's last."""
        self.crowd.read(world, running, state[:-1])
        self.robots.position[world] = state[-1, :2]
        self.robots.velocity[world] = state[-1, 2:]

    def _judge(self) -> None:
        """Tells from the gaps after each step how near the robots came and whom they touched."""
        self.clearance_pedestrian, self.clearance_wall = self._gaps.min(axis=1).T
        touched = np.asarray((self._gaps[:, 1:] <= CONTACT_GAP).any(axis=1))  # (W, 2)
        self.touched_pedestrian, self.touched_wall = touched.T
        self.collision_role = [None] * len(touched)
        for world in np.flatnonzero(self.touched_pedestrian).tolist():
            self.collision_role[world] = self._role(world, self._passages[world])

    def _role(self, world: int, passage: Passage) -> CollisionRole:
        """Who moved faster toward the other just before they touched.

        Not after it: the contact has changed velocities.
        """
        before = passage.states[(passage.clearances[1:, 0] <= CONTACT_GAP).argmax()]
        people, robot = before[:-1], before[-1]
        toward = people[:, :2] - robot[:2]
        # Who is absent stands far away.
        gap = np.sqrt((toward**2).sum(axis=-1)) - self.crowd.radius[world, : len(people)]
        person = gap.argmin()
        by_robot = np.dot(robot[2:], toward[person])
        by_person = -np.dot(people[person, 2:], toward[person])
        return "robot_on_person" if by_robot >= by_person else "person_on_robot"


def _social_force(running: World) -> float:
    """Magnitudes of the social forces on the robot and by the robot, summed [m/s^2]."""
    on_robot, on_pedestrians = running.robot_social_forces()
    forces = np.concatenate((on_robot[None], on_pedestrians))
    return float(np.sqrt((forces**2).sum(axis=-1)).sum())
