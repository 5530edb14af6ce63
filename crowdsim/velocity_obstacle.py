"""The shortest way out of the velocities that lead to a collision (van den Berg et al. 2011)."""

import math

from numba import njit


@njit(cache=True)
def way_out(
    x: float, y: float, vx: float, vy: float, contact: float, horizon: float, dt: float
) -> tuple[float, float, float, float]:
    """Vector u from a relative velocity to the border of the velocity obstacle, and its normal n.

    Args:
        x: of the other as seen from here [m].
        y: likewise.
        vx: own velocity minus the other's [m/s].
        vy: likewise.
        contact: sum of the radii [m].
        horizon: T [s].
        dt: time in which those who overlap part [s].

    Returns:
        (ux, uy, nx, ny); u points into the obstacle for a velocity that is outside it.
    """
    squared = x * x + y * y
    overlap = squared <= contact * contact
    end = dt if overlap else horizon
    wx, wy = vx - x / end, vy - y / end
    before_end = wx * x + wy * y
    length = math.hypot(wx, wy)
    if overlap or (before_end < 0 and before_end**2 > contact**2 * length**2):
        nx, ny = (wx / length, wy / length) if length > 0 else (0.0, 0.0)
        depth = contact / end - length
        return depth * nx, depth * ny, nx, ny
    # The legs of the cone touch the disc of radius r around x; n is normal to the nearer one.
    side = 1.0 if x * wy - y * wx > 0 else -1.0
    leg, bend = math.sqrt(squared - contact * contact), side * contact
    nx = -side * (x * bend + y * leg) / squared
    ny = side * (x * leg - y * bend) / squared
    depth = -(vx * nx + vy * ny)
    return depth * nx, depth * ny, nx, ny
