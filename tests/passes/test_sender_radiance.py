"""What surfaces send on: emission that no light delivers, and reflected light."""

from __future__ import annotations

import numpy as np
import pytest
from passes.estimator_cases import picture_frame
from passes.pass_harness import run_pass

from ssdo_gl.passes.sender_radiance import SenderRadiancePass
from ssdo_gl.passes.terms import SenderTerms

# A product and two sums of float32.
SUM_TOLERANCE = 1e-6


def sender_images(shape=(4, 5)):
    rng = np.random.default_rng(2)
    emission = np.concatenate([rng.random((*shape, 3)), rng.random((*shape, 1)) > 0.5], -1)
    albedo = np.concatenate([rng.random((*shape, 3)), np.ones((*shape, 1))], -1)
    albedo[0] = 0.0
    light = {
        name: rng.random((*shape, 4)) for name in ("direct_irradiance", "directional_irradiance")
    }
    return {"albedo": albedo, "emission": emission, **light}


@pytest.mark.parametrize("direct", [False, True])
@pytest.mark.parametrize("directional", [False, True])
def test_sender_radiance_adds_up(gl, shaders, direct, directional):
    images = sender_images()
    chosen = {"direct_irradiance": direct, "directional_irradiance": directional}
    render_pass = SenderRadiancePass(
        SenderTerms(tuple(n for n, is_in in chosen.items() if is_in), ("emission",))
    )
    frame = picture_frame((5, 4), 0.5)
    found = run_pass(
        gl, shaders, render_pass, frame, {name: images[name] for name in render_pass.reads}
    )["sender_radiance"]
    irradiance = (
        direct * images["direct_irradiance"] + directional * images["directional_irradiance"]
    )
    albedo = np.rint(images["albedo"] * 65535.0) / 65535.0
    lamp_free = images["emission"][..., :3] * (images["emission"][..., 3:] > 0.5)
    expected = lamp_free + albedo[..., :3] / np.pi * irradiance[..., :3]
    np.testing.assert_allclose(found[1:, :, :3], expected[1:], rtol=SUM_TOLERANCE, atol=1e-7)
    assert np.all(found[1:, :, 3] == 1.0)
    # Background sends nothing.
    assert np.all(found[0] == 0.0)


def test_an_irradiance_of_half_the_size_is_the_mean_of_the_four_pixels_around(gl, shaders):
    """Those nearest to the texel; beyond the border the last ones count again."""
    images = sender_images((6, 5))
    small = np.random.default_rng(3).random((3, 3, 4))
    images["directional_irradiance"] = small
    render_pass = SenderRadiancePass(SenderTerms(("direct_irradiance", "directional_irradiance")))
    frame = picture_frame((5, 6), 0.5)
    inputs = {name: images[name] for name in render_pass.reads}
    found = run_pass(gl, shaders, render_pass, frame, inputs)["sender_radiance"]
    mean = np.empty((6, 5, 3))
    for y, x in np.ndindex(6, 5):
        rows = [y // 2, np.clip(y // 2 + 2 * (y % 2) - 1, 0, 2)]
        columns = [x // 2, np.clip(x // 2 + 2 * (x % 2) - 1, 0, 2)]
        mean[y, x] = small[np.ix_(rows, columns)][..., :3].mean((0, 1))
    albedo = np.rint(images["albedo"] * 65535.0) / 65535.0
    expected = albedo[..., :3] / np.pi * (images["direct_irradiance"][..., :3] + mean)
    np.testing.assert_allclose(found[1:, :, :3], expected[1:], rtol=SUM_TOLERANCE, atol=1e-7)
