"""The acceptance test itself: it accepts what is right and refuses what is not."""

from __future__ import annotations

import numpy as np
import pytest
from oracle.monte_carlo import (
    chi_square_quantile,
    sidak_level,
    student_quantile,
    two_sample_deviation,
    worst_deviation,
)


@pytest.mark.parametrize(
    ("level", "degrees", "quantile"),
    # Tables of Student's distribution; the last from its closed form for many digits.
    [(0.05, 31, 2.0395), (0.01, 15, 2.9467), (0.001, 63, 3.4513), (1e-6, 31, 6.0535)],
)
def test_quantiles_are_those_of_the_tables(level: float, degrees: int, quantile: float) -> None:
    assert student_quantile(level, degrees) == pytest.approx(quantile, rel=5e-3)


@pytest.mark.parametrize(
    ("level", "degrees", "quantile"),
    [(0.05, 100, 124.342), (0.01, 100, 135.807), (0.001, 100, 149.449)],
)
def test_chi_square_quantiles_too(level: float, degrees: int, quantile: float) -> None:
    assert chi_square_quantile(level, degrees) == pytest.approx(quantile, rel=1e-3)


def test_sidak_levels_compound_to_the_significance() -> None:
    assert 1.0 - (1.0 - sidak_level(0.01, 300)) ** 300 == pytest.approx(0.01)


def test_right_estimates_are_refused_as_often_as_asked() -> None:
    rng = np.random.default_rng(5)
    refused = [
        worst_deviation(rng.normal(2.0, 0.5, (32, 40)), 2.0, significance=0.1) > 1.0
        for _ in range(400)
    ]
    # 40 expected of 400; five standard deviations of 6 either way.
    assert 10 <= sum(refused) <= 70


def test_a_small_bias_is_found() -> None:
    rng = np.random.default_rng(6)
    runs = rng.normal(1.0, 0.01, (64, 200))
    assert worst_deviation(runs, 1.0) <= 1.0
    runs[:, 17] += 0.01
    assert worst_deviation(runs, 1.0) > 1.0
    assert worst_deviation(runs, 1.0, allowance=0.01) <= 1.0
    assert two_sample_deviation(runs, rng.normal(1.0, 0.01, (64, 200))) > 1.0


def test_exact_values_must_be_right() -> None:
    assert worst_deviation(np.full((16, 3), 0.25), 0.25) <= 1.0
    assert worst_deviation(np.full((16, 3), 0.25), 0.2501) > 1.0
