"""Means with 95 % intervals, and differences between arms that met the same episodes.

Two kinds of column need two kinds of interval. A proportion (success, collision) of a few dozen
episodes is often 0 or 1, where resampling sees no spread and would claim certainty: it gets a
closed-form score interval. Any other quantity gets the bias-corrected and accelerated bootstrap.
Missing values (NaN) are dropped, and `n` says how many remained.
"""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike, NDArray

NORMAL = NormalDist()


@dataclass(frozen=True, kw_only=True)
class Interval:
    """An estimate with its interval.

    Attributes:
        mean: Mean over `n` episodes (or of `n` paired differences); NaN where `n` is 0.
        low: Lower end of the interval; NaN where fewer than two values leave it unknown.
        high: Upper end.
        n: Number of values that entered.
    """

    mean: float
    low: float
    high: float
    n: int

    @property
    def excludes_zero(self) -> bool:
        """Whether the whole interval lies on one side of zero."""
        return self.low > 0 or self.high < 0


def mean_interval(
    values: ArrayLike,
    rng: np.random.Generator,
    *,
    confidence: float = 0.95,
    resamples: int = 2000,
) -> Interval:
    """Mean with its interval: Wilson for booleans, BCa bootstrap for everything else.

    Args:
        values: (E,) one value per episode; bool for proportions, else float with NaN for missing.
        rng: Draws the bootstrap resamples.
        confidence: Coverage aimed at.
        resamples: Number of bootstrap resamples.
    """
    array = np.asarray(values)
    if array.dtype == bool:
        return wilson(int(array.sum()), array.size, confidence=confidence)
    return bca(_present(array), rng, confidence=confidence, resamples=resamples)


def paired_difference(
    values: ArrayLike,
    reference: ArrayLike,
    rng: np.random.Generator,
    *,
    confidence: float = 0.95,
    resamples: int = 2000,
) -> Interval:
    """Mean of `values - reference` over episodes that both arms ran from the same seed.

    Pairs with a missing value on either side are dropped. Booleans get the interval of Agresti and
    Min, all else resamples whole pairs, so that what the seed makes easy or hard cancels.

    Args:
        values: (E,) one value per seed.
        reference: (E,) the reference arm's values for the same seeds in the same order.
        rng: Draws the bootstrap resamples.
        confidence: Coverage aimed at.
        resamples: Number of bootstrap resamples.

    Raises:
        ValueError: Where the two arms do not have the same number of episodes.
    """
    ours, theirs = np.asarray(values), np.asarray(reference)
    if ours.shape != theirs.shape:
        raise ValueError(
            f"paired values: expected one per seed in both arms, found {ours.shape} and "
            f"{theirs.shape}"
        )
    if ours.dtype == bool and theirs.dtype == bool:
        only_ours, only_theirs = int((ours & ~theirs).sum()), int((theirs & ~ours).sum())
        return agresti_min(only_ours, only_theirs, ours.size, confidence=confidence)
    differences = _present(ours.astype(float) - theirs.astype(float))
    return bca(differences, rng, confidence=confidence, resamples=resamples)


def wilson(successes: int, n: int, *, confidence: float = 0.95) -> Interval:
    """Score interval of a proportion (Wilson 1927); never of zero width, never outside [0, 1]."""
    if n == 0:
        return Interval(mean=np.nan, low=np.nan, high=np.nan, n=0)
    z = NORMAL.inv_cdf(0.5 + confidence / 2)
    share = successes / n
    centre = (share + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z / (1 + z**2 / n) * np.sqrt(share * (1 - share) / n + z**2 / (4 * n**2))
    return Interval(
        mean=share,
        low=max(0.0, min(share, float(centre - half))),
        high=min(1.0, max(share, float(centre + half))),
        n=n,
    )


def agresti_min(only_first: int, only_second: int, n: int, *, confidence: float = 0.95) -> Interval:
    """Difference of two paired proportions (Agresti and Min 2005: Wald with 1/2 added per cell).

    The interval stays open where no pair disagrees, which is what few episodes deserve.

    Args:
        only_first: Pairs in which only the first arm succeeded.
        only_second: Pairs in which only the second did.
        n: All pairs.
        confidence: Coverage aimed at.
    """
    if n == 0:
        return Interval(mean=np.nan, low=np.nan, high=np.nan, n=0)
    z = NORMAL.inv_cdf(0.5 + confidence / 2)
    first, second, total = only_first + 0.5, only_second + 0.5, n + 2
    centre = (first - second) / total
    half = z * np.sqrt((first + second) / total - centre**2) / np.sqrt(total)
    return Interval(
        mean=(only_first - only_second) / n,
        low=max(-1.0, float(centre - half)),
        high=min(1.0, float(centre + half)),
        n=n,
    )


def bca(
    values: NDArray[np.float64],
    rng: np.random.Generator,
    *,
    confidence: float = 0.95,
    resamples: int = 2000,
) -> Interval:
    """Mean with the bias-corrected and accelerated bootstrap interval (Efron 1987).

    Args:
        values: (E,) finite values.
        rng: Draws the resamples.
        confidence: Coverage aimed at.
        resamples: Number of resamples.
    """
    n = len(values)
    if n < 2:
        mean = float(values[0]) if n else np.nan
        return Interval(mean=mean, low=np.nan, high=np.nan, n=n)
    mean = float(values.mean())
    if np.ptp(values) == 0:
        return Interval(mean=mean, low=mean, high=mean, n=n)
    means = values[rng.integers(n, size=(resamples, n))].mean(axis=1)
    low, high = np.quantile(means, _bca_levels(values, means, confidence))
    return Interval(mean=mean, low=float(low), high=float(high), n=n)


def _bca_levels(
    values: NDArray[np.float64], means: NDArray[np.float64], confidence: float
) -> list[float]:
    """Quantile levels of the resampled means that bound the BCa interval."""
    below = (means < values.mean()).mean() + 0.5 * (means == values.mean()).mean()
    bias = NORMAL.inv_cdf(float(np.clip(below, 1e-6, 1 - 1e-6)))
    # The jackknife means of a sample mean differ from it by the centred values, divided by n - 1.
    centred = values - values.mean()
    acceleration = (centred**3).sum() / (6 * (centred**2).sum() ** 1.5)
    levels = []
    for tail in (0.5 - confidence / 2, 0.5 + confidence / 2):
        z = bias + NORMAL.inv_cdf(tail)
        levels.append(NORMAL.cdf(bias + z / (1 - acceleration * z)))
    return levels


def _present(values: NDArray[np.generic]) -> NDArray[np.float64]:
    """The values that are not missing, as float."""
    array = values.astype(np.float64)
    return array[~np.isnan(array)]
