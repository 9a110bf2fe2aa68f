"""Runs the edge-aware filter on an image over a picture made by hand."""

from __future__ import annotations

import numpy as np
from passes.estimator_cases import (
    inputs_of,
    picture_frame,
    tilted_plane,
)
from passes.pass_harness import run_pass

from ssdo_gl.passes.edge_aware_filter import (
    EdgeAwareFilterPass,
    EdgeAwareFilterSettings,
    Signal,
)

SIZE = (48, 36)
TAN_Y = 0.5
# Weighted means of some 50 float32 values.
MEAN_TOLERANCE = 5e-6


def run(
    gl,
    shaders,
    picture,
    raw,
    *,
    visibility=False,
    holds_z=False,
    scale=1,
    has_rays=False,
    **settings,
):
    """Filter an image with row 0 at the bottom; return the same."""
    size = picture.z.shape[1], picture.z.shape[0]
    frame = picture_frame(size, picture.tan_half_fov[1], near=picture.near)
    render_pass = EdgeAwareFilterPass(
        "filter",
        EdgeAwareFilterSettings(**settings),
        Signal("raw", "smooth", visibility, holds_z),
        parts_edges=has_rays,
    )
    images = inputs_of(picture)
    raw = np.asarray(raw, np.float64)
    if holds_z:
        raw = np.concatenate([raw, picture.z[::scale, ::scale, None]], -1)
    inputs = {"raw": raw[::-1], "z_vs": images["z_vs"], "normals_vs": images["normals_vs"]}
    return run_pass(gl, shaders, render_pass, frame, inputs)["smooth"][::-1]


def tan_half(size=SIZE):
    return picture_frame(size, TAN_Y).view.tan_half_fov


def plane(degrees=0.0, size=SIZE):
    return tilted_plane(degrees, size, tan_half(size))


def halves(left, right, channels=4, size=SIZE):
    image = np.where(np.arange(size[0]) < size[0] // 2, left, right)
    return np.broadcast_to(image[None, :, None], (size[1], size[0], channels))
