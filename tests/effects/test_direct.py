"""Light of every kind, and no shadow where nothing casts one, against float64."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from effects.lit_floor import CAMERA, CARD, FLOOR, LIGHTS, draw, floor_points, power, unshadowed
from passes.pass_harness import box, make_scene, quad, sphere

from ssdo_gl import math3d
from ssdo_gl.effects.direct import DirectPass, DirectSettings
from ssdo_gl.effects.shadows.shadow_map import ShadowMapSettings
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight

# Positions (1e-7 of the distance) and normals (exact here) through a dozen roundings.
TOLERANCE = 4e-6


# A point's place is off by what its pixel's depth is rounded to.
PLACE = 2e-6


@pytest.mark.parametrize("kind", LIGHTS)
def test_open_floor_receives_what_the_formula_says(gl, shaders, kind):
    """With shadow maps on, which on a floor alone must change nothing."""
    light = LIGHTS[kind]
    # Looking level, so that the floor's normal is an axis of view space: stored exactly.
    camera = Camera((0.0, 1.0, 4.0), (0.0, 1.0, 0.0), fov_y=70.0)
    frame, images, found = draw(gl, shaders, make_scene([FLOOR], lights=[light], camera=camera))
    points, seen = floor_points(frame, images)
    wanted = unshadowed(light, points)[:, None] * power(light)
    assert np.count_nonzero(wanted[:, 0]) > 200
    scale = wanted.max()
    np.testing.assert_allclose(found[seen], wanted, rtol=TOLERANCE, atol=PLACE * scale)
    assert np.all(found[~seen] == 0.0)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("elevation", [60.0, 5.0, 0.5])
@pytest.mark.parametrize("kind", ["point", "directional", "rectangle"])
def test_a_plane_never_shadows_itself(gl, shaders, kind, elevation, scale):
    """Down to light that grazes it at half a degree, whatever the units: not one pixel."""
    toward = np.array([np.cos(np.radians(elevation)), np.sin(np.radians(elevation)), 0.0])
    turn = math3d.rotation_euler([17.0, 31.0, -8.0])[:3, :3]
    place = turn @ toward * 6.0 * scale
    if kind == "point":
        light = PointLight(tuple(place), (scale**2,) * 3)
    elif kind == "directional":
        light = DirectionalLight(tuple(-turn @ toward), (1.0, 1.0, 1.0))
    else:
        u, v = turn @ [0, 0, 1.0] * scale, turn @ np.cross([0, 0, 1.0], toward) * 0.02 * scale
        light = RectangleLight(tuple(place), tuple(u), tuple(v), (1.0, 1.0, 1.0))
    corner, edge_u, edge_v = turn @ [-5, 0, 5], turn @ [10.0, 0, 0], turn @ [0, 0, -10.0]
    plane = quad(corner * scale, edge_u * scale, edge_v * scale)
    camera = Camera(tuple(turn @ [1.0, 4.0, 6.0] * scale), (0.0, 0.0, 0.0), fov_y=60.0)
    scene = make_scene([plane], lights=[light], camera=camera)
    _, _, shadowed = draw(gl, shaders, scene)
    _, _, plain = draw(gl, shaders, scene, maps=False)
    assert np.count_nonzero(plain) > 1000
    np.testing.assert_array_equal(shadowed, plain)


@pytest.mark.parametrize("kind", LIGHTS)
def test_a_convex_body_never_shadows_itself(gl, shaders, kind):
    """Facets of a smooth ball: no acne on its lit side, whatever the map's resolution."""
    camera = Camera((1.5, 2.5, 3.0), (0.0, 0.3, 0.0), fov_y=35.0)
    scene = make_scene([sphere(rows=16)], lights=[LIGHTS[kind]], camera=camera)
    for resolution in (32, 512):
        settings = ShadowMapSettings(resolution=resolution)
        _, _, shadowed = draw(gl, shaders, scene, map_settings=settings)
        _, _, plain = draw(gl, shaders, scene, maps=False)
        assert np.count_nonzero(plain) > 300
        # Near lights fade out above the horizon of the lifted facets, which is nearer.
        fades = plain < 0.06 * plain.max(axis=(0, 1))
        # Clipping a rectangle at one horizon or the other rounds differently.
        rounding = 1e-6 if kind == "rectangle" else 0.0
        np.testing.assert_allclose(shadowed[~fades], plain[~fades], rtol=rounding)
        assert np.all(shadowed[fades] <= plain[fades] * (1.0 + rounding))
        assert np.mean(shadowed[fades] < plain[fades]) < 0.02


@pytest.mark.parametrize("kind", ["point", "rectangle"])
def test_inside_a_ball_all_is_lit(gl, shaders, kind):
    """A concave surface of small facets, each of which stands above its neighbours' planes."""
    light = {
        "point": PointLight((0.5, 0.3, 0.0), (1.0, 1.0, 1.0)),
        "rectangle": RectangleLight((0.4, 0.3, -0.1), (0.2, 0, 0), (0, 0, 0.2), (9.0, 9.0, 9.0)),
    }[kind]
    camera = Camera((0.3, 0.2, 0.6), (-0.5, -0.5, 0.0), fov_y=80.0)
    scene = make_scene([sphere(rows=48)], lights=[light], camera=camera)
    _, _, shadowed = draw(gl, shaders, scene, map_settings=ShadowMapSettings(256))
    _, _, plain = draw(gl, shaders, scene, maps=False)
    assert np.count_nonzero(plain) > 3000
    np.testing.assert_array_equal(shadowed, plain)


def test_lights_add_up_and_double(gl, shaders):
    body = box((-0.5, 0.0, -0.5), (0.5, 1.0, 0.5))
    settings = ShadowMapSettings(resolution=64)
    lights = [LIGHTS[kind] for kind in ("point", "directional", "rectangle")]

    def light_of(chosen):
        scene = make_scene([FLOOR, body], lights=chosen, camera=CAMERA)
        return draw(gl, shaders, scene, map_settings=settings)[2].astype(np.float64)

    single = [light_of([light]) for light in lights]
    np.testing.assert_allclose(light_of(lights), sum(single), rtol=1e-6, atol=1e-6)
    brighter = dataclasses.replace(lights[2], radiance=(12.0, 8.0, 4.0))
    np.testing.assert_array_equal(light_of([brighter]), 4.0 * single[2])
    np.testing.assert_array_equal(
        light_of([dataclasses.replace(lights[0], intensity=(0, 0, 0))]), 0.0
    )
    np.testing.assert_array_equal(light_of([]), 0.0)


def test_lights_that_arrive_by_ssdo_are_left_out_and_shadowless_ones_are_not(gl, shaders):
    body = quad(*CARD)
    for shadow in ("ssdo", "none"):
        light = dataclasses.replace(LIGHTS["point"], shadow=shadow)
        scene = make_scene([FLOOR, body], lights=[light, LIGHTS["directional"]], camera=CAMERA)
        _, _, both = draw(gl, shaders, scene)
        only = make_scene([FLOOR, body], lights=[LIGHTS["directional"]], camera=CAMERA)
        _, _, sun = draw(gl, shaders, only)
        if shadow == "ssdo":
            np.testing.assert_array_equal(both, sun)
        else:
            bare = make_scene([FLOOR, body], lights=[light], camera=CAMERA)
            _, _, lamp = draw(gl, shaders, bare, maps=False)
            np.testing.assert_allclose(both, sun + lamp, rtol=1e-6)


def test_two_sided_panels_light_and_shadow_both_ways(gl, shaders):
    """Floor and ceiling, mirror images of each other about the panel."""
    ceiling = quad((-10.0, 2.0, -10.0), (20.0, 0.0, 0.0), (0.0, 0.0, 20.0))
    floor = quad((-10.0, -2.0, 10.0), (20.0, 0.0, 0.0), (0.0, 0.0, -20.0))
    card_below, card_above = (quad((-0.4, y, -0.3), (0.8, 0, 0), (0, 0, 0.6)) for y in (-1.0, 1.0))
    panel = RectangleLight((-0.5, 0.0, -0.5), (1, 0, 0), (0, 0, 1), (1, 1, 1), two_sided=True)
    found = []
    for target in (-2.0, 2.0):
        camera = Camera((0.0, target * 0.25, 6.0), (0.0, target, 0.0), fov_y=50.0)
        meshes = [floor, ceiling, card_below, card_above]
        scene = make_scene(meshes, lights=[panel], camera=camera)
        found.append(draw(gl, shaders, scene)[2])
    below, above = found[0], found[1][::-1]
    lit = (below[..., 0] > 0.0) & (above[..., 0] > 0.0)
    assert lit.mean() > 0.2
    # The pattern of a pixel's samples is not mirrored: noise of 32 samples in penumbrae.
    assert np.abs(below - above)[lit].mean() < 0.02 * below[lit].mean()
    one_sided = dataclasses.replace(panel, two_sided=False)
    scene = dataclasses.replace(scene, lights=(one_sided,))
    assert not np.any(draw(gl, shaders, scene)[2][:10]), "edge_u x edge_v points down"


@pytest.mark.parametrize("power_of_two", [-10, 13])
def test_scale_changes_nothing(gl, shaders, power_of_two):
    """A scene in other units, its point lights scaled to match: the same image."""
    factor = 2.0**power_of_two
    body = box((-0.5, 0.0, -0.5), (0.5, 1.0, 0.5))
    lights = [LIGHTS[kind] for kind in ("point", "directional", "rectangle")]
    scaled_lights = [
        dataclasses.replace(
            light,
            **{n: tuple(np.multiply(getattr(light, n), factor))
               for n in ("position", "corner", "edge_u", "edge_v") if hasattr(light, n)},
            **({"intensity": tuple(np.multiply(light.intensity, factor**2))}
               if hasattr(light, "intensity") else {}),
        )
        for light in lights
    ]  # fmt: skip
    meshes = [dataclasses.replace(m, positions=m.positions * factor) for m in (FLOOR, body)]
    camera = dataclasses.replace(CAMERA, position=tuple(np.multiply(CAMERA.position, factor)))
    _, _, there = draw(gl, shaders, make_scene(meshes, lights=scaled_lights, camera=camera))
    _, _, here = draw(gl, shaders, make_scene([FLOOR, body], lights=lights, camera=CAMERA))
    np.testing.assert_allclose(there, here, rtol=1e-5, atol=1e-6)


def test_far_from_the_origin_nothing_changes(gl, shaders):
    offset = np.array([1e5, -1e5, 5e4])
    body = box((-0.5, 0.0, -0.5), (0.5, 1.0, 0.5))
    lights = [LIGHTS[kind] for kind in ("point", "directional", "rectangle")]
    moved_lights = [
        dataclasses.replace(light, **{n: tuple(np.add(getattr(light, n), offset))
                                      for n in ("position", "corner") if hasattr(light, n)})
        for light in lights
    ]  # fmt: skip
    meshes = [dataclasses.replace(m, positions=m.positions + offset) for m in (FLOOR, body)]
    camera = dataclasses.replace(
        CAMERA,
        position=tuple(np.add(CAMERA.position, offset)),
        target=tuple(np.add(CAMERA.target, offset)),
    )
    _, _, there = draw(gl, shaders, make_scene(meshes, lights=moved_lights, camera=camera))
    _, _, here = draw(gl, shaders, make_scene([FLOOR, body], lights=lights, camera=CAMERA))
    # float64 holds 1e5 to 1.5e-11; a sample on the verge may fall the other way.
    different = np.abs(there - here) > 1e-5 + 1e-4 * here
    assert different.mean() < 2e-3


@pytest.mark.parametrize("intensity", [0.0, 1.0, 1e8])
def test_lights_on_and_inside_surfaces_stay_finite(gl, shaders, intensity):
    body = box((-0.5, 0.0, -0.5), (0.5, 1.0, 0.5))
    lights = [
        PointLight((0.0, 0.0, 0.0), (intensity,) * 3),
        PointLight((0.5, 0.5, 0.0), (intensity,) * 3),
        SpotLight((0.0, 0.5, 0.0), (0.0, -1.0, 0.0), (intensity,) * 3),
        RectangleLight((-0.5, 0.0, -0.5), (1, 0, 0), (0, 0, -1), (intensity,) * 3),
        RectangleLight((-0.5, 0.0, -0.5), (1, 0, 0), (2, 0, 0), (intensity,) * 3),
        RectangleLight((0.5, 0.0, -0.5), (0, 1, 0), (0, 0, 1), (intensity,) * 3),
    ]
    scene = make_scene([FLOOR, body], lights=lights, camera=CAMERA)
    _, _, found = draw(gl, shaders, scene)
    assert np.all(np.isfinite(found))
    assert found.min() >= 0.0
    assert np.any(found > 0.0) == (intensity > 0.0)


def test_same_seed_same_bytes_other_seed_other_noise(gl, shaders):
    edge = quad(*CARD)
    scene = make_scene([FLOOR, edge], lights=[LIGHTS["rectangle"]], camera=CAMERA)
    first, again, other = (draw(gl, shaders, scene, seed=seed)[2] for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert np.any(first != other)
    assert np.abs(first - other).mean() < 0.02 * first.mean()


def test_settings_reach_the_pass():
    assert DirectPass().settings_key() != DirectPass(DirectSettings(9, 9)).settings_key()
    assert DirectPass().settings_key() != DirectPass(parts_per_side=3).settings_key()
    assert DirectPass().settings_key() != DirectPass(lifts=True).settings_key()
    assert "lift_vs" in DirectPass(lifts=True).reads and "lift_vs" not in DirectPass().reads
    assert "shadow_atlas" in DirectPass().reads
    assert "shadow_atlas" not in DirectPass(shadow_maps=False).reads
