"""Highlights of small lights on finely curved metal: averaged over pixels, without specks."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scene_text import camera, light, material, quad

import ssdo_gl
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.geometry.mesh import Mesh
from ssdo_gl.scene.geometry.shapes import sphere

SIZE = (96, 72)
REST = (
    camera([0, 0, 4], [0, 0, 0], 30, exposure=0)
    + light("directional", direction=[-0.4, -0.8, -1], irradiance=[2, 2, 2], shadow="none")
    + light("point", position=[1.5, 1, 2.5], intensity=[4, 4, 4], shadow="none")
    + quad([-1.2, -0.9, 0], [2.4, 0, 0], [0, 1.8, 0], "m")
)
METAL = {"metallic": 1, "roughness": 0.1}
# Of the picture's width, in the world.
PIXEL = 8.0 * np.tan(np.radians(15.0)) / SIZE[1]


def rippled(period_px):
    """A bulging sheet with ripples that lean by up to 0.25."""
    k = 2.0 * np.pi / (period_px * PIXEL)
    x, y = np.meshgrid(np.linspace(-1.2, 1.2, 240), np.linspace(-0.9, 0.9, 180))
    u, v = k * (x + 0.3 * y), k * (y - 0.2 * x)
    bulge_x, bulge_y = np.cos(1.2 * x), np.cos(1.5 * y)
    z = 0.35 * bulge_x * bulge_y + 0.25 / k * np.sin(u) * np.sin(v)
    along_u, along_v = 0.25 * np.cos(u) * np.sin(v), 0.25 * np.sin(u) * np.cos(v)
    slope_x = -0.42 * np.sin(1.2 * x) * bulge_y + along_u - 0.2 * along_v
    slope_y = -0.525 * bulge_x * np.sin(1.5 * y) + 0.3 * along_u + along_v
    normals = np.stack([-slope_x, -slope_y, np.ones_like(x)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    corner = np.arange(x.size).reshape(x.shape)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]
    triangles = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    return Mesh(np.stack([x, y, z], axis=-1).reshape(-1, 3), triangles, normals.reshape(-1, 3))


def picture(mesh, footprint, *, finish=METAL, pan_px=0.0, **settings):
    scene = read_description(REST + material("m", 0.9, 0.8, 0.6, **finish), "scene.toml")
    place = pan_px * PIXEL
    camera = dataclasses.replace(scene.camera, position=(place, 0.0, 4.0), target=(place, 0.0, 0.0))
    scene = dataclasses.replace(scene, meshes=(mesh,), camera=camera)
    chosen = {"method": "direct", "aov": "specular"} | settings
    overrides = {"direct.gloss_footprint": footprint}
    found = ssdo_gl.render(scene, size=SIZE, overrides=overrides, **chosen)
    return np.asarray(found, np.float64)[..., :3]


@pytest.mark.parametrize(("period_px", "gains"), [(8.0, (0.5, 0.5)), (3.0, (0.75, 0.85))])
def test_finely_curved_metal_is_nearer_to_many_samples_at_rest_and_in_motion(period_px, gains):
    mesh = rippled(period_px)

    def panned(footprint, **settings):
        frames = [picture(mesh, footprint, pan_px=i / 3.0, **settings) for i in range(3)]
        # The sheet's rim, where pixels begin to show it, apart.
        return np.minimum(frames, 1.0)[:, 12:-12, 16:-16]

    many, centres, filtered = panned(0.0, antialias=16), panned(0.0), panned(1.0)
    for order, gain in enumerate(gains):
        errors = [
            np.sqrt(np.mean(np.diff(frames - many, order, axis=0) ** 2))
            for frames in (centres, filtered)
        ]
        assert errors[1] < gain * errors[0]


@pytest.mark.parametrize("roughness", [0.05, 0.1, 0.25])
def test_smooth_balls_keep_their_light_and_silhouettes_have_no_specks(roughness):
    finish = METAL | {"roughness": roughness}
    many, filtered = (
        picture(sphere(48), footprint, finish=finish, antialias=frames)
        for footprint, frames in ((0.0, 64), (1.0, 1))
    )
    # Without the filter 0.973 of it at roughness 0.1.
    assert filtered.sum() == pytest.approx(many.sum(), rel=0.015)
    # Where many samples are dark all around, so is one that is filtered.
    near = np.max([np.roll(many, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)], axis=0)
    assert np.all(filtered[near < 0.1] < 0.2)


@pytest.mark.parametrize(
    "settings", [{"method": "reference-near", "spp": 1}, {"finish": {}, "aov": "beauty"}]
)
def test_references_and_diffuse_surfaces_stay_as_they_are(settings):
    images = [picture(sphere(16), footprint, **settings) for footprint in (0.0, 1.0)]
    assert images[0].max() > 0.1
    np.testing.assert_array_equal(images[0], images[1])
