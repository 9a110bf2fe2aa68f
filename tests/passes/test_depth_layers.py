"""Fronts and backs side by side."""

from __future__ import annotations

import numpy as np
from passes.estimator_cases import picture_frame
from passes.pass_harness import run_pass

from ssdo_gl.passes.depth_layers import DepthLayersPass


def test_layers_are_packed_unchanged(gl, shaders):
    rng = np.random.default_rng(1)
    z, back = (rng.random((5, 7, 1)).astype(np.float32) * 10.0 for _ in range(2))
    frame = picture_frame((7, 5), 0.5)
    found = run_pass(gl, shaders, DepthLayersPass(), frame, {"z_vs": z, "z_back_vs": back})
    np.testing.assert_array_equal(found["z_layers"], np.concatenate([z, back], -1))
