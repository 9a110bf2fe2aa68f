"""Draws a scene into a G-buffer, and finds by rays in float64 what must stand in it."""

from __future__ import annotations

import numpy as np
from oracle import analytic_pictures
from passes.pass_harness import make_frame, run_pass

from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.passes.gbuffer import GBufferPass

SIZE = (64, 48)


# Octahedral 16-bit codes: 0.0037 degrees (6.5e-5) at worst, measured over 1e6 normals.
NORMAL_TOLERANCE = 7e-5


def draw(gl, shaders, scene, size=SIZE, **more):
    geometry = Geometry(gl, scene)
    frame = make_frame(scene, size, geometry=geometry, **more)
    item = GBufferPass()
    images = run_pass(gl, shaders, item, frame, geometry=geometry)
    has_holes = any(material.has_holes for material in scene.materials)
    is_seen = images["z_vs"].any()
    assert not is_seen or item.is_computed == (shaders.computes and not has_holes)
    geometry.release()
    return frame, images


def normals(images):
    codes = np.rint(images["normals_vs"].astype(np.float64) * 65535.0)
    shading, geometric = codes[..., :2], codes[..., 2:]
    return analytic_pictures.oct_decode(shading), analytic_pictures.oct_decode(geometric)


def rays_of(frame):
    """Rays through pixel centres at depth 1, top row first; from the jittered frame."""
    rays = analytic_pictures.view_rays(frame.view.size, frame.view.tan_half_fov)[::-1].copy()
    rays[..., :2] += np.array(frame.view.jitter_ndc) * frame.view.tan_half_fov
    return rays


def barycentric(p, a, b, c):
    """Return the weights of corners a, b and c in points p of their planes."""
    n = np.cross(b - a, c - a)
    parts = np.cross(c - b, p - b), np.cross(a - c, p - c), np.cross(b - a, p - a)
    return np.stack([np.sum(part * n, -1) / np.sum(n * n, -1) for part in parts], -1)


def nearest(rays, triangles):
    """Return distance (inf where missed), triangle and barycentric weights of each ray."""
    distance = np.full(len(rays), np.inf)
    index = np.zeros(len(rays), int)
    weights = np.zeros((len(rays), 3))
    for i, (a, b, c) in enumerate(triangles):
        n = np.cross(b - a, c - a)
        with np.errstate(divide="ignore"):
            t = (a @ n) / (rays @ n)
        p = rays * t[:, None]
        w = barycentric(p, a, b, c)
        hit = (w.min(-1) >= 0.0) & (t > 0.0) & (t < distance)
        distance[hit], index[hit], weights[hit] = t[hit], i, w[hit]
    return distance, index, weights
