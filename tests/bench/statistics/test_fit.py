"""Fits of cost and error laws on data whose law is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ssdo_gl.bench.statistics.fit import fit_power_law


def test_an_exact_power_law_is_found():
    x = [1.0, 2.0, 8.0, 64.0]
    law = fit_power_law(x, [3.0 * v**-0.5 for v in x])
    assert law is not None
    assert law.exponent == pytest.approx(-0.5, abs=1e-12)
    assert law.factor == pytest.approx(3.0, rel=1e-12)
    assert law.standard_error == pytest.approx(0.0, abs=1e-9)
    assert str(law) == "-0.50 ± 0.00"


def test_the_standard_error_is_the_scatter_of_the_exponent():
    rng = np.random.default_rng(0)
    x = np.geomspace(1, 256, 9)
    laws = [fit_power_law(x, x * np.exp(rng.normal(0, 0.1, 9))) for _ in range(400)]
    exponents = [law.exponent for law in laws]
    assert np.mean(exponents) == pytest.approx(1.0, abs=0.01)
    # Root mean square of the stated errors; 400 fits know the scatter to 4 %.
    stated = math.sqrt(np.mean([law.standard_error**2 for law in laws]))
    assert stated == pytest.approx(np.std(exponents), rel=0.15)


def test_what_has_no_logarithm_is_left_out():
    law = fit_power_law([1, 2, 4, 8, 16], [1, 2, math.nan, 0.0, 16])
    assert law is not None
    assert law.exponent == pytest.approx(1.0)
    assert fit_power_law([1, 2, 4], [1, 2, 0]) is None
    assert fit_power_law([2, 2, 2], [1, 2, 3]) is None
