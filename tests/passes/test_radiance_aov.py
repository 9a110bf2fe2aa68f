"""Terms of the picture as radiance."""

from __future__ import annotations

import numpy as np
from passes.pass_harness import make_frame, make_scene, run_pass

from ssdo_gl.passes.radiance_aov import RadianceAovPass


def test_radiance_is_albedo_over_pi_times_irradiance(gl, shaders):
    rng = np.random.default_rng(1)
    albedo, irradiance = rng.uniform(0, 1, (6, 8, 4)), rng.uniform(0, 9, (6, 8, 4))
    aov = RadianceAovPass("bounce", ["bounce_irradiance"])
    assert aov.name == "bounce"
    frame = make_frame(make_scene(), (8, 6))
    inputs = {"albedo": albedo, "bounce_irradiance": irradiance}
    found = run_pass(gl, shaders, aov, frame, inputs)["bounce"]
    wanted = albedo[..., :3] / np.pi * irradiance[..., :3]
    # Albedo is 16-bit unorm: half a step is 8e-6, times at most 9 / pi.
    np.testing.assert_allclose(found[..., :3], wanted, atol=3e-5)
    np.testing.assert_allclose(found[..., 3], albedo[..., 3], atol=1e-5)


def test_terms_of_one_name_are_added_up(gl, shaders):
    rng = np.random.default_rng(2)
    first, second = rng.uniform(0, 9, (2, 6, 8, 4))
    aov = RadianceAovPass("specular", radiances=["direct_gloss", "sky_gloss"])
    inputs = {"albedo": np.ones((6, 8, 4)), "direct_gloss": first, "sky_gloss": second}
    found = run_pass(gl, shaders, aov, make_frame(make_scene(), (8, 6)), inputs)["specular"]
    np.testing.assert_allclose(found[..., :3], (first + second)[..., :3], rtol=1e-6)
