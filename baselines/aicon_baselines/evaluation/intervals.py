"""Confidence intervals of a share and of a mean difference, both from SciPy."""

from functools import cache

import numpy as np
import scipy  # loads its parts where they are used
from numpy.typing import NDArray

_RESAMPLES = 5000


@cache  # a success curve asks for the same few shares again and again
def wilson_interval(successes: int, trials: int) -> tuple[float, float]:
    """Return Wilson's score interval of a success rate, of 95 %.

    (p + z²/2n ± z √(p(1 − p)/n + z²/4n²)) / (1 + z²/n), where p = successes / n and z is the normal
    quantile (E. B. Wilson, Journal of the American Statistical Association 22, 1927). It treats
    trials as independent, which several repeats of one map are not quite.

    Raises:
        ValueError: If there are no trials, or more successes than trials or fewer than none.
    """
    if not 0 <= successes <= trials or trials == 0:
        raise ValueError(
            f"{successes} successes in {trials} trials are no success rate: it needs at least one "
            "trial, and from 0 to as many successes"
        )

    test = scipy.stats.binomtest(successes, trials)
    interval = test.proportion_ci(method="wilson")
    return float(interval.low), float(interval.high)


def bootstrap_interval(differences: NDArray[np.float64]) -> tuple[float, float]:
    """Return the middle 95 % of the means of n differences drawn from these n, with repetition.

    (B. Efron, The Annals of Statistics 7, 1979.) Always the same draws, so that the numbers can be
    computed again. Where all n are equal the interval has no width, and says nothing about rarer
    episodes.
    """
    # SciPy wants two: one alone says nothing about its spread.
    if len(differences) == 1:
        return float(differences[0]), float(differences[0])

    result = scipy.stats.bootstrap(
        (differences,),
        np.mean,
        n_resamples=_RESAMPLES,
        confidence_level=0.95,
        method="percentile",
        rng=np.random.default_rng(0),
    )
    interval = result.confidence_interval
    return float(interval.low), float(interval.high)
