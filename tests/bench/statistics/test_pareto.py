"""The Pareto front against brute force, and under noise; fits of laws that are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssdo_gl.bench.statistics import pareto
from ssdo_gl.bench.statistics.fit import fit_power_law

# Few distinct values, so that ties are common.
coordinate = st.integers(0, 6).map(float)
values = st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=12)


def brute_force(times: list[float], errors: list[float]) -> set[int]:
    """Return the members by comparing every pair: first of exact ties."""
    members = set()
    for i, (t, e) in enumerate(zip(times, errors, strict=True)):
        beaten = any(
            (u <= t and f <= e and (u < t or f < e)) or (u == t and f == e and j < i)
            for j, (u, f) in enumerate(zip(times, errors, strict=True))
        )
        if not beaten:
            members.add(i)
    return members


@given(values)
def test_the_front_is_what_no_other_point_beats(points):
    times, errors = (list(column) for column in zip(*points, strict=True))
    found = pareto.pareto_front(times, errors)
    assert set(found.tolist()) == brute_force(times, errors)
    assert all(np.diff(np.asarray(times)[found]) > 0)
    assert all(np.diff(np.asarray(errors)[found]) < 0)


def test_a_failed_setting_is_never_a_member():
    assert pareto.pareto_front([1.0, 2.0, math.nan], [math.inf, 1.0, 0.1]).tolist() == [1]
    assert pareto.pareto_front([1.0], [math.inf]).tolist() == []


def test_membership_is_a_share_of_the_replicas():
    rng = np.random.default_rng(0)
    count = 2000
    times = np.tile([1.0, 2.0, 3.0], (count, 1))
    errors = np.stack(
        [np.full(count, 3.0), np.full(count, 2.0), rng.normal(2.0, 0.1, count)], axis=1
    )
    share = pareto.membership(times, errors)
    assert share[0] == share[1] == 1.0
    # The third is slower; it belongs where its error happens to be lower: half the time.
    assert share[2] == pytest.approx(0.5, abs=0.05)


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
