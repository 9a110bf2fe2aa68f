"""The Pareto front against brute force, and membership under noise."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssdo_gl.bench.statistics import pareto

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
