"""The social force model: what makes a pedestrian speed up, slow down and turn aside.

The acceleration of pedestrian i is (Helbing and Molnár 1995, in the circular form and with the
anisotropy of Helbing, Farkas, Molnár and Vicsek 2002; all terms per unit of mass)

    a_i = (v0_i e_i - v_i) / tau_i                                               goal drive
        + sum_j A exp((r_ij - d_ij) / B) n_ij s(phi_ij) (1 - t_ij / T)           people
        + A_w exp((r_i - D_i) / B_w) n_iw                                        walls
        + sigma xi_i                                                             whim

    s(phi) = lambda + (1 - lambda) (1 + cos phi) / 2

with e_i where i wants to go, r_ij the sum of the radii, phi_ij the angle between e_i and the
direction in which i sees j, D_i the distance to the nearest wall, and xi_i white noise.

People look ahead (Zanlungo, Ikeda and Kanda 2011): n_ij d_ij is not the vector from j to i now but
the one at t_ij, when the two would be nearest if both kept their velocity, at most T ahead. Without
that, two people who meet head on brake, stop and only then slide past each other; with it they
turn aside in time. For people who stand, move side by side, or part, t_ij is 0.
"""

import math
from dataclasses import astuple, dataclass, fields

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim import distance_field
from crowdsim.cell_list import build_cell_list

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
RecordArray = NDArray[np.void]


@dataclass(frozen=True, kw_only=True)
class SocialForce:
    """Parameters of the model.

    The defaults are tuned on this simulator's own crossings, doors and squares: people who meet
    head on pass at full speed, 20 who cross a circle need 1.1 times the free time, and a door of
    1 m lets 1.1 people per second through.

    Attributes:
        repulsion: A, of people who touch [m/s^2].
        repulsion_range: B, distance in which it falls by a factor of e [m].
        anisotropy: lambda, weight of those behind against those ahead, 0 to 1.
        wall_repulsion: A_w, of a wall that is touched [m/s^2].
        wall_range: B_w [m].
        interaction_range: people farther apart than this ignore each other [m].
        anticipation: T, how far people look ahead [s]; 0 takes everybody where they are now.
        whim: sigma, strength of the white noise [m/s^1.5]; it breaks perfect symmetry.
        max_speed_ratio: nobody walks faster than this times the desired speed (1.3 in Helbing
            and Molnár 1995).
    """

    repulsion: float = 2.5
    repulsion_range: float = 0.25
    anisotropy: float = 0.3
    wall_repulsion: float = 2.0
    wall_range: float = 0.08
    interaction_range: float = 4.0
    anticipation: float = 2.0
    whim: float = 0.1
    max_speed_ratio: float = 1.3

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ValueError: if a parameter is not finite, negative, or a range is zero.
        """
        for name, value in zip((f.name for f in fields(self)), astuple(self), strict=True):
            if not (np.isfinite(value) and value >= 0):
                raise ValueError(f"{name}: expected a finite value >= 0, found {value}")
        if min(self.repulsion_range, self.wall_range, self.interaction_range) == 0:
            raise ValueError("repulsion_range, wall_range, interaction_range: expected > 0")
        if self.anisotropy > 1:
            raise ValueError(f"anisotropy: expected 0 to 1, found {self.anisotropy}")

    def record(self) -> RecordArray:
        """Give the parameters as the one-row record array that the kernels take."""
        dtype = [(parameter.name, np.float64) for parameter in fields(self)]
        return np.array([astuple(self)], dtype=dtype)


@njit(cache=True)
def goal_drive(
    desired_speed: float, direction: float, velocity: float, relaxation_time: float
) -> float:
    """Acceleration (v0 e - v) / tau along one axis [m/s^2]."""
    return (desired_speed * direction - velocity) / relaxation_time


@njit(cache=True)
def repulsion(strength: float, reach: float, gap: float) -> float:
    """Acceleration A exp(-gap / B) of two surfaces that are `gap` apart [m/s^2].

    It is minus the gradient of the potential A B exp(-gap / B).
    """
    return strength * math.exp(-gap / reach)


@njit(cache=True)
def sight(anisotropy: float, cos_phi: float) -> float:
    """Weight lambda + (1 - lambda) (1 + cos phi) / 2 of somebody seen under the angle phi."""
    return anisotropy + (1 - anisotropy) * (1 + cos_phi) / 2


@njit(cache=True)
def accelerations(
    bodies: FloatArray,
    present: BoolArray,
    radius: FloatArray,
    direction: FloatArray,
    desired_speed: FloatArray,
    relaxation_time: FloatArray,
    noise: FloatArray,
    dt: float,
    wall_grid: FloatArray,
    wall_origin: FloatArray,
    wall_cell: float,
    model: RecordArray,
) -> FloatArray:
    """Accelerations `(M, 2)` [m/s^2] of all bodies, computed from one snapshot.

    Args:
        bodies: `(M, 4)` x, y, vx, vy; the N pedestrians first, then perhaps the robot.
        present: `(M,)` who is felt by the others.
        radius: `(M,)` [m].
        direction: `(M, 2)` wanted direction e, shorter than 1 for who wants to be slow.
        desired_speed: `(N,)` [m/s].
        relaxation_time: `(N,)` [s].
        noise: `(N, 2)` standard normal draws for this step.
        dt: its length [s].
        wall_grid: `(H, W, 3)` grid of a `DistanceField`.
        wall_origin: `(2,)` its origin [m].
        wall_cell: its spacing [m].
        model: parameters, as `SocialForce.record` gives them.
    """
    total = people_repulsion(bodies, present, radius, direction, model)
    whim = model[0].whim / math.sqrt(dt)
    for i in range(len(desired_speed)):
        distance, away_x, away_y = distance_field.sample(
            wall_grid, wall_origin, wall_cell, bodies[i, 0], bodies[i, 1]
        )
        wall = repulsion(model[0].wall_repulsion, model[0].wall_range, distance - radius[i])
        away = away_x, away_y
        for axis in range(2):
            drive = goal_drive(
                desired_speed[i], direction[i, axis], bodies[i, 2 + axis], relaxation_time[i]
            )
            total[i, axis] += drive + wall * away[axis] + whim * noise[i, axis]
    return total


@njit(cache=True)
def people_repulsion(
    bodies: FloatArray,
    present: BoolArray,
    radius: FloatArray,
    direction: FloatArray,
    model: RecordArray,
) -> FloatArray:
    """Repulsion `(M, 2)` [m/s^2] of each present body by the others within the range."""
    members, starts, columns = build_cell_list(bodies, present, model[0].interaction_range)
    sorted_bodies, sorted_radius = bodies[members], radius[members]
    sorted_direction = direction[members]
    sorted_total = np.zeros((len(members), 2))
    for cell in range(len(starts) - 1):
        last_column = cell % columns == columns - 1
        above = cell + columns
        first_above = starts[min(above - (cell % columns > 0), len(starts) - 1)]
        end_above = starts[min(above + (1 if last_column else 2), len(starts) - 1)]
        end_right = starts[cell + (1 if last_column else 2)]
        for a in range(starts[cell], starts[cell + 1]):
            arrays = sorted_bodies, sorted_radius, sorted_direction, model, sorted_total
            _repel(a, a + 1, end_right, *arrays)
            _repel(a, first_above, end_above, *arrays)
    total = np.zeros((len(bodies), 2))
    total[members] = sorted_total
    return total


@njit(cache=True)
def _repel(
    a: int,
    first: int,
    end: int,
    bodies: FloatArray,
    radius: FloatArray,
    direction: FloatArray,
    model: RecordArray,
    total: FloatArray,
) -> None:
    """Add the repulsion between body a and each of those from `first` to `end` to both sides."""
    x, y, vx, vy = bodies[a]
    reach = model[0].interaction_range ** 2
    anisotropy = model[0].anisotropy
    for b in range(first, end):
        dx, dy = x - bodies[b, 0], y - bodies[b, 1]
        squared = dx * dx + dy * dy
        if squared >= reach or squared == 0:
            continue
        strength, nx, ny = repulsion_ahead(
            dx,
            dy,
            vx - bodies[b, 2],
            vy - bodies[b, 3],
            radius[a] + radius[b],
            model[0].repulsion,
            model[0].repulsion_range,
            model[0].anticipation,
        )
        distance = math.sqrt(squared)
        cos_a = -(dx * direction[a, 0] + dy * direction[a, 1]) / distance
        cos_b = (dx * direction[b, 0] + dy * direction[b, 1]) / distance
        on_a = strength * sight(anisotropy, cos_a)
        on_b = strength * sight(anisotropy, cos_b)
        total[a, 0] += on_a * nx
        total[a, 1] += on_a * ny
        total[b, 0] -= on_b * nx
        total[b, 1] -= on_b * ny


@njit(cache=True)
def repulsion_ahead(
    dx: float,
    dy: float,
    vx: float,
    vy: float,
    contact: float,
    strength: float,
    reach: float,
    horizon: float,
) -> tuple[float, float, float]:
    """Repulsion as if from where the two are going to be nearest, the less the later that is.

    Args:
        dx: x of one as seen from the other [m].
        dy: its y [m].
        vx: how fast dx changes [m/s].
        vy: how fast dy changes [m/s].
        contact: sum of the radii [m].
        strength: A [m/s^2].
        reach: B [m].
        horizon: T [s].

    Returns:
        Acceleration [m/s^2], and the unit vector (x, y) in which it acts.
    """
    urgency = 1.0
    if horizon > 0:
        wait = time_to_closest(dx, dy, vx, vy)
        if wait >= horizon:
            return 0.0, 0.0, 0.0
        urgency = 1 - wait / horizon
        dx, dy = dx + wait * vx, dy + wait * vy
    distance = math.sqrt(dx * dx + dy * dy)
    if distance == 0:
        return 0.0, 0.0, 0.0
    acceleration = urgency * repulsion(strength, reach, distance - contact)
    return acceleration, dx / distance, dy / distance


@njit(cache=True)
def time_to_closest(dx: float, dy: float, vx: float, vy: float) -> float:
    """Time [s] until two bodies that keep their velocities are nearest; 0 if they do not approach.

    (dx, dy) is where one is as seen from the other [m], (vx, vy) how fast that changes [m/s].
    """
    approach = -(dx * vx + dy * vy)
    return approach / (vx * vx + vy * vy) if approach > 0 else 0.0


@njit(cache=True)
def robot_repulsion(
    bodies: FloatArray,
    present: BoolArray,
    radius: FloatArray,
    direction: FloatArray,
    model: RecordArray,
) -> FloatArray:
    """Repulsion between the last body, the robot, and each present other [m/s^2].

    Returns:
        `(M, 2)` what each feels from the robot; in the last row what the robot feels from all.
    """
    total = np.zeros((len(bodies), 2))
    robot = len(bodies) - 1
    for i in range(robot):
        if present[i]:
            _repel(i, robot, robot + 1, bodies, radius, direction, model, total)
    return total
