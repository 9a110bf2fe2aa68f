"""Light of every kind with its shadows, against float64."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import numpy as np
import pytest
from oracle import lambert_polygon, shadows
from passes.pass_harness import box, make_frame, make_scene, quad, run_pass, sphere

from ssdo_gl import math3d, resources
from ssdo_gl.effects.direct import DirectPass, DirectSettings
from ssdo_gl.effects.shadows.shadow_map import ShadowMapPass, ShadowMapSettings
from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.images.surface_arrays import world_positions
from ssdo_gl.passes.gbuffer import GBufferPass
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight

SIZE = (64, 48)
FLOOR = quad((-10.0, 0.0, 10.0), (20.0, 0.0, 0.0), (0.0, 0.0, -20.0))
UP = np.array([0.0, 1.0, 0.0])
CAMERA = Camera((0.0, 3.0, 5.0), (0.0, 0.0, 0.0), fov_y=45.0)
LIGHTS = {
    "point": PointLight((0.7, 2.0, -0.4), (5.0, 6.0, 7.0)),
    "spot": SpotLight((0.5, 2.5, 0.3), (-0.28, -0.96, 0.0), (5.0, 6.0, 7.0), 15.0, 40.0),
    "wide spot": SpotLight((0.5, 2.5, 0.3), (-0.28, -0.96, 0.0), (5.0, 6.0, 7.0), 15.0, 75.0),
    "directional": DirectionalLight((0.48, -0.8, 0.36), (3.0, 2.0, 1.0)),
    "rectangle": RectangleLight(
        (-0.4, 2.0, -0.6), (0.8, 0.0, 0.0), (0.0, 0.0, 1.2), (3.0, 2.0, 1.0)
    ),
}
# Positions (1e-7 of the distance) and normals (exact here) through a dozen roundings.
TOLERANCE = 4e-6
# A point's place is off by what its pixel's depth is rounded to.
PLACE = 2e-6


def draw(gl, shaders, scene, size=SIZE, *, maps=True, settings=None, map_settings=None, seed=0):
    """Return the frame, the G-buffer and the direct irradiance, top row first."""
    geometry = Geometry(gl, scene)
    frame = make_frame(scene, size, geometry=geometry, seed=seed)
    images = run_pass(gl, shaders, GBufferPass(), frame, geometry=geometry)
    map_settings = map_settings or ShadowMapSettings(resolution=128)
    parts = map_settings.parts_per_side
    direct = DirectPass(settings, shadow_maps=maps, parts_per_side=parts, lifts=maps)
    inputs = {name: images[name] for name in ("z_vs", "normals_vs")}
    if maps:
        inputs["lift_vs"] = images["lift_vs"]
        made = run_pass(gl, shaders, ShadowMapPass(map_settings), frame, geometry=geometry)
        inputs["shadow_atlas"] = made["shadow_atlas"]
    irradiance = run_pass(gl, shaders, direct, frame, inputs, geometry)["direct_irradiance"]
    geometry.release()
    return frame, images, irradiance[..., :3]


def floor_points(frame, images):
    """World-space points of the pixels that see something, float64, and their mask."""
    seen = images["z_vs"][..., 0] > 0.0
    points = world_positions(images["z_vs"], frame.view).astype(np.float64)
    return points[seen], seen


def unshadowed(light, points, normal=UP):
    """Irradiance at `points` by definition, one colour channel of 1."""
    if isinstance(light, DirectionalLight):
        return np.full(len(points), max(-np.dot(light.direction, normal), 0.0))
    if isinstance(light, RectangleLight):
        corner, u, v = (np.asarray(a) for a in (light.corner, light.edge_u, light.edge_v))
        outline = np.array([corner, corner + u, corner + u + v, corner + v])
        return np.array(
            [lambert_polygon.cosine_integral(outline - p, normal, normal) for p in points]
        )
    d = np.asarray(light.position) - points
    r = np.linalg.norm(d, axis=1)
    result = np.maximum(d @ normal / r, 0.0) / r**2
    if isinstance(light, SpotLight):
        cosine = -(d @ light.direction) / r
        result = result * lambert_polygon.spot_falloff(cosine, light.inner_angle, light.outer_angle)
    return result


def power(light):
    names = ("intensity", "irradiance", "radiance")
    return np.array(next(getattr(light, name) for name in names if hasattr(light, name)))


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


@pytest.mark.parametrize("kind", ["point", "directional"])
def test_low_steps_throw_shadows(gl, shaders, kind):
    """A step three texels of the map high darkens all but a texel of what it should."""
    light = {
        "point": PointLight((-4.0, 2.0, 0.0), (9.0, 9.0, 9.0)),
        "directional": DirectionalLight((0.894427, -0.447214, 0.0), (1.0, 1.0, 1.0)),
    }[kind]
    # A texel is at most 0.02 where the step is: 10 units over 1024, and 2 * 4.5 over 512.
    floor = quad((-5.0, 0.0, 5.0), (10.0, 0.0, 0.0), (0.0, 0.0, -10.0))
    step = box((-1.0, 0.0, -1.0), (0.0, 0.06, 1.0))
    camera = Camera((0.3, 0.8, 0.0), (0.06, 0.0, 0.0), fov_y=20.0)
    scene = make_scene([floor, step], lights=[light], camera=camera)
    frame, images, found = draw(gl, shaders, scene, map_settings=ShadowMapSettings(256))
    points, seen = floor_points(frame, images)
    length = 0.06 * 2.0
    dark = (np.abs(points[:, 1]) < 1e-4) & (points[:, 0] > 0.02) & (points[:, 0] < length - 0.04)
    assert dark.sum() > 200
    assert np.all(found[seen][dark] == 0.0)
    lit = (np.abs(points[:, 1]) < 1e-4) & (points[:, 0] > length + 0.06)
    assert np.all(found[seen][lit] > 0.0)


CARD = ((-0.5, 1.0, -0.5), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))


@pytest.mark.parametrize("kind", ["point", "spot", "directional"])
def test_texels_are_the_same_fetched_and_gathered(gl, shaders, tmp_path, kind):
    """Drivers without gathers see the same picture, to the byte, also where shadows end."""
    folder = shutil.copytree(Path(str(resources.folder("shaders"))), tmp_path / "shaders")
    shader = folder / "effects" / "direct.frag"
    text = shader.read_text()
    assert text.count("#define HAS_GATHER 1") == 2
    shader.write_text(text.replace("#define HAS_GATHER 1", "#define HAS_GATHER 0"))
    scene = make_scene([FLOOR, quad(*CARD)], lights=[LIGHTS[kind]], camera=CAMERA)
    coarse = ShadowMapSettings(16)
    gathered, fetched = (
        draw(gl, library, scene, map_settings=coarse)[2]
        for library in (shaders, ShaderLibrary(gl, folder))
    )
    open_floor = draw(gl, shaders, scene, maps=False)[2]
    partly = (gathered[..., 0] > 0.01) & (gathered[..., 0] < 0.9 * open_floor[..., 0])
    assert partly.sum() > 20
    np.testing.assert_array_equal(gathered, fetched)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("kind", ["point", "spot", "wide spot", "directional"])
def test_hard_shadow_of_a_card(gl, shaders, kind, scale):
    """Where the segment to the light meets the card it is dark, elsewhere fully lit."""
    light = LIGHTS[kind]
    card = tuple(np.asarray(a) * scale for a in CARD)
    factor = {"position": scale, "intensity": scale**2}
    scaled = dataclasses.replace(
        light,
        **{
            n: tuple(np.multiply(getattr(light, n), f))
            for n, f in factor.items()
            if hasattr(light, n)
        },
    )
    floor = dataclasses.replace(FLOOR, positions=FLOOR.positions * scale)
    camera = dataclasses.replace(CAMERA, position=tuple(np.multiply(CAMERA.position, scale)))
    scene = make_scene([floor, quad(*card)], lights=[scaled], camera=camera)
    frame, images, found = draw(gl, shaders, scene, (96, 72), map_settings=ShadowMapSettings(512))
    points, seen = floor_points(frame, images)
    on_floor = np.abs(points[:, 1]) < 1e-3 * scale
    points = points[on_floor] / scale
    plain = unshadowed(light, points) * power(light)[0]
    if kind == "directional":
        ends = points - 100.0 * np.asarray(light.direction)
    else:
        ends = np.broadcast_to(light.position, points.shape)
    dark = shadows.card_blocks(points, ends, *CARD)
    # The edge is blurred over two texels; the widest is the sun's, 20 / 1024 at a slant.
    grown = [np.add(CARD[0], (-d, 0, -d)) for d in (0.06, -0.06)]
    sizes = [np.add(1.0, 2 * d) for d in (0.06, -0.06)]
    outer, inner = (
        shadows.card_blocks(points, ends, corner, (size, 0, 0), (0, 0, size))
        for corner, size in zip(grown, sizes, strict=True)
    )
    result = found[seen][on_floor][:, 0]
    assert inner.sum() > 50
    assert np.all(result[inner] == 0.0)
    np.testing.assert_allclose(result[~outer], plain[~outer], rtol=1e-4, atol=1e-4 * plain.max())
    assert np.all(dark[inner])
    assert np.all(result <= plain * (1.0 + 1e-4) + 1e-5 * plain.max())


# Against the integral over 32 x 32 points of the light, on the floor up to 3 units away.
# The method takes all that stands before a part of the light for one depth and samples
# that with noise: its measured RMS error and bias, with a margin of a third.
PENUMBRA = {1: (0.12, 0.03), 2: (0.052, 0.01), 4: (0.03, 0.005)}


@pytest.mark.parametrize("parts_per_side", PENUMBRA)
def test_penumbra_of_an_edge(gl, shaders, parts_per_side):
    """A half plane above a floor, under a rectangle: from full to none, and where."""
    edge = ((-20.0, 1.0, -20.0), (20.0, 0.0, 0.0), (0.0, 0.0, 40.0))
    light = RectangleLight((-0.6, 2.5, -0.4), (1.2, 0, 0), (0, 0, 0.8), (1.0, 1.0, 1.0))
    camera = Camera((0.3, 0.9, 2.5), (0.3, 0.0, 0.0), fov_y=60.0)
    scene = make_scene([FLOOR, quad(*edge)], lights=[light], camera=camera)
    frame, images, found = draw(
        gl,
        shaders,
        scene,
        settings=DirectSettings(blocker_samples=8, filter_samples=16),
        map_settings=ShadowMapSettings(512, parts_per_side),
    )
    points, seen = floor_points(frame, images)
    on_floor = (np.abs(points[:, 1]) < 1e-3) & (points[:, 2] > -3.0)
    points, result = points[on_floor], found[seen][on_floor][:, 0]
    plain = unshadowed(light, points)
    geometry = (light.corner, light.edge_u, light.edge_v)
    wanted = shadows.rectangle_visibility(points, UP, geometry, [edge])
    partly = (wanted > 0.02) & (wanted < 0.98)
    assert partly.sum() > 300
    error = result / plain - wanted
    rms, bias = PENUMBRA[parts_per_side]
    assert np.sqrt(np.mean(error[partly] ** 2)) < rms
    assert abs(error[partly].mean()) < bias
    # One of the 16 samples of one part may err where a shadow begins or ends.
    assert np.abs(error[wanted > 0.999]).max() < 1.5 / 16.0
    assert np.abs(error[wanted < 0.001]).max() < 1.5 / 16.0


def test_a_body_on_the_floor_is_dark_where_it_touches(gl, shaders):
    """No light leaks in under a box: the floor beside it, away from the light, is black."""
    body = box((-0.5, 0.0, -0.5), (0.5, 1.0, 0.5))
    camera = Camera((-2.5, 1.5, 0.0), (-0.5, 0.0, 0.0), fov_y=40.0)
    for light in (
        PointLight((3.0, 2.5, 0.1), (5.0, 5.0, 5.0)),
        DirectionalLight((-0.8, -0.6, 0.0), (1.0, 1.0, 1.0)),
        RectangleLight((3.0, 2.4, -0.1), (0.0, 0.2, 0.0), (0.0, 0.0, 0.2), (9.0, 9.0, 9.0)),
    ):
        if isinstance(light, RectangleLight):
            light = dataclasses.replace(light, edge_u=(0, 0, 0.2), edge_v=(0, 0.2, 0))
        scene = make_scene([FLOOR, body], lights=[light], camera=camera)
        frame, images, found = draw(
            gl, shaders, scene, (96, 72), map_settings=ShadowMapSettings(512)
        )
        _, _, plain = draw(gl, shaders, scene, (96, 72), maps=False)
        points, seen = floor_points(frame, images)
        beside = (np.abs(points[:, 1]) < 1e-4) & (np.abs(points[:, 2]) < 0.4)
        beside &= (points[:, 0] < -0.5) & (points[:, 0] > -0.8)
        assert beside.sum() > 100
        assert np.all(plain[seen][beside] > 0.0)
        assert np.all(found[seen][beside] == 0.0)


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
