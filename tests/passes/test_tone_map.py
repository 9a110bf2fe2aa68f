"""From radiance to the bytes of a picture."""

from __future__ import annotations

import numpy as np
import pytest
from passes.pass_harness import make_frame, make_scene, run_pass

from ssdo_gl.passes.tone_map import CURVES, ToneMapPass, ToneMapSettings

SIZE = (64, 2)
# Half a step of 16 bits, and the shader's pow().
TOLERANCE = 0.5 / 65535.0 + 4e-6


def show(gl, shaders, radiance, **settings):
    beauty = np.zeros((SIZE[1], SIZE[0], 4))
    beauty[..., :3] = radiance
    tone_map = ToneMapPass(ToneMapSettings(**settings))
    frame = make_frame(make_scene(), SIZE)
    return run_pass(gl, shaders, tone_map, frame, {"beauty": beauty})["display"]


def encode(x):
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1.0 / 2.4) - 0.055)


@pytest.mark.parametrize("exposure", [-2.0, 0.0, 3.5])
def test_curves(gl, shaders, exposure):
    radiance = np.geomspace(1e-4, 1e3, 64 * 2 * 3).reshape(SIZE[1], SIZE[0], 3)
    x = radiance * 2.0**exposure
    plain = show(gl, shaders, radiance, exposure=exposure, curve="plain")
    np.testing.assert_allclose(plain[..., :3], encode(np.minimum(x, 1.0)), atol=TOLERANCE)
    y = 0.6 * x
    wanted = encode(np.clip(y * (2.51 * y + 0.03) / (y * (2.43 * y + 0.59) + 0.14), 0.0, 1.0))
    filmic = show(gl, shaders, radiance, exposure=exposure, curve="aces")
    np.testing.assert_allclose(filmic[..., :3], wanted, atol=TOLERANCE)
    assert np.all(plain[..., 3] == 1.0)


@pytest.mark.parametrize("curve", CURVES)
def test_no_pixel_can_spoil_the_picture(gl, shaders, curve):
    radiance = np.zeros((SIZE[1], SIZE[0], 3))
    radiance[0, :5, 0] = np.nan, np.inf, -np.inf, -1.0, 3e38
    shown = show(gl, shaders, radiance, curve=curve, exposure=16.0)
    assert shown[0, :5, 0].tolist() == [0.0, 1.0, 0.0, 0.0, 1.0]
    assert np.all(shown[..., 1:3] == 0.0)
