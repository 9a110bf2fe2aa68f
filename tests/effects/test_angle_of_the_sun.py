"""Directional lights with an angle: penumbrae against closed forms, by map and by rays.

Light strays evenly over a disk of radius tan(angle / 2), so an edge at height h darkens a
plane across the light by the share of a disk of radius r = h tan(angle / 2) that it hides.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hard_cases.hard_scene import quad
from hard_cases.methods import render
from hard_cases.test_depth import with_meshes

from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.lights import DirectionalLight
from ssdo_gl.scene.material import Material

HEIGHT = 0.5
FLOOR = quad((-2, 0, 2), (4, 0, 0), (0, 0, -4))
EDGE = quad((-2, HEIGHT, -2), (0, 0, 4), (2, 0, 0))  # covers x < 0
CAMERA = Camera((0.0, 0.9 * HEIGHT, 0.0), (0, 0, 0), up=(0, 0, -1), fov_y=60.0)
SUN = DirectionalLight((0.0, -1.0, 0.0), (1.0, 1.0, 1.0))


def lit(device, shaders, light, *meshes, shadows="map", method="direct", camera=CAMERA, **more):
    """Return irradiance of `light` and where, from images of floor and other meshes."""
    scene = with_meshes(*meshes, camera=camera, lights=(light,), environment=None)
    image = {"direct": "direct", "reference-gi": "beauty"}[method]
    options = {"images": (image, "position_ws"), "shadows": shadows, "shadow_rays": 256, **more}
    images = render(device, shaders, scene, (method, None), **options)
    irradiance = images[image][..., 0].astype(float) * np.pi / scene.materials[0].albedo[0]
    return irradiance, images["position_ws"].astype(float)


def open_share(x, radius):
    """Return the share of a disk around x at x' > 0."""
    h = np.clip(x / radius, -1.0, 1.0)
    return 0.5 + (h * np.sqrt(1.0 - h * h) + np.arcsin(h)) / np.pi


def width(x, share):
    """Return the distance between a share of 10 % and of 90 %, by columns of pixels."""
    profile = share.mean(axis=0)
    return np.interp(0.9, profile, x) - np.interp(0.1, profile, x)


# Rays: the mean over rows of 48 x 256 samples, 0.4 % of the light where it changes by 1.3 / r;
# the map: texels of 1 mm, and a filter of 64 samples about one height. Pixels are 11 mm wide.
@pytest.mark.parametrize(("shadows", "tolerance"), [("traced", 0.01), ("map", 0.04)])
@pytest.mark.parametrize("angle", [10.0, 20.0, 40.0])
def test_penumbra_of_an_edge_is_as_wide_as_its_distance_makes_it(
    device, shaders, shadows, tolerance, angle
):
    light = dataclasses.replace(SUN, angle=angle)
    found, at = lit(device, shaders, light, FLOOR, EDGE, shadows=shadows)
    x = at[0, :, 0]
    radius = HEIGHT * np.tan(np.radians(0.5 * angle))
    expected = np.broadcast_to(open_share(x, radius), found.shape)
    assert width(x, found) == pytest.approx(width(x, expected), rel=tolerance)
    assert np.sqrt(np.mean((found - expected) ** 2)) < 0.02
    assert np.abs(found.mean(axis=0) - expected[0]).max() < 0.05
    # Beyond the penumbra light and shadow are whole.
    outside = np.abs(x) > 1.1 * radius + 0.01
    np.testing.assert_allclose(found[:, outside], expected[:, outside], atol=1e-4)


@pytest.mark.parametrize("slope", [0.0, 70.0, 88.0, 93.0])
def test_irradiance_is_that_of_the_disk_above_the_horizon(device, shaders, slope):
    angle = np.radians(slope)
    light = DirectionalLight((-np.sin(angle), -np.cos(angle), 0.0), SUN.irradiance, 20.0)
    spread = np.tan(np.radians(10.0))
    # By points of the disk, evenly over its area, in float64.
    r, phi = np.meshgrid(
        spread * np.sqrt((np.arange(2000) + 0.5) / 2000), 2.0 * np.pi * np.arange(720) / 720
    )
    expected = np.maximum(np.cos(angle) + r * np.cos(phi) * np.sin(angle), 0.0).mean()
    plain, _ = lit(device, shaders, light, FLOOR, shadows="none")
    np.testing.assert_allclose(plain, expected, rtol=1e-3)
    for method, shadows in (("direct", "traced"), ("reference-gi", "map"), ("direct", "map")):
        found, _ = lit(device, shaders, light, FLOOR, shadows=shadows, method=method, spp=256)
        assert found.mean() == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("shadows", ["map", "traced", "none"])
def test_a_sharp_sun_is_the_limit(device, shaders, shadows):
    """The smallest angle gives the picture of none but for pixels on the edge."""
    oblique = dataclasses.replace(SUN, direction=(0.28, -0.96, 0.0))
    small = dataclasses.replace(oblique, angle=1e-3)
    sharp, _ = lit(device, shaders, oblique, FLOOR, EDGE, shadows=shadows)
    soft, _ = lit(device, shaders, small, FLOOR, EDGE, shadows=shadows)
    assert np.mean(np.abs(soft - sharp) > 1e-4) <= 2 / 64
    assert shadows != "map" or np.any(sharp == 0.0)


@pytest.mark.parametrize("roughness", [0.1, 0.2])
def test_a_low_sun_is_round_in_a_polished_floor(device, shaders, roughness):
    """Errors of .086 and .019 of the mean were measured, 4.1 and .94 where it was not."""
    rise = np.radians(20.0)
    eye = (0.0, 2.2 * np.sin(rise), 2.2 * np.cos(rise))
    polish = Material(albedo=(0.0, 0.0, 0.0), specular=1.0, roughness=roughness)
    sun = DirectionalLight((0.0, -np.sin(rise), np.cos(rise)), (2.0, 2.0, 2.0), angle=5.0)
    eye = Camera(eye, (0, 0, 0), fov_y=20.0)
    scene = with_meshes(FLOOR, camera=eye, environment=None, lights=(sun,))
    scene = dataclasses.replace(scene, materials=(polish,))
    off = {"direct.gloss_footprint": 0.0}
    found, true = (
        render(
            device, shaders, scene, ("direct", None), images=("specular",), shadows=shadows,
            shadow_rays=1024, overrides=off,
        )["specular"][..., 0]
        for shadows in ("map", "traced")
    )  # fmt: skip
    assert np.sqrt(np.mean((found - true) ** 2)) < 0.2 * true.mean()
