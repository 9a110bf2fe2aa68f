"""Batches of inputs for shader stages, whose seeds, ranges and edges hypothesis draws.

One example is a whole array, so that a stage meets 1e5 inputs in one draw call; what
hypothesis searches, and shrinks, are the few numbers that describe the array.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from shaders.harness import unit

COUNT = 100_000
# One in so many inputs is an edge.
EDGE_SHARE = 50


def float32(values):
    """Return float64 numbers that float32 holds exactly."""
    return np.asarray(values, np.float32).astype(np.float64)


def batches(examples=12, **strategies):
    """Run a test for some drawn batches.

    Fixtures hold a device and a table, which examples may share.
    """
    checks = HealthCheck
    quiet = [checks.function_scoped_fixture, checks.too_slow, checks.large_base_example]

    def decorate(test):
        # Shrinking runs a batch hundreds of times; the first failure says enough.
        phases = (Phase.explicit, Phase.generate)
        limit = settings(max_examples=examples, suppress_health_check=quiet, phases=phases)
        return limit(given(**strategies)(test))

    return decorate


@dataclass(frozen=True)
class Numbers:
    """Positive float32 numbers, uniform in the logarithm, with edges among them."""

    seed: int
    powers: tuple[float, float]
    edges: tuple[float, ...]

    def array(self, *shape):
        rng = np.random.default_rng(self.seed)
        values = 10.0 ** rng.uniform(*sorted(self.powers), shape)
        if self.edges:
            where = rng.random(shape) < 1.0 / EDGE_SHARE
            values = np.where(where, rng.choice(self.edges, shape), values)
        return float32(values)

    def signed(self, *shape):
        signs = np.random.default_rng(self.seed ^ 1).choice([-1.0, 1.0], shape)
        return self.array(*shape) * signs


SEEDS = st.integers(0, 2**32 - 1)


def numbers(low, high, edges=()):
    """Draw `Numbers` between the powers `low` and `high` of ten."""
    power = st.floats(low, high) | st.sampled_from([low, high])
    edge = st.floats(10.0**low, 10.0**high, allow_subnormal=False)
    some = st.lists(st.sampled_from(edges) | edge if edges else edge, max_size=8)
    return st.builds(Numbers, SEEDS, st.tuples(power, power), some.map(tuple))


@dataclass(frozen=True)
class Directions:
    """Unit vectors: anywhere, near axes and planes of two axes, near diagonals."""

    seed: int
    offsets: tuple[float, ...]

    def array(self, count=COUNT):
        rng = np.random.default_rng(self.seed)
        anywhere = unit(rng.normal(size=(count - 2 * (count // 5), 3)))
        parts = [anywhere]
        for corners in (np.eye(3), unit(np.array([(1, 1, 0), (0, 1, 1), (1, 0, 1), (1, 1, 1)]))):
            some = corners[rng.integers(0, len(corners), count // 5)]
            some = some + rng.choice((0.0, *self.offsets), some.shape)
            parts.append(unit(some) * rng.choice([-1.0, 1.0], some.shape))
        return float32(np.concatenate(parts))


def directions():
    """Draw `Directions` whose offsets from axes range from denormal squares to visible."""
    offset = st.floats(-20.0, -1.0).map(lambda power: 10.0**power)
    return st.builds(Directions, SEEDS, st.lists(offset, min_size=1, max_size=6).map(tuple))


@dataclass(frozen=True)
class Squares:
    """Points of [0, 1)^2, its corners and what lies next to them."""

    seed: int
    least: float

    def array(self, count=COUNT):
        rng = np.random.default_rng(self.seed)
        top = 1.0 - 2.0**-24
        u = rng.uniform(0.0, 1.0, (count, 2))
        u[:4] = (0.0, 0.0), (top, top), (0.0, top), (top, 0.0)
        u[4:1000, 0] = 10.0 ** rng.uniform(self.least, 0.0, 996)
        u[1000:2000, 1] = 10.0 ** rng.uniform(self.least, 0.0, 1000)
        u[2000:3000] = 1.0 - 10.0 ** rng.uniform(-7.2, -3.0, (1000, 2))
        return float32(np.minimum(u, top))


def squares():
    """Draw `Squares`."""
    return st.builds(Squares, SEEDS, st.floats(-30.0, -3.0))
