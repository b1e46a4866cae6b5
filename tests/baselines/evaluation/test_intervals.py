"""Confidence intervals, against published numbers, formulas and theory."""

from math import sqrt
from statistics import NormalDist

import numpy as np
import pytest

from aicon_baselines.evaluation.intervals import bootstrap_interval, wilson_interval


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """The formula of the docstring."""
    z = NormalDist().inv_cdf(0.975)
    rate, spread = successes / trials, z * z / trials
    middle = rate + spread / 2
    half = sqrt(spread * (rate * (1 - rate) + spread / 4))
    return (middle - half) / (1 + spread), (middle + half) / (1 + spread)


def test_wilson_interval_against_published_numbers() -> None:
    # Newcombe, Statistics in Medicine 17 (1998), table I, method 3.
    for successes, trials, low, high in (
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0, 0.1611),
        (29, 29, 0.8830, 1.0),
    ):
        assert wilson_interval(successes, trials) == pytest.approx((low, high), abs=5e-5)


@pytest.mark.parametrize("trials", [1, 2, 17, 100, 500])
def test_wilson_interval_is_its_formula(trials: int) -> None:
    for successes in range(0, trials + 1, max(1, trials // 20)):
        interval = wilson_interval(successes, trials)
        assert interval == pytest.approx(wilson(successes, trials), rel=0, abs=1e-12)


@pytest.mark.parametrize(("successes", "trials"), [(3, 2), (0, 0), (-1, 2)])
def test_no_share_has_no_interval(successes: int, trials: int) -> None:
    with pytest.raises(ValueError, match=f"{successes} successes in {trials} trials"):
        wilson_interval(successes, trials)


def test_bootstrap_interval_of_a_large_sample_is_the_normal_one() -> None:
    sample = np.random.default_rng(1).normal(0.3, 2.0, 1000)
    half = 1.96 * sample.std() / sqrt(1000)
    expected = (sample.mean() - half, sample.mean() + half)
    assert bootstrap_interval(sample) == pytest.approx(expected, abs=0.02)


def test_bootstrap_draws_are_always_the_same() -> None:
    sample = np.random.default_rng(2).normal(size=50)
    generator = np.random.default_rng(0)
    means = [generator.choice(sample, len(sample)).mean() for _ in range(5000)]

    expected = np.quantile(means, [0.025, 0.975])
    assert bootstrap_interval(sample) == pytest.approx(tuple(expected), rel=0, abs=1e-12)
    assert bootstrap_interval(sample) == bootstrap_interval(sample.copy())


def test_where_nothing_differs_the_interval_has_no_width() -> None:
    for count in (1, 5):
        assert bootstrap_interval(np.full(count, 0.25)) == (0.25, 0.25)
