"""Errors against numbers worked out by hand, and what must hold for all images."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ssdo_gl.images import error

# Means of float32 images are formed in float64: only the input's rounding is left.
FLOAT32 = 1e-6

ALL = np.ones((2, 2), dtype=bool)


def image(*values: float) -> np.ndarray:
    """Return a 2x2 image with one channel."""
    return np.array(values, dtype=np.float32).reshape(2, 2, 1)


def grey(level: float, size: tuple[int, int] = (24, 24)) -> np.ndarray:
    return np.full((*size, 3), level, dtype=np.float32)


IMAGE, REFERENCE = image(1.0, 2.0, 3.0, 4.0), image(1.0, 1.0, 1.0, 1.0)


def test_errors_worked_out_by_hand():
    # Errors 0, 1, 2, 3: squares 0 + 1 + 4 + 9 = 14 over 4 pixels.
    assert error.rmse(IMAGE, REFERENCE, ALL) == pytest.approx(math.sqrt(3.5), rel=FLOAT32)
    assert error.bias(IMAGE, REFERENCE, ALL) == pytest.approx(1.5, rel=FLOAT32)
    assert error.relative_rmse(IMAGE, 2 * REFERENCE, ALL) == pytest.approx(
        math.sqrt((1 + 0 + 1 + 4) / 4) / 2, rel=FLOAT32
    )
    assert error.relative_mse(IMAGE, REFERENCE, ALL) == pytest.approx(3.5 / 1.01, rel=FLOAT32)
    assert error.relative_mse(IMAGE, REFERENCE, ALL, epsilon=1.0) == pytest.approx(
        1.75, rel=FLOAT32
    )


def test_the_mask_says_which_pixels_count():
    mask = np.array([[False, True], [False, True]])
    assert error.rmse(IMAGE, REFERENCE, mask) == pytest.approx(math.sqrt((1 + 9) / 2), rel=FLOAT32)
    assert error.bias(IMAGE, REFERENCE, mask) == pytest.approx(2.0, rel=FLOAT32)
    assert error.rmse(IMAGE, REFERENCE, np.zeros((2, 2), dtype=bool)) == 0.0


def test_channels_are_averaged_not_summed():
    three = np.concatenate([IMAGE, REFERENCE, REFERENCE], axis=2)
    reference = np.concatenate([REFERENCE, REFERENCE, REFERENCE], axis=2)
    assert error.rmse(three, reference, ALL) == pytest.approx(math.sqrt(3.5 / 3), rel=FLOAT32)


def test_the_noise_of_the_reference_is_subtracted():
    variance = np.full((2, 2, 1), 1.5)
    assert error.rmse(IMAGE, REFERENCE, ALL, variance) == pytest.approx(math.sqrt(2.0), rel=FLOAT32)
    assert error.rmse(REFERENCE, REFERENCE, ALL, variance) == 0.0, "a negative mean square is zero"


def test_subtracting_the_variance_of_two_halves_is_their_cross_product():
    rng = np.random.default_rng(1)
    x, a, b = (rng.random((2, 2, 1)) for _ in range(3))
    mean, variance = (a + b) / 2, (a - b) ** 2 / 4
    np.testing.assert_allclose(
        error.squared_error(x, mean, variance), ((x - a) * (x - b))[:, :, 0], rtol=1e-12
    )


def test_subtraction_makes_the_error_unbiased_against_a_noisy_reference():
    rng = np.random.default_rng(2)
    shape, sigma, offset = (200, 200, 1), 0.5, 0.1
    halves = rng.normal(1.0, sigma, size=(2, *shape))
    reference, variance = halves.mean(axis=0), (halves[0] - halves[1]) ** 2 / 4
    estimate = np.full(shape, 1.0 + offset)
    mask = np.ones(shape[:2], dtype=bool)
    # The mean of (x-a)(x-b) over 40 000 pixels scatters by about sigma^2 / 200 = 1.3e-3;
    # five times that. Without the subtraction it would be off by sigma^2 / 2 = 0.125.
    assert error.rmse(estimate, reference, mask, variance) ** 2 == pytest.approx(
        offset**2, abs=6.5e-3
    )


@pytest.mark.parametrize("poison", [np.nan, np.inf, -np.inf])
def test_failures_are_counted_and_never_dropped(poison):
    broken = np.concatenate([IMAGE, REFERENCE, REFERENCE], axis=2)
    reference = np.ones_like(broken)
    broken[0, 1, 2] = poison
    assert error.failures(broken).sum() == 1
    assert error.rmse(broken, reference, ALL) == math.inf
    assert error.bias(broken, reference, ALL) == math.inf
    assert error.relative_mse(broken, reference, ALL) == math.inf
    assert error.relative_rmse(broken, reference, ALL) == math.inf


def test_a_failure_counts_even_where_the_variance_hides_it():
    broken = image(np.inf, 1, 1, 1)
    assert error.rmse(broken, REFERENCE, ALL, np.full((2, 2, 1), np.float32(3e38))) == math.inf


def test_a_black_reference_leaves_no_relative_error_but_zero_or_infinity():
    assert error.relative_rmse(0 * REFERENCE, 0 * REFERENCE, ALL) == 0.0
    assert error.relative_rmse(REFERENCE, 0 * REFERENCE, ALL) == math.inf


finite_images = arrays(
    np.float32, (3, 4, 3), elements=st.floats(0, 1e3, width=32, allow_subnormal=False)
)
WHOLE = np.ones((3, 4), dtype=bool)


@given(finite_images, finite_images)
@settings(max_examples=50, deadline=None)
def test_properties_of_the_mean_errors(x, reference):
    found = error.rmse(x, reference, WHOLE)
    assert error.rmse(reference, reference, WHOLE) == 0.0
    assert found == pytest.approx(error.rmse(reference, x, WHOLE), rel=1e-9)
    assert abs(error.bias(x, reference, WHOLE)) <= found * (1 + 1e-9)
    assert error.rmse(2 * x, 2 * reference, WHOLE) == pytest.approx(2 * found, rel=1e-6)
    assert error.relative_mse(x, reference, WHOLE) >= 0.0
