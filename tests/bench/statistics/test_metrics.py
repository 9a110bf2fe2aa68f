"""Each metric against numbers worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ssdo_gl.bench.statistics import metrics

# FLIP works in float32 and its means agree to six digits between systems (its precision
# note); differences of a few 1e-6 mean nothing.
FLIP_TOLERANCE = 1e-5


def grey(level: float, size: tuple[int, int] = (24, 24)) -> np.ndarray:
    return np.full((*size, 3), level, dtype=np.float32)


def test_display_encoding():
    ramp = np.array([[[0.0] * 3, [0.0031308] * 3, [0.18] * 3, [1.0] * 3, [7.0] * 3]])
    # IEC 61966-2-1: 0.0031308 is where the curve starts; 18 % grey is 0.461.
    expected = [0.0, 0.0404499, 0.4613561, 1.0, 1.0]
    np.testing.assert_allclose(metrics.srgb_of(ramp)[0, :, 0], expected, atol=1e-6)
    np.testing.assert_allclose(metrics.srgb_of(ramp / 4, 2.0), metrics.srgb_of(ramp), atol=1e-6)
    broken = ramp.copy()
    broken[0, 1, 0] = np.nan
    np.testing.assert_array_equal(metrics.srgb_of(broken)[0, 1], [1.0, 0.0, 1.0])


def test_ssim_of_two_flat_images_is_its_luminance_term():
    pytest.importorskip("skimage")
    mask = np.ones((24, 24), dtype=bool)
    a, b = 0.2, 0.6
    # Without variance SSIM is (2ab + C1) / (a^2 + b^2 + C1), C1 = (0.01 * range)^2.
    expected = (2 * a * b + 1e-4) / (a * a + b * b + 1e-4)
    assert metrics.ssim(grey(a), grey(b), mask) == pytest.approx(expected, abs=1e-5)
    assert metrics.ssim(grey(a), grey(a), mask) == pytest.approx(1.0, abs=1e-9)
    assert math.isnan(metrics.ssim(grey(a, (8, 8)), grey(b, (8, 8)), mask[:8, :8]))


def test_flip_sees_no_difference_where_there_is_none_and_a_full_one_in_black_and_white():
    pytest.importorskip("flip_evaluator")
    mask = np.ones((24, 24), dtype=bool)
    assert metrics.flip_ldr(grey(0.5), grey(0.5), mask).mean == pytest.approx(0, abs=FLIP_TOLERANCE)
    # Black against white is the largest colour difference FLIP maps: it gives 0.97 to 1.
    assert metrics.flip_ldr(grey(0.0), grey(1.0), mask).mean > 0.95
    assert metrics.flip_hdr(grey(3.0), grey(3.0), mask).mean == pytest.approx(0, abs=FLIP_TOLERANCE)


def test_flip_exposures_are_fixed_relative_to_the_camera():
    pytest.importorskip("flip_evaluator")
    rng = np.random.default_rng(3)
    mask = np.ones((32, 32), dtype=bool)
    reference = rng.random((32, 32, 3)).astype(np.float32)
    other = reference + np.float32(0.2)
    plain = metrics.flip_hdr(other, reference, mask)
    assert metrics.flip_hdr(other * 16, reference * 16, mask, exposure_ev=-4).mean == pytest.approx(
        plain.mean, abs=FLIP_TOLERANCE
    )
    assert metrics.flip_hdr(other * 16, reference * 16, mask).mean != pytest.approx(
        plain.mean, abs=1e-3
    ), "the exposures must not follow the image"
    assert metrics.flip_hdr(other, reference, np.eye(32, dtype=bool)).mean == pytest.approx(
        float(plain.error[np.eye(32, dtype=bool)].mean()), abs=FLIP_TOLERANCE
    )


def test_flip_gets_exactly_the_fixed_exposures():
    flip_evaluator = pytest.importorskip("flip_evaluator")
    rng = np.random.default_rng(5)
    reference, image = (rng.random((32, 32, 3)).astype(np.float32) * 4 for _ in range(2))
    parameters = {"ppd": 67.0, "startExposure": -4.0, "stopExposure": 2.0, "numExposures": 7,
                  "tonemapper": "ACES"}  # fmt: skip
    _, expected, _ = flip_evaluator.evaluate(
        reference, image, "HDR", applyMagma=False, parameters=parameters
    )
    found = metrics.flip_hdr(image, reference, np.ones((32, 32), dtype=bool))
    assert found.mean == pytest.approx(expected, abs=FLIP_TOLERANCE)


def test_a_failure_is_the_largest_flip_error():
    pytest.importorskip("flip_evaluator")
    broken = grey(0.5)
    broken[3, 4, 0] = np.nan
    result = metrics.flip_ldr(broken, grey(0.5), np.ones((24, 24), dtype=bool))
    assert result.error[3, 4] == 1.0
    assert np.isfinite(result.error).all()


def test_a_missing_library_names_the_extra(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "flip_evaluator", None)
    with pytest.raises(metrics.MissingLibraryError, match=r"pip install 'ssdo_gl\[bench\]'"):
        metrics.flip_ldr(grey(0), grey(0), np.ones((24, 24), dtype=bool))


def test_noise_and_bias_are_told_apart():
    rng = np.random.default_rng(4)
    shape, noise, offset = (100, 100, 1), 0.3, 0.2
    reference = np.ones(shape)
    images = [reference + offset + rng.normal(0, noise, shape) for _ in range(4)]
    mask = np.ones(shape[:2], dtype=bool)
    parts = metrics.decompose(images, reference, mask)
    # Standard deviations of 30 000 and 10 000 normal draws: under 1 % relative.
    assert parts.noise == pytest.approx(noise, rel=0.02)
    assert parts.bias == pytest.approx(offset, rel=0.04)
    assert parts.total**2 == pytest.approx(parts.noise**2 + parts.bias**2, rel=0.02)
    alone = metrics.decompose(images[:1], reference, mask)
    assert math.isnan(alone.noise)
    assert alone.bias == alone.total
