"""How good several futures are: the nearest of them, their density at the truth, their regions.

Everything is of the people of one scene. In the shapes: M modes, F forecast steps, A agents.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from predictor.modal_forecast import ModalForecast

REGION_POINTS: Final = 120
"""Points, all modes together, that the mass of a region is measured with."""
GOLDEN_ANGLE: Final = np.pi * (3.0 - np.sqrt(5.0))


def min_ade(errors: NDArray[np.float64], k: int) -> NDArray[np.float64]:
    """(A,) ADE of the best of the k most probable modes, from (M, F, A) errors of modes.

    `min_ade` and `min_fde` need not be of the same mode.
    """
    return np.asarray(errors[:k].mean(axis=1).min(axis=0))


def min_fde(errors: NDArray[np.float64], k: int) -> NDArray[np.float64]:
    """(A,) FDE of the best of the k most probable modes, from (M, F, A) errors of modes."""
    return np.asarray(errors[:k, -1].min(axis=0))


def min_joint_ade(errors: NDArray[np.float64], k: int) -> float:
    """ADE of a scene in the best of k joint futures, from (M, F, A) errors of modes.

    In joint future i everyone takes the i-th most probable mode: nothing in the modes says which of
    them go together (E. Weng et al., "Joint Metrics Matter", 2023).
    """
    return float(errors[:k].mean(axis=(1, 2)).min())


def min_joint_fde(errors: NDArray[np.float64], k: int) -> float:
    """FDE of a scene in the best of k joint futures; as `min_joint_ade`."""
    return float(errors[:k, -1].mean(axis=1).min())


def nll(forecast: ModalForecast, future: NDArray[np.float64]) -> NDArray[np.float64]:
    """Negative log density of the mixture at the truth, each step by itself: (F, A) [nat].

    The density is that of positions in the world, per square metre.

    Args:
        forecast: Of one world, without the W axis.
        future: (F, A, 2) true positions [m].
    """
    each = [_log_densities(forecast, mode, future) for mode in range(len(forecast.position))]
    return np.asarray(-np.logaddexp.reduce(each, axis=0))


def region_mass(forecast: ModalForecast, future: NDArray[np.float64]) -> NDArray[np.float64]:
    """Probability of the smallest region that reaches the truth: (F, A), each step by itself.

    The region is where the mixture is at least as dense as at the truth; of honest mixtures the
    truth lies in the region of probability p in a share p of the cases (R. Hyndman, "Computing and
    Graphing Highest Density Regions", 1996). The probability is measured with points that divide
    each mode into equal parts, so nothing is drawn at random.

    Args:
        forecast: Of one world, without the W axis.
        future: (F, A, 2) true positions [m].
    """
    factor = np.linalg.cholesky(forecast.covariance)  # (M, F, A, 2, 2)
    parts = _equal_parts(max(1, REGION_POINTS // len(forecast.position)))  # (J, 2)
    offset = np.einsum("mfaxy,jy->jmfax", factor, parts)
    points = (forecast.position + offset).reshape(-1, *future.shape)  # (J M, F, A, 2)
    density = _density(forecast, np.concatenate([future[None], points]))
    denser = (density[1:] >= density[0]).reshape(offset.shape[:-1])  # (J, M, F, A)
    return np.asarray((forecast.probability[:, None] * denser.mean(axis=0)).sum(axis=0))


def _equal_parts(count: int) -> NDArray[np.float64]:
    """(J, 2) points of a spiral that stand for equal parts of the standard normal distribution."""
    radius = np.sqrt(-2.0 * np.log1p(-(np.arange(count) + 0.5) / count))
    angle = GOLDEN_ANGLE * np.arange(count)
    return np.asarray(radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def _density(forecast: ModalForecast, points: NDArray[np.float64]) -> NDArray[np.float32]:
    """(J, F, A) density of the mixture at (J, F, A, 2) points, in the precision that compares."""
    density = np.zeros(points.shape[:-1], dtype=np.float32)
    for mode in range(len(forecast.position)):
        density += np.exp(_log_densities(forecast, mode, points).astype(np.float32))
    return density


def _log_densities(
    forecast: ModalForecast, mode: int, points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(J, F, A) log of the part of one mode in the density of the mixture at points."""
    covariance = forecast.covariance[mode]
    xx, xy, yy = covariance[..., 0, 0], covariance[..., 0, 1], covariance[..., 1, 1]
    determinant = xx * yy - xy**2
    weight = np.log(forecast.probability[mode]) - 0.5 * np.log(determinant) - np.log(2.0 * np.pi)
    x, y = np.moveaxis(points - forecast.position[mode], -1, 0)
    distance = (yy * x**2 - 2.0 * xy * x * y + xx * y**2) / determinant
    return np.asarray(weight - 0.5 * distance)
