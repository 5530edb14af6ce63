"""The bodies of a world that begins: people first, the robot last."""

import numpy as np
from numpy.typing import NDArray

from crowdsim.pedestrians import Pedestrians
from crowdsim.robot_body import RobotBody

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def starting_bodies(
    pedestrians: Pedestrians, robot: RobotBody | None, robot_start: tuple[float, float, float]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Put the people and the robot, if there is one, into one pool of M bodies.

    Returns:
        bodies: `(M, 4)` x, y, vx, vy [m, m/s]; the robot stands still.
        radius: `(M,)` [m].
        mass: `(M,)` [kg].
    """
    rows = [np.concatenate([pedestrians.position, pedestrians.velocity], axis=1)]
    radius, mass = [pedestrians.radius], [pedestrians.mass]
    if robot is not None:
        x, y, _ = robot_start
        rows.append(np.array([[x, y, 0.0, 0.0]]))
        radius.append(np.array([robot.radius]))
        mass.append(np.array([robot.mass]))
    return np.concatenate(rows), np.concatenate(radius), np.concatenate(mass)


def draw_awareness(
    rng: np.random.Generator, pedestrians: Pedestrians, robot: RobotBody | None
) -> BoolArray:
    """Draw who notices the robot `(N,)`, from a stream of its own: no whim depends on it."""
    if robot is None:
        return pedestrians.notices_robot.copy()
    (awareness_rng,) = rng.spawn(1)
    notices: BoolArray = awareness_rng.random(len(pedestrians)) < robot.awareness
    return notices & pedestrians.notices_robot


def refuse_shared_places(bodies: FloatArray) -> None:
    """Check the starts.

    Raises:
        ValueError: if two bodies are at the same place.
    """
    places, counts = np.unique(bodies[:, :2], axis=0, return_counts=True)
    if (counts > 1).any():
        raise ValueError(
            f"expected everybody to start at a place of their own, found {counts.max()} bodies "
            f"at {tuple(places[counts.argmax()].tolist())}"
        )
