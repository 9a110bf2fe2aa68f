"""Tone curves, display encoding and constants."""

from __future__ import annotations

import numpy as np
import pytest
from shaders.harness import evaluate

INCLUDES = ["lib/color.glsl"]
# pow() of drivers: 5.5e-7 relative on llvmpipe, a few times that elsewhere.
TOLERANCE = 4e-6


def test_srgb_is_the_standard_and_meets_at_the_knee(gl, shaders):
    x = np.concatenate([np.linspace(0.0, 1.0, 1001), [0.0031308, 0.00313081]])
    found = evaluate(gl, shaders, INCLUDES, "srgb_encode(x)", {"x": x})[:, 0]
    wanted = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1.0 / 2.4) - 0.055)
    np.testing.assert_allclose(found, wanted, atol=TOLERANCE)
    assert found[0] == 0.0
    assert found[1000] == pytest.approx(1.0, abs=TOLERANCE)


def test_filmic_curve_is_narkowicz_fit(gl, shaders):
    radiance = np.concatenate([[0.0], np.geomspace(1e-6, 6e4, 400)])
    found = evaluate(gl, shaders, INCLUDES, "tone_curve_aces(vec3(x)).y", {"x": radiance})[:, 0]
    x = 0.6 * radiance
    wanted = np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0)
    np.testing.assert_allclose(found, wanted, rtol=TOLERANCE, atol=1e-9)
    assert np.all(np.diff(found) >= 0.0), "brighter must never look darker"


def test_whatever_comes_in_is_displayable(gl, shaders):
    x = np.array([np.nan, np.inf, -np.inf, -1.0, -0.0, 1e30, 3e38, 0.5])
    found = evaluate(gl, shaders, INCLUDES, "displayable(x)", {"x": x})[:, 0]
    assert found.tolist() == [0.0, 65504.0, 0.0, 0.0, 0.0, 65504.0, 65504.0, 0.5]
    shown = evaluate(
        gl, shaders, INCLUDES, "srgb_encode(tone_curve_aces(displayable(vec3(x))))", {"x": x}, 3
    )
    assert np.all(np.isfinite(shown))
    assert shown.min() >= 0.0
    assert shown.max() <= 1.0 + TOLERANCE


CONSTANTS = {
    "PI": np.pi,
    "TWO_PI": 2 * np.pi,
    "HALF_PI": np.pi / 2,
    "INV_PI": 1 / np.pi,
    "INV_TWO_PI": 0.5 / np.pi,
    "FLOAT_EPSILON": np.finfo(np.float32).eps,
    "FLOAT_MAX": np.finfo(np.float32).max,
}


@pytest.mark.parametrize("name", CONSTANTS)
def test_constant_is_the_nearest_float(gl, shaders, name):
    (value,) = evaluate(gl, shaders, ["lib/constants.glsl"], name, {"unused": np.ones(1)})[:, 0]
    assert value == np.float32(CONSTANTS[name])
