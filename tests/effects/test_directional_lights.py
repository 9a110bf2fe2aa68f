"""Lights that arrive through open directions: rectangles, points, spots, directional."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from oracle import closed_forms, screen_space
from passes.estimator_cases import (
    LAMP,
    SIZE,
    SUM_TOLERANCE,
    TAN_Y,
    corner,
    covered_texels,
    noise,
    picture_frame,
    plane,
    positions,
    run_directional,
    twin_of,
)

from ssdo_gl.effects.directional import DirectionalSettings
from ssdo_gl.scene.lights import DirectionalLight, Light, PointLight, RectangleLight, SpotLight

# --- rectangles -----------------------------------------------------------------------


def lambert(light, point, normal):
    """Irradiance of a rectangle light by Lambert's formula, all of it above the horizon."""
    c, u, v = (np.asarray(x) for x in (light.corner, light.edge_u, light.edge_v))
    corners = np.array([c, c + v, c + u + v, c + u]) - point
    factor = closed_forms.rectangle_form_factor(corners, normal)
    return np.pi * max(factor, 0.0) * np.asarray(light.radiance)


@pytest.mark.parametrize("estimator", ["march", "rgs09"])
def test_rectangle_lights_an_open_floor(gl, shaders, estimator):
    picture = plane(55.0)
    settings = DirectionalSettings(estimator=estimator, radius=0.5, samples=4096 // 16, steps=4)
    # Above the plane's middle, facing it.
    n = picture.geometric[18, 24]
    middle = positions(picture)[18, 24]
    u = np.cross(n, [0.0, 1.0, 0.0])
    u /= np.linalg.norm(u)
    v = np.cross(u, n)  # so that u x v = -n: it faces the plane
    corner_ = middle + 0.7 * n - 0.4 * u - 0.3 * v
    light = RectangleLight(
        tuple(corner_), tuple(0.8 * u), tuple(0.6 * v), (3.0, 2.0, 1.0), shadow="ssdo"
    )
    assert np.cross(light.edge_u, light.edge_v) @ n < 0.0
    image = run_directional(gl, shaders, picture, settings, lights=(light,))
    expected = lambert(light, middle, n)
    if estimator == "march":
        np.testing.assert_allclose(image[18, 24, :3], expected, rtol=1e-5)
        # Everywhere but at the horizon: none of it is blocked.
        assert image[(picture.z > 0.0) & (picture.z < 6.0)][:, :3].min() > 0.0
    else:
        # The paper's directions meet it by chance: 16 sets of 256 around the middle.
        points = positions(picture)[16:20, 22:26].reshape(-1, 3)
        block = np.array([lambert(light, point, n) for point in points])
        found = image[16:20, 22:26, :3].mean((0, 1))
        np.testing.assert_allclose(found, block.mean(0), rtol=0.02)
    turned = dataclasses.replace(light, edge_u=light.edge_v, edge_v=light.edge_u)
    assert np.all(run_directional(gl, shaders, picture, settings, lights=(turned,))[..., :3] == 0.0)
    both = dataclasses.replace(turned, two_sided=True)
    again = run_directional(gl, shaders, picture, settings, lights=(both,))
    np.testing.assert_allclose(again[18, 24, :3], image[18, 24, :3], rtol=1e-5)


def test_rectangle_matches_the_twin_on_noise(gl, shaders):
    """The share that arrives is a weighted mean over directions aimed at the lamp."""
    lamp = dataclasses.replace(LAMP, two_sided=True)
    settings = DirectionalSettings(radius=1.0, samples=32, steps=4)
    picture = noise()
    lit = run_directional(gl, shaders, picture, settings, lights=(lamp,))[..., 0]
    unoccluded = run_directional(gl, shaders, picture, settings, lights=(lamp,), is_open=True)[
        ..., 0
    ]
    texel = covered_texels(picture)
    twin = twin_of(settings, picture_frame(SIZE, TAN_Y))
    edges = (np.asarray(x) for x in (lamp.corner, lamp.edge_u, lamp.edge_v))
    share, unsure = screen_space.rectangle_visibility(picture, texel, twin, *edges)
    exact = unoccluded[texel[:, 1], texel[:, 0]]
    use = (exact > 0.0) & ~unsure.any(1)
    assert use.sum() > 300
    assert 0.2 < share[use].mean() < 0.8
    found = lit[texel[:, 1], texel[:, 0]][use] / exact[use]
    np.testing.assert_allclose(found, share[use], atol=20 * SUM_TOLERANCE)


@pytest.mark.parametrize("estimator", ["march", "rgs09"])
def test_wall_within_reach_takes_a_rectangle_s_light(gl, shaders, estimator):
    """The lamp stands behind the wall: dark where every ray meets the wall within R."""
    frame = picture_frame((64, 64), 0.25)
    picture = corner((64, 64), frame.view.tan_half_fov)
    c = np.sqrt(0.5)
    behind = np.array([0.0, 0.0, -3.0]) - 0.3 * np.array([0.0, -c, c])
    up = np.array([0.0, c, c])
    light = RectangleLight(
        tuple(behind + 0.05 * up - [0.2, 0.0, 0.0]),
        tuple(0.2 * up),
        (0.4, 0.0, 0.0),
        (3.0, 2.0, 1.0),
        shadow="ssdo",
        two_sided=True,
    )
    settings = DirectionalSettings(
        estimator=estimator, radius=2.0, samples=256, steps=8, thickness=np.inf
    )
    floor = np.arange(4, 32)
    image = run_directional(gl, shaders, picture, settings, lights=(light,))
    if estimator == "march":
        assert np.all(image[floor, 8:56, :3] == 0.0)
    short = run_directional(
        gl, shaders, picture, dataclasses.replace(settings, radius=0.02), lights=(light,)
    )
    lit = short[floor, 8:56, 0].mean()
    assert lit > 0.05
    # One point per direction finds some of the wall.
    assert image[floor, 8:56, 0].mean() < 0.9 * lit


def test_visible_lamp_nearer_than_r_does_not_block_itself(gl, shaders):
    """The lamp is in the depth buffer: its own surface ends every ray that is aimed at it."""
    frame = picture_frame((64, 64), 0.4)
    c = np.sqrt(0.5)
    picture = corner((64, 64), frame.view.tan_half_fov)
    # The wall itself shines.
    up, normal = np.array([0.0, c, c]), np.array([0.0, -c, c])
    start = np.array([-0.3, 0.0, -3.0]) + 0.1 * up
    light = RectangleLight(
        tuple(start), (0.6, 0.0, 0.0), tuple(0.4 * up), (1.0, 1.0, 1.0), shadow="ssdo"
    )
    assert np.cross(light.edge_u, light.edge_v) @ normal > 0.0
    settings = DirectionalSettings(radius=3.0, samples=128, steps=8)
    image = run_directional(gl, shaders, picture, settings, lights=(light,))
    for row, column in ((20, 32), (28, 10), (5, 50)):
        point = positions(picture)[row, column]
        expected = lambert(light, point, np.array([0.0, c, c]))
        # Stored normals are off by up to 6.5e-5 rad, and the lamp stands low.
        np.testing.assert_allclose(image[row, column, :3], expected, rtol=5e-4)


# --- points, spots, directional lights ----------------------------------------------------

POINTS: tuple[Light, ...] = (
    PointLight((0.3, 0.4, -2.5), (1.0, 2.0, 3.0), shadow="ssdo"),
    SpotLight((0.3, 0.4, -2.5), (0.0, 0.0, -1.0), (1.0, 2.0, 3.0), 20.0, 60.0, shadow="ssdo"),
    DirectionalLight((0.0, -0.6, -0.8), (1.0, 2.0, 3.0), shadow="ssdo"),
)


def analytic(light, point, normal):
    if isinstance(light, DirectionalLight):
        cosine = max(-np.asarray(light.direction) @ normal, 0.0)
        return cosine * np.asarray(light.irradiance)
    to_light = np.asarray(light.position) - point
    d = np.linalg.norm(to_light)
    w = to_light / d
    factor = max(w @ normal, 0.0) / d**2
    if isinstance(light, SpotLight):
        inner, outer = np.cos(np.radians([light.inner_angle, light.outer_angle]))
        factor *= np.clip((-w @ np.asarray(light.direction) - outer) / (inner - outer), 0, 1) ** 2
    return factor * np.asarray(light.intensity)


@pytest.mark.parametrize("light", POINTS, ids=lambda light: type(light).__name__)
def test_point_lights_reach_an_open_plane(gl, shaders, light):
    picture = plane(20.0)
    settings = DirectionalSettings(radius=1.0, samples=8)
    image = run_directional(gl, shaders, picture, settings, lights=(light,))
    for y, x in ((18, 24), (5, 40), (30, 3)):
        expected = analytic(light, positions(picture)[y, x], picture.shading[y, x])
        np.testing.assert_allclose(image[y, x, :3], expected, rtol=1e-5, atol=1e-6)


def test_shadow_of_a_wall_ends_at_r(gl, shaders):
    """Light from behind the wall, just above the floor: dark up to R / cos from it."""
    frame = picture_frame((64, 64), 0.25)
    picture = corner((64, 64), frame.view.tan_half_fov)
    c = np.sqrt(0.5)
    normal = np.array([0.0, -c, c])  # of the wall
    sun = DirectionalLight(
        tuple(0.8 * normal - 0.6 * np.array([0.0, c, c])), (1.0, 1.0, 1.0), shadow="ssdo"
    )
    settings = DirectionalSettings(radius=0.25, light_steps=32, thickness=np.inf, front_slack=0.0)
    image = run_directional(gl, shaders, picture, settings, lights=(sun,))
    away = (positions(picture) - [0.0, 0.0, -3.0]) @ normal
    floor = np.arange(64) < 32
    dark = away[:, 32] < 0.8 * 0.25 - 0.03
    lit = away[:, 32] > 0.8 * 0.25 + 0.03
    assert np.all(image[floor & dark][:, 8:56, 0] == 0.0)
    # Stored normals are off by up to 6.5e-5 rad.
    np.testing.assert_allclose(image[floor & lit][:, 8:56, 0], 0.6, rtol=1e-4)
