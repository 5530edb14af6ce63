"""How crowds slow down with density, and what bottlenecks let through."""

from functools import cache

import crowds
import numpy as np
import pedpy

from crowdsim.recordings import find_data

WALKED_UP = 3.0
"""Seconds that a crowd gets to find its pace before it is measured."""

DENSITIES = (0.2, 0.4, 0.7, 1.0, 1.3, 1.6, 2.0, 2.4, 2.8, 3.2, 3.6, 4.0, 4.4)

DOORS = (0.8, 1.0, 1.2)
"""Widths of bottlenecks [m]."""


def measured(pattern):
    """Density-speed points `(P, 2)` of the experiments whose files match."""
    folder = find_data().parent / "pedestrian_dynamics"
    files = sorted(folder.glob(pattern))
    return np.concatenate([np.loadtxt(file, comments="#", ndmin=2) for file in files])


@cache
def one_way_cloud(seed):
    """Points (density, speed) `(P, 2)` of crowds in a corridor 1.8 m wide, by PedPy.

    For each density a crowd 26 m long walks through a measuring field before the thinning at its
    head, or its end, gets there.
    """
    points = []
    for density in DENSITIES:
        rng = np.random.default_rng((seed, round(10 * density)))
        place = crowds.fill(rng, (-16.0, -0.9, 10.0, 0.9), density)
        goal = place * [0.0, 1.0] + [40.0, 0.0]
        start = crowds.scenario(seed, place, goal, walls=crowds.corridor(-20.0, 42.0, 1.8))
        tracks = crowds.walk(start, seed, 10.0, every=4)
        points.append(density_and_speed(tracks.pedpy(first=WALKED_UP), (0.0, -0.9, 3.0, 0.9)))
    return np.concatenate(points)


def density_and_speed(trajectory, box):
    """PedPy's classic density and mean speed in a box, twice a second, `(P, 2)`."""
    field = crowds.area(*box)
    density = pedpy.compute_classic_density(traj_data=trajectory, measurement_area=field)
    speeds = pedpy.compute_individual_speed(
        traj_data=trajectory,
        frame_step=2,
        movement_direction=np.array([1.0, 0.0]),
        speed_calculation=pedpy.SpeedCalculation.BORDER_SINGLE_SIDED,
    )
    speed = pedpy.compute_mean_speed_per_frame(
        traj_data=trajectory, measurement_area=field, individual_speed=speeds
    )
    both = density.merge(speed, on="frame").dropna()
    both = both[(both.density > 0) & (both.frame % 2 == 0)]
    return both[["density", "speed"]].to_numpy()


def as_dense_as(cloud, reference):
    """Points of a cloud whose densities are the nearest to those of a reference, in turn."""
    order = np.argsort(cloud[:, 0], kind="stable")
    cloud, rng = cloud[order], np.random.default_rng(0)
    chosen = []
    for density in reference[:, 0]:
        near = np.flatnonzero(np.abs(cloud[:, 0] - density) <= 0.2)
        if len(near) == 0:
            near = [np.abs(cloud[:, 0] - density).argmin()]
        chosen.append(rng.choice(near))
    return cloud[chosen]


def kolmogorov_smirnov(one, other):
    """Two-dimensional distance of two clouds (Fasano and Franceschini 1987), 0 to 1."""
    return (_largest_difference(one, one, other) + _largest_difference(other, one, other)) / 2


def _largest_difference(centers, one, other):
    worst = 0.0
    for x, y in centers:
        for right in (True, False):
            for above in (True, False):
                share = [
                    np.mean(((c[:, 0] > x) == right) & ((c[:, 1] > y) == above))
                    for c in (one, other)
                ]
                worst = max(worst, abs(share[0] - share[1]))
    return worst


def weidmann(density):
    """Mean speed of walkers at a density [1/m^2] (Weidmann 1993) [m/s]."""
    return 1.34 * (1 - np.exp(-1.913 * (1 / density - 1 / 5.4)))


def binned(cloud, width=0.25):
    """Mean density and speed `(B, 2)` of a cloud's points in bins of density."""
    bins = np.floor(cloud[:, 0] / width)
    return np.array([cloud[bins == b].mean(axis=0) for b in np.unique(bins)])


def one_way_distance(seed):
    reference = measured("unidirectional_*.txt")
    return kolmogorov_smirnov(as_dense_as(one_way_cloud(seed), reference), reference)


def weidmann_error(seed):
    means = binned(one_way_cloud(seed))
    return float(np.sqrt(np.mean((means[:, 1] - weidmann(means[:, 0])) ** 2)))


def largest_specific_flow(seed):
    means = binned(one_way_cloud(seed))
    return float((means[:, 0] * means[:, 1]).max())


def measured_flows():
    """Width [m], least and largest flow [1/s] measured at it, for each of `DOORS`.

    As in the files of `pedestrian_dynamics` (seven authors), so that cases need no data.
    """
    return ((0.8, 1.288, 1.737), (1.0, 1.71, 2.774), (1.2, 2.033, 2.751))


@cache
def bottleneck(seed, width, people=100, seconds=120.0):
    """Flow [1/s] through a door, and how many are left after 120 s.

    100 people wait at 2.5 /m^2 in a room 5 m wide, in front of a passage 1 m long.
    """
    rng = np.random.default_rng((seed, 5))
    place = crowds.fill(rng, (-9.0, -2.5, -1.0, 2.5), people / 40.0)
    y = width / 2 + 0.05
    walls = np.concatenate(
        [
            crowds.polyline((-12.0, s * 2.6), (0.0, s * 2.6), (0.0, s * y), (1.0, s * y))
            for s in (-1, 1)
        ]
        + [crowds.polyline((1.0, s * y), (1.0, s * 10.0)) for s in (-1, 1)]
    )
    waypoints = crowds.by_way_of(place, (2.2, 0.0), (300.0, 0.0))
    start = crowds.scenario(seed, place, waypoints, walls=walls)
    tracks = crowds.walk(start, seed, seconds, until=lambda p: (p[:, 0] > 0.7).all())
    line = pedpy.MeasurementLine([(0.5, -y), (0.5, y)])
    _, crossings = pedpy.compute_n_t(traj_data=tracks.pedpy(), measurement_line=line)
    passed = np.sort(crossings.frame.to_numpy()) * tracks.dt
    left = int((tracks.positions[-1][:, 0] < 0.5).sum())
    if len(passed) < 20:
        return 0.0, left
    # The first few come before the jam, the last few after it.
    first, last = len(passed) // 10, len(passed) * 9 // 10
    return float((last - first) / (passed[last] - passed[first])), left


@cache
def single_file_cloud(seed):
    """Points (density, speed) `(P, 2)` of people in a row who cannot pass one another.

    A person's density is one over half the way between those before and behind.
    """
    points = []
    for density in (0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8):
        rng = np.random.default_rng((seed, round(10 * density), 1))
        x = np.arange(-20.0, 10.0, 1 / density)
        place = np.stack([x + rng.uniform(-0.02, 0.02, len(x)), np.zeros(len(x))], axis=1)
        goal = np.broadcast_to([40.0, 0.0], place.shape)
        start = crowds.scenario(seed, place, goal, walls=crowds.corridor(-22.0, 42.0, 0.65))
        tracks = crowds.walk(start, seed, 10.0, every=4)
        for row in range(round(WALKED_UP / tracks.dt), len(tracks.velocities), 5):
            x, speed = tracks.positions[row, :, 0], tracks.velocities[row, :, 0]
            near = np.flatnonzero((x[1:-1] > 0) & (x[1:-1] < 3)) + 1
            points.append(np.stack([2 / (x[near + 1] - x[near - 1]), speed[near]], axis=1))
    return np.concatenate(points)


def single_file_reference():
    """Measured points `(P, 2)` up to the density at which bodies of 0.5 m touch."""
    points = measured("single_file_*.txt")
    return points[points[:, 0] <= 1.8]


def single_file_distance(seed):
    reference = single_file_reference()
    return kolmogorov_smirnov(as_dense_as(single_file_cloud(seed), reference), reference)
