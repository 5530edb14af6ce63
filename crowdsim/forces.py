"""The social force model: what makes a pedestrian speed up, slow down and turn aside.

The acceleration of pedestrian i is (Helbing and Molnár 1995, in the circular form and with the
anisotropy of Helbing, Farkas, Molnár and Vicsek 2002; all terms per unit of mass)

    a_i = (v0_i e_i - v_i) / tau_i                                               goal drive
        + sum_j A exp((r_ij - d_ij) / B) n_ij s(phi_ij) (1 - t_ij / T)           people
        + A_w exp((r_i - D_i) / B_w) n_iw                                        walls
        + sigma xi_i                                                             whim
        - b_i e_i                                                                following

    s(phi) = lambda + (1 - lambda) (1 + cos phi) / 2

with e_i where i wants to go, r_ij the sum of the radii, phi_ij the angle between e_i and the
direction in which i sees j, D_i the distance to the nearest wall, and xi_i white noise. The sum is
over everybody within the range whom no wall hides; who does not notice the robot leaves it out.

People look ahead (Zanlungo, Ikeda and Kanda 2011): n_ij d_ij is not the vector from j to i now but
the one at t_ij, when the two would be nearest if both kept their velocity, at most T ahead. Without
that, two people who meet head on brake, stop and only then slide past each other; with it they
turn aside in time. For people who stand, move side by side, or part, t_ij is 0.

Who walks behind somebody keeps a gap in time (`crowdsim.following`): b_i is what the rest would
speed i up beyond that, and at most `hold_back`.

`SocialForce.interaction` puts another law of `crowdsim.interactions` in the place of the circular.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdsim.cell_list import near_pairs
from crowdsim.following import follow
from crowdsim.interactions import INTERACTIONS, Interaction, interact, repulsion
from crowdsim.line_of_sight import Screens, is_hidden, nearest_walls

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
RecordArray = NDArray[np.void]

NEGLIGIBLE: Final = 1e-3
"""Nobody looks whether a wall hides what is felt less than this [m/s^2]: it moves nobody."""


@dataclass(frozen=True, kw_only=True)
class SocialForce:
    """Parameters of the model.

    The defaults are tuned on this simulator's own crossings, doors and squares, and held against
    measured crowds in docs/validation.md.

    Attributes:
        interaction: law between people: `circular`, `elliptical` or `moussaid_2009`; the last two
            want parameters of their own, as `ELLIPTICAL` and `MOUSSAID_2009` have them.
        repulsion: A, of people who touch [m/s^2].
        repulsion_range: B, distance in which it falls by a factor of e [m]; gamma of Moussaïd.
        anisotropy: lambda, weight of those behind against those ahead, 0 to 1.
        wall_repulsion: A_w, of a wall that is touched [m/s^2].
        wall_range: B_w [m].
        interaction_range: people farther apart than this ignore each other [m].
        anticipation: T, how far people look ahead [s]; 0 takes everybody where they are now.
            Moussaïd's law has no use for it.
        whim: sigma, strength of the white noise [m/s^1.5]; it breaks perfect symmetry.
        max_speed_ratio: nobody walks faster than this times the desired speed (1.3 in Helbing
            and Molnár 1995).
        time_gap: what people keep to who walks straight ahead of them [s].
        hold_back: most that they give up for it [m/s^2]; 0 keeps no gap.
    """

    interaction: Interaction = "circular"
    repulsion: float = 2.0
    repulsion_range: float = 0.35
    anisotropy: float = 0.3
    wall_repulsion: float = 2.0
    wall_range: float = 0.08
    interaction_range: float = 4.0
    anticipation: float = 2.0
    whim: float = 0.1
    max_speed_ratio: float = 1.3
    time_gap: float = 0.9
    hold_back: float = 1.3

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ValueError: if the interaction is unknown, or a parameter is not finite, negative, or a
                range is zero.
        """
        if self.interaction not in INTERACTIONS:
            known = ", ".join(INTERACTIONS)
            raise ValueError(f"interaction: expected one of {known}, found {self.interaction!r}")
        for name, value in self._numbers().items():
            if not (np.isfinite(value) and value >= 0):
                raise ValueError(f"{name}: expected a finite value >= 0, found {value}")
        if 0 in (self.repulsion_range, self.wall_range, self.interaction_range, self.time_gap):
            raise ValueError(
                "repulsion_range, wall_range, interaction_range, time_gap: expected > 0"
            )
        if self.anisotropy > 1:
            raise ValueError(f"anisotropy: expected 0 to 1, found {self.anisotropy}")

    def record(self) -> RecordArray:
        """Give the parameters as the one-row record array that the kernels take."""
        numbers = self._numbers()
        dtype = [("interaction", np.int64), *((name, np.float64) for name in numbers)]
        return np.array([(INTERACTIONS.index(self.interaction), *numbers.values())], dtype=dtype)

    def _numbers(self) -> dict[str, float]:
        return {name: value for name, value in vars(self).items() if name != "interaction"}


ELLIPTICAL: Final = SocialForce(
    interaction="elliptical",
    repulsion=0.034,
    repulsion_range=3.22,
    anisotropy=0.06,
    anticipation=0.5,
    hold_back=0.0,
)
"""Johansson, Helbing and Shukla 2007, fitted to videos (table 1, "elliptical II": A 0.04 ± 0.01
m/s^2 of points, which is 0.034 of bodies that touch 0.5 m apart, B 3.22 ± 0.67 m, lambda 0.06 ±
0.04). So weak a law keeps nobody apart who meets head on: contacts do."""

MOUSSAID_2009: Final = SocialForce(
    interaction="moussaid_2009",
    repulsion=4.5,
    repulsion_range=0.35,
    anisotropy=1.0,
    hold_back=0.0,
)
"""Moussaïd et al. 2009, fitted to experiments with two people (A 4.5 ± 0.3 m/s^2, gamma 0.35 ±
0.01 m; and n 2.0 ± 0.1, n' 3.0 ± 0.7, lambda 2.0 ± 0.2 of `crowdsim.interactions`)."""


ETH_UCY: Final = SocialForce(
    repulsion=0.16,
    repulsion_range=0.26,
    anisotropy=0.24,
    anticipation=3.7,
    whim=0.03,
    hold_back=1.7,
)
"""Fitted to how people in ETH/UCY's crowds_zara02 and students003 walk, speed up, bend and keep
apart over 4.8 s (tests/validation/fit.py; docs/validation.md has what comes out on other scenes).
Made for open ground: doors let too few people through."""


@njit(cache=True, error_model="numpy")
def goal_drive(
    desired_speed: float, direction: float, velocity: float, relaxation_time: float
) -> float:
    """Acceleration (v0 e - v) / tau along one axis [m/s^2]."""
    return (desired_speed * direction - velocity) / relaxation_time


@njit(cache=True, error_model="numpy")
def sight(anisotropy: float, cos_phi: float) -> float:
    """Weight lambda + (1 - lambda) (1 + cos phi) / 2 of somebody seen under the angle phi."""
    return anisotropy + (1 - anisotropy) * (1 + cos_phi) / 2


@njit(cache=True, error_model="numpy")
def accelerations(
    bodies: FloatArray,
    present: BoolArray,
    radius: FloatArray,
    direction: FloatArray,
    desired_speed: FloatArray,
    relaxation_time: FloatArray,
    notices_robot: BoolArray,
    noise: FloatArray,
    dt: float,
    wall_grid: FloatArray,
    wall_origin: FloatArray,
    wall_cell: float,
    screens: Screens,
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
        notices_robot: `(N,)` who feels the robot.
        noise: `(N, 2)` standard normal draws for this step.
        dt: its length [s].
        wall_grid: `(H, W, 3)` grid of a `DistanceField`.
        wall_origin: `(2,)` its origin [m].
        wall_cell: its spacing [m].
        screens: the walls, listed for looks over the interaction range.
        model: parameters, as `SocialForce.record` gives them.
    """
    nearest = nearest_walls(bodies, wall_grid, wall_origin, wall_cell)
    pairs = near_pairs(bodies, present, model[0].interaction_range)
    total = people_repulsion(
        pairs, bodies, radius, direction, notices_robot, nearest, screens, model
    )
    whim = model[0].whim / math.sqrt(dt)
    for i in range(len(desired_speed)):
        distance, away = nearest[i, 0], (nearest[i, 1], nearest[i, 2])
        wall = repulsion(model[0].wall_repulsion, model[0].wall_range, distance - radius[i])
        for axis in range(2):
            drive = goal_drive(
                desired_speed[i], direction[i, axis], bodies[i, 2 + axis], relaxation_time[i]
            )
            total[i, axis] += drive + wall * away[axis] + whim * noise[i, axis]
    gap, most = model[0].time_gap, model[0].hold_back
    if most > 0:
        follow(pairs, bodies, radius, direction, relaxation_time, gap, most, total)
    return total


@njit(cache=True, error_model="numpy")
def people_repulsion(
    pairs: IntArray,
    bodies: FloatArray,
    radius: FloatArray,
    direction: FloatArray,
    notices_robot: BoolArray,
    nearest: FloatArray,
    screens: Screens,
    model: RecordArray,
) -> FloatArray:
    """Repulsion `(M, 2)` [m/s^2] within pairs `(P, 2)` of bodies, as far as they see each other.

    Between the robot and who does not notice it there is none, either way. `nearest (M, 3)` is
    what `nearest_walls` gives.
    """
    pushes = pair_repulsions(pairs, bodies, radius, model)
    _forget_unaware(pairs, notices_robot, pushes)
    _forget_hidden(pairs, bodies, nearest, screens, pushes)
    return _add_up(pairs, bodies, direction, model[0].anisotropy, pushes)


@njit(cache=True, error_model="numpy")
def robot_repulsion(
    bodies: FloatArray,
    present: BoolArray,
    radius: FloatArray,
    direction: FloatArray,
    wall_grid: FloatArray,
    wall_origin: FloatArray,
    wall_cell: float,
    screens: Screens,
    model: RecordArray,
) -> FloatArray:
    """Repulsion between the last body, the robot, and each present other in its sight [m/s^2].

    Everybody is taken to notice the robot.

    Returns:
        `(M, 2)` what each feels from the robot; in the last row what the robot feels from all.
    """
    nearest = nearest_walls(bodies, wall_grid, wall_origin, wall_cell)
    pairs = near_pairs(bodies, present, model[0].interaction_range)
    pairs = pairs[(pairs[:, 0] == len(bodies) - 1) | (pairs[:, 1] == len(bodies) - 1)]
    pushes = pair_repulsions(pairs, bodies, radius, model)
    _forget_hidden(pairs, bodies, nearest, screens, pushes)
    return _add_up(pairs, bodies, direction, model[0].anisotropy, pushes)


@njit(cache=True, error_model="numpy")
def pair_repulsions(
    pairs: IntArray, bodies: FloatArray, radius: FloatArray, model: RecordArray
) -> FloatArray:
    """What the law between people says of pairs `(P, 2)`, before anybody minds who is where.

    Returns:
        `(P, 3)` size [m/s^2] and direction (x, y) of what the first one feels; the second feels the
        opposite.
    """
    law, strength = model[0].interaction, model[0].repulsion
    reach, horizon = model[0].repulsion_range, model[0].anticipation
    pushes = np.empty((len(pairs), 3))
    for k in range(len(pairs)):
        a, b = pairs[k, 0], pairs[k, 1]
        dx, dy = bodies[a, 0] - bodies[b, 0], bodies[a, 1] - bodies[b, 1]
        vx, vy = bodies[a, 2] - bodies[b, 2], bodies[a, 3] - bodies[b, 3]
        contact = radius[a] + radius[b]
        size, nx, ny = interact(dx, dy, vx, vy, contact, law, strength, reach, horizon)
        pushes[k, 0], pushes[k, 1], pushes[k, 2] = size, nx, ny
    return pushes


@njit(cache=True, error_model="numpy")
def _forget_unaware(pairs: IntArray, notices_robot: BoolArray, pushes: FloatArray) -> None:
    """Set those to 0 that are between the robot and somebody who does not notice it."""
    robot = len(notices_robot)
    for k in range(len(pairs)):
        a, b = min(pairs[k, 0], pairs[k, 1]), max(pairs[k, 0], pairs[k, 1])
        if b == robot and not notices_robot[a]:
            pushes[k, 0] = 0.0


@njit(cache=True, error_model="numpy")
def _forget_hidden(
    pairs: IntArray,
    bodies: FloatArray,
    nearest: FloatArray,
    screens: Screens,
    pushes: FloatArray,
) -> None:
    """Set those to 0 that are not negligible but act through a wall.

    Between two whose circles of free ground meet there is no wall. All others are looked into in a
    second loop: the processor cannot guess who they are.
    """
    doubtful, count = np.empty(len(pairs) + 1, dtype=np.int64), 0
    for k in range(len(pairs)):
        a, b = pairs[k, 0], pairs[k, 1]
        dx, dy = bodies[b, 0] - bodies[a, 0], bodies[b, 1] - bodies[a, 1]
        room = nearest[a, 0] + nearest[b, 0]
        doubtful[count] = k
        count += (pushes[k, 0] > NEGLIGIBLE) & (dx * dx + dy * dy > room * room)
    for k in doubtful[:count]:
        a, b = pairs[k, 0], pairs[k, 1]
        if is_hidden(screens, bodies[a, 0], bodies[a, 1], bodies[b, 0], bodies[b, 1]):
            pushes[k, 0] = 0.0


@njit(cache=True, error_model="numpy")
def _add_up(
    pairs: IntArray,
    bodies: FloatArray,
    direction: FloatArray,
    anisotropy: float,
    pushes: FloatArray,
) -> FloatArray:
    """Sum `(M, 2)` [m/s^2] of the pushes `(P, 3)`, each as far as one sees the other."""
    total = np.zeros((len(bodies), 2))
    for k in range(len(pairs)):
        a, b = pairs[k, 0], pairs[k, 1]
        dx, dy = bodies[a, 0] - bodies[b, 0], bodies[a, 1] - bodies[b, 1]
        distance = math.sqrt(dx * dx + dy * dy)
        cos_a = -(dx * direction[a, 0] + dy * direction[a, 1]) / distance
        cos_b = (dx * direction[b, 0] + dy * direction[b, 1]) / distance
        size, nx, ny = pushes[k, 0], pushes[k, 1], pushes[k, 2]
        on_a, on_b = size * sight(anisotropy, cos_a), size * sight(anisotropy, cos_b)
        total[a, 0] += on_a * nx
        total[a, 1] += on_a * ny
        total[b, 0] -= on_b * nx
        total[b, 1] -= on_b * ny
    return total
