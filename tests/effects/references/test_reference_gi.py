"""The path tracer against the closed forms of FIELD 4.4 (H, furnace), and itself."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from oracle.monte_carlo import two_sample_deviation, worst_deviation
from passes.pass_harness import box, make_scene, quad
from passes.ray_harness import Tracer

from ssdo_gl.effects.references.reference_gi import ReferenceGiPass, ReferenceGiSettings
from ssdo_gl.effects.references.reference_near import ReferenceNearPass, ReferenceNearSettings
from ssdo_gl.effects.shadows.traced_shadows import TracedShadowsPass, TracedShadowsSettings
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    GradientEnvironment,
    MapEnvironment,
    kind_of,
)
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import sphere
from ssdo_gl.scene.lights import PointLight, RectangleLight
from ssdo_gl.scene.material import Material, Texture
from ssdo_gl.scene.scene import Scene

SIZE = (16, 12)
RUNS = 24
SKY = ConstantEnvironment((1.0, 1.0, 1.0))
# Albedo in the G-buffer is a 16-bit fraction: off by 8e-6.
ALLOWANCE = 2e-5


def paths(scene: Scene, spp: int = 32, bounces: int | None = None) -> ReferenceGiPass:
    settings = ReferenceGiSettings(spp=spp, bounces=bounces)
    return ReferenceGiPass(settings, RayFeatures.of(scene), kind_of(scene.environment))


def radiance(device, shaders, scene: Scene, item: ReferenceGiPass, runs: int = RUNS) -> np.ndarray:
    """Return independent images, (runs, height, width, 3)."""
    with Tracer(device, shaders, scene, SIZE) as tracer:
        return tracer.runs(item, runs)["gi_radiance"][..., :3]


def grey(albedo: float, emission: float = 0.0) -> Material:
    return Material(albedo=(albedo,) * 3, emission=(emission,) * 3)


def wedge(albedo: float) -> Scene:
    """Two walls at a right angle, thousands of times as large as the view's distance."""
    meshes = [
        quad([0, 0, 100], [200, 0, 0], [0, 0, -200]),
        quad([0, 0, 100], [0, 0, -200], [0, 200, 0]),
    ]
    camera = Camera((0.032, 0.026, 0.0), (0.0, 0.004, 0.0), fov_y=50.0)
    return make_scene(meshes, materials=[grey(albedo)], environment=SKY, camera=camera)


# The sky past the walls' ends at +-100, seen from less than 0.04, takes d / 100 / pi of
# the disk from the other wall: 1.3e-4 of all that arrives.
WEDGE_ALLOWANCE = 2e-4


@pytest.mark.parametrize(
    ("bounces", "expected"),
    [
        (0, lambda a: a / 2.0),
        (1, lambda a: a / 2.0 + a * a / 4.0),
        (None, lambda a: (a / 2.0) / (1.0 - a / 2.0)),
    ],
)
@pytest.mark.parametrize("albedo", [0.5, 0.9])
def test_wedge_under_a_uniform_sky(device, shaders, albedo, bounces, expected) -> None:
    scene = wedge(albedo)
    runs = radiance(device, shaders, scene, paths(scene, bounces=bounces))
    exact = expected(albedo)
    assert worst_deviation(runs, exact, WEDGE_ALLOWANCE) <= 1.0
    # All points of the wedge are alike, so their mean is far more exact.
    means = runs.mean(axis=(1, 2, 3))[:, None]
    assert worst_deviation(means, exact, WEDGE_ALLOWANCE) <= 1.0
    assert worst_deviation(means, exact * 1.005, WEDGE_ALLOWANCE) > 1.0


@pytest.mark.parametrize(
    ("bounces", "expected"),
    [
        (0, lambda a, f: a * (1.0 - f)),
        (1, lambda a, f: a * (1.0 - f) * (1.0 + a * f)),
        (None, lambda a, f: a * (1.0 - f) / (1.0 - a * f)),
    ],
)
def test_spherical_bowl(device, shaders, bounces, expected) -> None:
    segments, albedo = 192, 0.8
    ball = sphere(segments)
    middle = ball.positions[ball.triangles].mean(axis=1)
    # The lower half, shaded flat and seen from inside.
    bowl = Mesh(ball.positions, ball.triangles[middle[:, 1] < 0.0][:, ::-1])
    camera = Camera((0.0, 0.3, 0.0), (0.2, -1.0, 0.1), fov_y=70.0)
    scene = make_scene([bowl], materials=[grey(albedo)], environment=SKY, camera=camera)
    runs = radiance(device, shaders, scene, paths(scene, bounces=bounces))
    exact = expected(albedo, 0.5)
    # Facets: area and angles are off by (pi / segments)^2 at most; next to an edge of two
    # facets, points see that much more of the neighbour.
    allowance = 10.0 * (np.pi / segments) ** 2
    assert worst_deviation(runs, exact, allowance) <= 1.0
    means = runs.mean(axis=(1, 2, 3))[:, None]
    assert worst_deviation(means, exact, allowance) <= 1.0


def furnace(albedo: float, emission: float, **light: object) -> Scene:
    """A closed room that glows from all sides, seen from inside."""
    room = box([-1, -1, -1], [1, 1, 1])
    room = dataclasses.replace(room, triangles=room.triangles[:, ::-1])
    camera = Camera((0.3, 0.1, 0.5), (-0.4, -0.3, -0.6), fov_y=80.0)
    return make_scene([room], materials=[grey(albedo, emission)], camera=camera)


@pytest.mark.parametrize("albedo", [0.3, 0.8])
@pytest.mark.parametrize("bounces", [0, 1, 5, None])
def test_furnace(device, shaders, albedo: float, bounces: int | None) -> None:
    scene = furnace(albedo, 0.5)
    runs = radiance(device, shaders, scene, paths(scene, 16, bounces))
    # e (1 - a^(n + 1)) / (1 - a) after n reflections; `bounces` leaves out the first.
    cut = 0.0 if bounces is None else albedo ** (bounces + 2)
    exact = 0.5 * (1.0 - cut) / (1.0 - albedo)
    assert worst_deviation(runs, exact, ALLOWANCE) <= 1.0
    means = runs.mean(axis=(1, 2, 3))[:, None]
    assert worst_deviation(means, exact, ALLOWANCE) <= 1.0
    # The promise of the furnace scene: energy to 0.5 %.
    assert means.mean() == pytest.approx(exact, rel=5e-3)


def test_convex_bodies_reflect_the_sky_and_no_more(device, shaders) -> None:
    scene = make_scene([box([-1, -1, -4], [1, 1, -2])], materials=[grey(0.6)], environment=SKY)
    with Tracer(device, shaders, scene, SIZE) as tracer:
        image = tracer.run(paths(scene, 4), ["z_vs"])
    covered = image["z_vs"][..., 0] > 0.0
    assert covered.any()
    assert not covered.all()
    radiance = image["gi_radiance"]
    np.testing.assert_allclose(radiance[covered][:, :3], 0.6, rtol=2e-5)
    np.testing.assert_array_equal(radiance[~covered][:, :3], 1.0)
    np.testing.assert_array_equal(radiance[..., 3], covered)


def lit_room(**light: object) -> Scene:
    """A room with a box, lit by one lamp whose body is in the scene."""
    room = box([-1, -1, -1], [1, 1, 1])
    room = dataclasses.replace(room, triangles=room.triangles[:, ::-1])
    lamp = RectangleLight(
        (-0.4, 0.9, -0.4), (0.8, 0.0, 0.0), (0.0, 0.0, 0.8), (6.0, 5.0, 4.0), **light
    )
    body = quad(lamp.corner, lamp.edge_u, lamp.edge_v)
    glow = Material(albedo=(0.0,) * 3, emission=lamp.radiance)
    return make_scene(
        [room, box([-0.3, -1, -0.3], [0.3, -0.4, 0.3]), body],
        materials=[Material(albedo=(0.7, 0.5, 0.3)), glow],
        objects=[SceneObject(0, 0), SceneObject(1, 0), SceneObject(2, 1, light=0)],
        lights=[lamp],
        camera=Camera((0.7, 0.6, 0.9), (-0.2, -0.5, -0.3), fov_y=80.0),
    )


def test_a_lamp_shines_the_same_with_or_without_a_light_for_it(device, shaders) -> None:
    scene = lit_room()
    bare = dataclasses.replace(
        scene,
        lights=(),
        objects=tuple(dataclasses.replace(item, light=None) for item in scene.objects),
    )
    first = radiance(device, shaders, scene, paths(scene, 64))
    second = radiance(device, shaders, bare, paths(bare, 64))
    # Not the same random numbers decide: another order of emitters.
    np.testing.assert_allclose(first.mean(), second.mean(), rtol=5e-3)
    assert two_sample_deviation(first, second[::-1]) <= 1.0


def test_next_event_estimation_and_scattering_agree(device, shaders) -> None:
    # The same lamp once as a body that rays can hit, weighted between both ways of
    # finding it, and once invisible, found by light samples alone. The body blocks
    # light, so it stands against the ceiling, where there is none to block.
    scene = lit_room()
    lamp = scene.lights[0]
    assert isinstance(lamp, RectangleLight)
    high = dataclasses.replace(lamp, corner=(-0.4, 0.9999, -0.4))
    body = quad(high.corner, high.edge_u, high.edge_v)
    seen = dataclasses.replace(scene, lights=(high,), meshes=(*scene.meshes[:2], body))
    # One bounce less: light from the body onto itself does not exist in either.
    hidden = dataclasses.replace(
        scene,
        lights=(dataclasses.replace(high, visible=False),),
        meshes=scene.meshes[:2],
        objects=scene.objects[:2],
    )
    first = radiance(device, shaders, seen, paths(seen, 64, bounces=0))
    second = radiance(device, shaders, hidden, paths(hidden, 64, bounces=0))
    # The camera sees the room, not the lamp.
    assert two_sample_deviation(first, second, 1e-3) <= 1.0
    assert first.mean() == pytest.approx(second.mean(), rel=5e-3)


def test_an_unshadowed_body_passes_through_everything_once(device, shaders) -> None:
    scene = lit_room(shadow="none")
    free = dataclasses.replace(
        scene, meshes=(scene.meshes[0], quad([9, 9, 9], [0.1, 0, 0], [0, 0.1, 0]), scene.meshes[2])
    )
    shadowless = radiance(device, shaders, scene, paths(scene, 64, bounces=0), 12)
    shadowed = radiance(device, shaders, lit_room(), paths(lit_room(), 64, bounces=0), 12)
    empty = radiance(device, shaders, free, paths(free, 64, bounces=0), 12)
    assert shadowless.mean() > 1.01 * shadowed.mean()
    # On the floor away from the box nothing but shadows tells the two apart.
    floor = (slice(None), slice(9, 12), slice(0, 3))
    assert two_sample_deviation(shadowless[floor], empty[floor], 1e-3) <= 1.0


def sky_scene(environment) -> Scene:
    meshes = [quad([-3, 0, 3], [6, 0, 0], [0, 0, -6]), box([-0.5, 0, -0.5], [0.5, 1, 0.5])]
    camera = Camera((1.5, 1.8, 2.2), (0, 0.3, 0), fov_y=50.0)
    return make_scene(meshes, materials=[grey(0.7)], environment=environment, camera=camera)


def test_a_map_of_one_colour_is_a_constant_sky(device, shaders) -> None:
    constant = sky_scene(ConstantEnvironment((0.8, 0.6, 0.4)))
    image = np.broadcast_to(np.array([0.8, 0.6, 0.4], np.float32), (16, 32, 3)).copy()
    mapped = sky_scene(MapEnvironment(image))
    first = radiance(device, shaders, constant, paths(constant))
    second = radiance(device, shaders, mapped, paths(mapped))
    assert two_sample_deviation(first, second) <= 1.0
    assert first.mean() == pytest.approx(second.mean(), rel=5e-3)


@pytest.mark.parametrize("rotation", [0.0, 70.0])
def test_a_map_of_a_gradient_is_that_gradient(device, shaders, rotation: float) -> None:
    gradient = GradientEnvironment((3.0, 2.0, 1.0), (0.5, 0.5, 0.5), (0.0, 0.2, 0.4))
    y = np.cos(np.pi * (np.arange(256) + 0.5) / 256.0)
    directions = np.stack([np.sqrt(1 - y * y), y, np.zeros_like(y)], axis=-1)
    image = np.repeat(gradient.sample(directions)[:, None], 512, axis=1).astype(np.float32)
    first = radiance(device, shaders, sky_scene(gradient), paths(sky_scene(gradient)))
    mapped = sky_scene(MapEnvironment(image, rotation_y=rotation))
    second = radiance(device, shaders, mapped, paths(mapped))
    # Texels are patches of constant light, 0.7 degrees high.
    assert two_sample_deviation(first, second, 0.01) <= 1.0
    assert first.mean() == pytest.approx(second.mean(), rel=5e-3)


def test_a_small_sun_in_a_map_is_found(device, shaders) -> None:
    # One texel of 1/32768 of the sphere holds all light: scattering alone would give a
    # standard error of more than the mean.
    image = np.zeros((128, 256, 3), np.float32)
    image[20, 40] = 1e4
    scene = sky_scene(MapEnvironment(image))
    open_scene = dataclasses.replace(scene, objects=scene.objects[:1])
    with Tracer(device, shaders, open_scene, SIZE) as tracer:
        item = paths(open_scene, 16, bounces=0)
        runs = tracer.runs(item, RUNS)["gi_radiance"][..., :3]
        covered = tracer.run(item, ["z_vs"])["z_vs"][..., 0] > 0.0
    edges = np.cos(np.pi * np.array([20.0, 21.0]) / 128.0)
    irradiance = 1e4 * (edges[0] ** 2 - edges[1] ** 2) / 2.0 * 2.0 * np.pi / 256.0
    # The integral of y over the texel's solid angle, times albedo / pi.
    exact = 0.7 / np.pi * irradiance
    np.testing.assert_allclose(runs[:, covered].mean(), exact, rtol=2e-3)
    assert runs[:, covered].std() < 0.05 * exact


def test_textures_colours_and_cutouts_are_seen_by_rays(device, shaders) -> None:
    # A floor lit by the sky through a panel above it; rays from the floor see its image.
    pixels = np.zeros((2, 2, 4), np.uint8)
    pixels[..., 3] = 255
    pixels[0, 0] = (255, 0, 0, 255)
    pixels[1, 1] = (0, 0, 255, 0)  # a hole
    pixels[0, 1] = pixels[1, 0] = (0, 255, 0, 255)
    uvs = np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
    panel = quad([-4, 1, -4], [8, 0, 0], [0, 0, 8], uvs=uvs)  # front down, v = 0 at z = +4
    colors = np.tile([0.5, 0.5, 0.5, 1.0], (4, 1))
    floor = quad([-4, 0, 4], [8, 0, 0], [0, 0, -8], colors=colors)
    paint = Material(
        albedo=(0.0, 0.0, 0.0),
        emission=(1.0, 1.0, 1.0),
        emission_texture=Texture(pixels[..., :].copy(), wrap=("clamp", "clamp")),
        albedo_texture=Texture(pixels, wrap=("clamp", "clamp")),
        alpha_cutoff=0.5,
    )
    views = {}
    for name, x, z in (("red", -3.0, 3.0), ("hole", 3.0, -3.0), ("green", 3.0, 3.0)):
        camera = Camera((x, 0.3, z), (x, 0.0, z), up=(0.0, 0.0, -1.0), fov_y=20.0)
        scene = make_scene(
            [floor, panel],
            materials=[Material(albedo=(1.0, 1.0, 1.0)), paint],
            objects=[SceneObject(0, 0), SceneObject(1, 1)],
            environment=ConstantEnvironment((0.0, 0.0, 0.0)),
            camera=camera,
        )
        views[name] = radiance(device, shaders, scene, paths(scene, 64, 0), 2).mean(axis=(0, 1, 2))
    # v = 0 is the top row of the image and lies at z = +4: red at (-, +).
    assert views["red"][0] > 0.2
    assert views["red"][0] > 4.0 * views["red"][1]
    assert views["green"][1] > 0.2
    assert views["green"][1] > 4.0 * views["green"][0]
    # Vertex colour halves what the floor reflects; a panel that fills the hemisphere by
    # 90 % cannot give more than that.
    assert views["red"].max() < 0.5
    # Through the hole there is only black sky; blue is never seen.
    assert views["hole"][2] < 0.01
    assert views["hole"].sum() < 0.5 * views["red"].sum()


def test_paths_are_finite_and_seeded(device, shaders) -> None:
    scene = lit_room()
    with Tracer(device, shaders, scene, SIZE) as tracer:
        item = paths(scene, 8)
        first, again = tracer.run(item, seed=1), tracer.run(item, seed=1)
        other = tracer.run(item, seed=2)
    assert np.all(np.isfinite(first["gi_radiance"]))
    np.testing.assert_array_equal(first["gi_radiance"], again["gi_radiance"])
    assert (first["gi_radiance"] != other["gi_radiance"]).any()


def test_nothing_lit_is_exactly_black(device, shaders) -> None:
    scene = make_scene([box([-1, -1, -1], [1, 1, 1])], camera=Camera((0, 0, 0), (0, 0, -1)))
    image = radiance(device, shaders, scene, paths(scene, 4), 1)
    assert not image.any()


def test_smooth_normals_lose_next_to_nothing(device, shaders) -> None:
    ball = sphere(32)
    ball = dataclasses.replace(ball, positions=ball.positions - [0.0, 0.0, 3.0])
    assert ball.normals is not None
    scene = make_scene([ball], materials=[grey(0.6)], environment=SKY)
    with Tracer(device, shaders, scene, SIZE) as tracer:
        images = tracer.run(paths(scene, 256), ["z_vs"])
    covered = images["z_vs"][..., 0] > 0.0
    found = images["gi_radiance"][covered][:, :3]
    # Of a hemisphere tilted by up to pi / 32 against its facet, (1 - cos) / 2 = 0.24 %
    # lies below the facet and sees nothing.
    assert np.all(found <= 0.6 * (1.0 + 1e-5))
    assert found.mean() > 0.6 * (1.0 - 0.0024)
    assert found.min() > 0.6 * 0.97


def test_lights_in_contact_with_surfaces_stay_finite(device, shaders) -> None:
    scene = lit_room()
    touching = [
        PointLight((0.0, -1.0, 0.6), (1e9, 1e9, 1e9)),
        PointLight((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)),
        RectangleLight((-0.5, -1.0, 0.4), (0.3, 0, 0), (0, 0, 0.3), (1e6,) * 3, visible=False),
    ]
    scene = dataclasses.replace(scene, lights=(*scene.lights, *touching))
    features = RayFeatures.of(scene)
    with Tracer(device, shaders, scene, SIZE) as tracer:
        for item in (
            paths(scene, 16),
            TracedShadowsPass(TracedShadowsSettings(shadow_rays=16), features),
            ReferenceNearPass(ReferenceNearSettings(radius=0.5, spp=16), features),
        ):
            for image in tracer.run(item).values():
                assert np.all(np.isfinite(image))
                assert image.min() >= 0.0
