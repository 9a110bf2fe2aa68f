"""One irradiance as radiance."""

from __future__ import annotations

import numpy as np
from passes.pass_harness import make_frame, make_scene, run_pass

from ssdo_gl.passes.radiance_aov import RadianceAovPass


def test_radiance_is_albedo_over_pi_times_irradiance(gl, shaders):
    rng = np.random.default_rng(1)
    albedo, irradiance = rng.uniform(0, 1, (6, 8, 4)), rng.uniform(0, 9, (6, 8, 4))
    aov = RadianceAovPass("bounce_irradiance", "bounce")
    assert aov.name == "bounce"
    frame = make_frame(make_scene(), (8, 6))
    inputs = {"albedo": albedo, "bounce_irradiance": irradiance}
    found = run_pass(gl, shaders, aov, frame, inputs)["bounce"]
    wanted = albedo[..., :3] / np.pi * irradiance[..., :3]
    # Albedo is 16-bit unorm: half a step is 8e-6, times at most 9 / pi.
    np.testing.assert_allclose(found[..., :3], wanted, atol=3e-5)
    np.testing.assert_allclose(found[..., 3], albedo[..., 3], atol=1e-5)
