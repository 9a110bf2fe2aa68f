"""Coarse bodies with smooth normals are lit like the smooth ones that they stand for."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hard_cases.hard_scene import quad
from hard_cases.methods import render
from hard_cases.test_depth import with_meshes

from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight

# At right angles to the view, so that half of what is in view is dark; no vertex faces it.
TOWARD = np.array([0.8, 0.36, 0.48])
SUN = DirectionalLight(tuple(-TOWARD), (1.0, 1.0, 1.0))
AWAY = 4.0
PLACE = AWAY * TOWARD
U = 0.1 * np.array([0.0, 0.8, -0.6])
V = np.cross(U, TOWARD)
LIGHTS = {
    "directional": SUN,
    "sun with an angle": dataclasses.replace(SUN, angle=0.5),
    "point": PointLight(tuple(PLACE), (AWAY**2,) * 3),
    "spot": SpotLight(tuple(PLACE), tuple(-TOWARD), (AWAY**2,) * 3, 40.0, 50.0),
    "rectangle": RectangleLight(
        tuple(PLACE - 0.5 * U - 0.5 * V), tuple(U), tuple(V), (AWAY**2 / 0.01,) * 3, visible=False
    ),
}
CAMERA = Camera((-1.6, -0.72, 4.0), (0.0, 0.0, 0.0), fov_y=32.0)
SIZE = (96, 72)


def ball(count, smooth=True):
    """Return a sphere of radius 1 around the origin, its poles on y."""
    rings = count
    theta = np.pi * np.arange(rings + 1) / rings
    phi = 2.0 * np.pi * (np.arange(count) + 0.3) / count
    ring = np.stack([np.cos(phi), np.zeros(count), np.sin(phi)], axis=1)
    points = [[[0.0, 1.0, 0.0]]]
    points += [np.sin(t) * ring + [0.0, np.cos(t), 0.0] for t in theta[1:-1]]
    points += [[[0.0, -1.0, 0.0]]]
    positions = np.concatenate(points)
    last = len(positions) - 1
    faces = []
    for j in range(count):
        k = (j + 1) % count
        faces += [(0, 1 + k, 1 + j), (last, last - count + j, last - count + k)]
        for i in range(rings - 2):
            a, b = 1 + i * count, 1 + (i + 1) * count
            faces += [(a + j, a + k, b + k), (a + j, b + k, b + j)]
    return Mesh(positions, np.array(faces), normals=positions if smooth else None)


def lit(device, shaders, light, *meshes, shadows="map", method="direct", **more):
    """Return irradiance, shading normals and whether there is a surface."""
    scene = with_meshes(
        *meshes, camera=more.pop("camera", CAMERA), lights=(light,), environment=None
    )
    image = {"direct": "direct", "reference-gi": "beauty"}[method]
    options = {"size": SIZE, "shadow_rays": 16, "spp": 256, "maps": {}, **more}
    images = render(
        device,
        shaders,
        scene,
        (method, None),
        images=(image, "normal_ws", "position_ws"),
        shadows=shadows,
        **options,
    )
    irradiance = images[image][..., 0].astype(float) * np.pi / scene.materials[0].albedo[0]
    normal, at = images["normal_ws"].astype(float), images["position_ws"].astype(float)
    return irradiance, normal, at, np.any(normal != 0.0, axis=-1)


@pytest.mark.parametrize("shadows", ["map", "traced", "none"])
@pytest.mark.parametrize("count", [8, 16])
@pytest.mark.parametrize("name", LIGHTS)
def test_a_coarse_sphere_is_lit_by_its_smooth_normals(device, shaders, name, count, shadows):
    light = LIGHTS[name]
    found, normal, at, is_surface = lit(device, shaders, light, ball(count), shadows=shadows)
    to_light = TOWARD if light.place is None else PLACE - at
    distance = np.linalg.norm(to_light, axis=-1)
    cosine = np.where(is_surface, (normal * to_light).sum(axis=-1) / distance, 0.0)
    found *= 1.0 if light.place is None else (distance / AWAY) ** 2
    assert np.mean(cosine[is_surface] < -0.1) > 0.2 and np.mean(cosine[is_surface] > 0.1) > 0.2
    error = np.abs(found - np.maximum(cosine, 0.0))[is_surface]
    # The lights with a size reach round the horizon: the larger half of theirs is 0.018.
    assert np.all(found[(cosine > 0.1) & is_surface] > 0.0)
    assert np.all(found[is_surface & (cosine < -0.02)] == 0.0)
    # Maps shade the lifted point: its horizon is nearer by lift / distance, at most 0.15 / 3.6.
    assert error.max() < (0.05 if shadows == "map" and light.place else 0.015)
    assert np.mean(error > 0.015) < 0.02


@pytest.mark.parametrize("count", [8, 16])
def test_the_full_solution_agrees(device, shaders, count):
    """Scattered rays meet nothing: what is left is the light, on the sphere alone."""
    found, *_ = lit(device, shaders, SUN, ball(count), method="reference-gi")
    direct, *_ = lit(device, shaders, SUN, ball(count))
    np.testing.assert_allclose(found, direct, atol=2e-3)


@pytest.mark.parametrize("shadows", ["map", "traced"])
@pytest.mark.parametrize("name", LIGHTS)
def test_what_stands_before_the_light_darkens_the_terminator_too(device, shaders, name, shadows):
    u = np.cross(TOWARD, [0.0, 1.0, 0.0])
    card = quad(1.7 * TOWARD - 2.0 * u - 2.0 * np.cross(u, TOWARD), 4 * u, 4 * np.cross(u, TOWARD))
    found, normal, at, _ = lit(device, shaders, LIGHTS[name], ball(8), card, shadows=shadows)
    on_ball = np.linalg.norm(at, axis=-1) < 1.01
    assert np.mean(on_ball & (np.abs(normal @ TOWARD) < 0.2)) > 0.05
    # Some of what grazes the lifted point passes the slack of its map.
    assert found[on_ball].max() < (0.01 if shadows == "map" else 1e-6)


@pytest.mark.parametrize("shadows", ["map", "traced"])
@pytest.mark.parametrize("name", LIGHTS)
def test_a_hollow_body_keeps_light_out(device, shaders, name, shadows):
    """Seen from inside its facets do not bulge: no more comes in than through flat ones."""
    inside = Camera((0.0, 0.0, 0.0), tuple(np.cross(TOWARD, [0, 1, 0])), fov_y=100.0)
    options = {"shadows": shadows, "camera": inside}
    found, *_, is_surface = lit(device, shaders, LIGHTS[name], ball(8), **options)
    flat, *_ = lit(device, shaders, LIGHTS[name], ball(8, smooth=False), **options)
    assert np.all(is_surface)
    # A map lets some grazing light through, which rays do not.
    leak = {"map": 0.004, "traced": 1e-9}[shadows]
    assert found.mean() <= flat.mean() and flat.mean() < leak


@pytest.mark.parametrize("shadows", ["map", "traced"])
@pytest.mark.parametrize("effects", ["auto", "full"])
def test_a_sheet_with_leaning_normals_is_dark_from_behind(device, shaders, shadows, effects):
    sheet = quad((-1, -1, 0), (2, 0, 0), (0, 2, 0))
    sheet = dataclasses.replace(sheet, normals=np.tile([0.8, 0.0, 0.6], (4, 1)))
    sun = DirectionalLight((-0.8, 0.0, 0.6), (1.0, 1.0, 1.0))
    options = {"shadows": shadows, "effects": effects}
    found, normal, *_, is_surface = lit(device, shaders, sun, sheet, **options)
    # From behind: the light travels along +z, towards the eye, but along the normal's back.
    assert np.all(normal[is_surface] @ [0.8, 0.0, -0.6] > 0.1)
    assert np.all(found == 0.0)


@pytest.mark.parametrize("shadows", ["map", "traced", "none"])
def test_flat_facets_keep_their_own_horizon(device, shaders, shadows):
    light = LIGHTS["point"]
    found, normal, at, is_surface = lit(
        device, shaders, light, ball(8, smooth=False), shadows=shadows
    )
    to_light = PLACE - at
    distance = np.linalg.norm(to_light, axis=-1)
    cosine = (normal * to_light).sum(axis=-1) / distance
    found = found * (distance / AWAY) ** 2
    # 16 bits of a normal: 6.5e-5 radians.
    assert np.all(found[is_surface & (cosine < -1e-4)] == 0.0)
    np.testing.assert_allclose(found[is_surface], np.maximum(cosine, 0.0)[is_surface], atol=2e-4)
