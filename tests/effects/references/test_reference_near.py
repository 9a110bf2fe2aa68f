"""The ray-traced near field against closed forms, and against the sum it is a part of."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from oracle.closed_forms import corner_occlusion
from oracle.monte_carlo import two_sample_deviation, worst_deviation
from passes.pass_harness import box, make_scene, quad
from passes.ray_harness import Tracer

from ssdo_gl.effects.references.reference_ao import ReferenceAoPass, ReferenceAoSettings
from ssdo_gl.effects.references.reference_near import ReferenceNearPass, ReferenceNearSettings
from ssdo_gl.effects.shadows.traced_shadows import TracedShadowsPass, TracedShadowsSettings
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    GradientEnvironment,
    kind_of,
)
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

SIZE = (24, 16)
RUNS = 24
SKY = ConstantEnvironment((1.0, 0.5, 0.25))
COLORS = np.array([1.0, 0.5, 0.25])
FLOOR = quad([-10, 0, 10], [20, 0, 0], [0, 0, -20])
WALL = quad([0, 0, 10], [0, 0, -20], [0, 10, 0])
CAMERA = Camera((0.6, 0.8, 0.0), (0.6, 0.0, 0.0), up=(0.0, 0.0, -1.0), fov_y=50.0)
# Rays start 4e-6 of the half-diagonal off: at 0.03 from a wall 2e-3 of what it sends.
ALLOWANCE = 2e-3


def near(scene: Scene, radius: float, spp: int = 16) -> ReferenceNearPass:
    settings = ReferenceNearSettings(radius=radius, spp=spp)
    return ReferenceNearPass(settings, RayFeatures.of(scene), kind_of(scene.environment))


def grey(albedo: float, emission: float = 0.0) -> Material:
    return Material(albedo=(albedo,) * 3, emission=(emission,) * 3)


def test_corner_under_a_uniform_sky(device, shaders) -> None:
    radius = 0.7
    scene = make_scene([FLOOR, WALL], materials=[grey(0.0)], environment=SKY, camera=CAMERA)
    with Tracer(device, shaders, scene, SIZE) as tracer:
        runs = tracer.runs(near(scene, radius), RUNS)
        distance = tracer.positions_ws()[..., 0]
    visibility = 1.0 - corner_occlusion(distance / radius)
    rays = RUNS * 16
    found = runs["directional_irradiance"]
    assert worst_deviation(found[..., 3], visibility, ALLOWANCE, rays=rays) <= 1.0
    exact = np.pi * visibility[..., None] * COLORS
    assert worst_deviation(found[..., :3] / np.pi, exact / np.pi, ALLOWANCE, rays=rays) <= 1.0
    # Black surfaces send nothing.
    assert not runs["bounce_irradiance"].any()


def test_bounce_in_an_unlimited_wedge(device, shaders) -> None:
    # H1: both walls receive pi / 2 and send albedo / 2 into half of the hemisphere.
    albedo = 0.8
    scene = make_scene(
        [
            quad([0, 0, 100], [200, 0, 0], [0, 0, -200]),
            quad([0, 0, 100], [0, 0, -200], [0, 200, 0]),
        ],
        materials=[grey(albedo)],
        environment=ConstantEnvironment((1.0, 1.0, 1.0)),
        camera=dataclasses.replace(CAMERA, position=(0.032, 0.026, 0.0), target=(0.0, 0.004, 0.0)),
    )
    with Tracer(device, shaders, scene, SIZE) as tracer:
        runs = tracer.runs(near(scene, np.inf, 64), RUNS)
    for name, exact in (
        ("directional_irradiance", np.pi / 2.0),
        ("bounce_irradiance", np.pi * albedo / 4.0),
    ):
        means = runs[name][..., :3].mean(axis=(1, 2, 3))[:, None]
        # The sky past the walls' ends at +-100, seen from less than 0.04, takes
        # d / 100 / pi of the disk from the other wall.
        assert worst_deviation(means, exact, 2e-4 * np.pi) <= 1.0
        assert worst_deviation(means, exact * 1.01, 2e-4 * np.pi) > 1.0


def test_the_senders_of_a_corner_are_themselves_occluded_within_r(device, shaders) -> None:
    # The wall at height y sees the floor within R: it sends albedo (1 - occlusion(y / R)).
    radius, albedo = 0.7, 1.0
    scene = make_scene(
        [FLOOR, WALL],
        materials=[grey(albedo)],
        environment=ConstantEnvironment((1.0, 1.0, 1.0)),
        camera=CAMERA,
    )
    with Tracer(device, shaders, scene, SIZE) as tracer:
        runs = tracer.runs(near(scene, radius, 64), RUNS)["bounce_irradiance"][..., 0]
        distance = tracer.positions_ws()[..., 0]
    # E = integral over directions that meet the wall within R of L(height) cos, in a fine
    # grid of the projected disk (Nusselt): x to the wall, z up.
    grid = (np.arange(1200) + 0.5) / 1200.0
    disk_x, disk_y = np.meshgrid(grid, 2.0 * grid - 1.0, indexing="ij")
    inside = disk_x**2 + disk_y**2 < 1.0
    x, up = disk_x[inside], np.sqrt(1.0 - disk_x[inside] ** 2 - disk_y[inside] ** 2)
    cell = 2.0 / 1200.0**2
    exact = []
    for d in np.abs(distance[0]):
        meets = x * radius > d
        height = d * up[meets] / x[meets]
        exact.append(cell * np.sum(albedo * (1.0 - corner_occlusion(height / radius))))
    # Rows of the image run along the wall: all alike.
    found = runs.mean(axis=1)
    assert worst_deviation(found, np.array(exact), ALLOWANCE * np.pi, rays=RUNS * 64) <= 1.0


@pytest.mark.parametrize("radius", [0.5, np.inf])
def test_white_furnace_is_shared_out_exactly(device, shaders, radius: float) -> None:
    # Everything glows like the sky and reflects nothing: open or not, the same arrives.
    meshes = [FLOOR, WALL, box([0.4, 0, -0.2], [0.6, 0.3, 0.2])]
    scene = make_scene(
        meshes,
        materials=[Material(albedo=(0.0,) * 3, emission=(1.0,) * 3, two_sided_emission=True)],
        environment=ConstantEnvironment((1.0, 1.0, 1.0)),
        camera=CAMERA,
    )
    with Tracer(device, shaders, scene, SIZE) as tracer:
        images = tracer.run(near(scene, radius))
    total = images["directional_irradiance"][..., :3] + images["bounce_irradiance"][..., :3]
    np.testing.assert_allclose(total, np.pi, rtol=1e-5)
    assert (images["bounce_irradiance"] > 0.0).any()


def test_visibility_is_that_of_reference_ao(device, shaders) -> None:
    scene = make_scene([FLOOR, WALL, box([0.4, 0, -0.2], [0.6, 0.3, 0.2])], camera=CAMERA)
    with Tracer(device, shaders, scene, SIZE) as tracer:
        image = tracer.run(near(scene, 0.4, 32))["directional_irradiance"][..., 3]
        item = ReferenceAoPass(ReferenceAoSettings(radius=0.4, spp=32), RayFeatures.of(scene))
        visibility = tracer.run(item)["visibility"][..., 0]
    # The same rays, counted in another program.
    assert np.mean(image != visibility) < 0.01
    np.testing.assert_allclose(image, visibility, atol=2.0 / 32.0)


def test_a_lamp_marked_ssdo_is_hidden_only_by_what_is_near(device, shaders) -> None:
    lamp = RectangleLight(
        (0.3, 2.0, -0.3),
        (0.6, 0.0, 0.0),
        (0.0, 0.0, 0.6),
        (3.0, 2.0, 1.0),
        shadow="ssdo",
        visible=False,
    )
    lid = quad([-5, 1.0, -5], [0, 0, 10], [10, 0, 0])
    camera = dataclasses.replace(CAMERA, position=(0.6, 0.8, 0.0))

    def directional(meshes, radius: float, shadow: str = "ssdo") -> np.ndarray:
        scene = make_scene(meshes, lights=[dataclasses.replace(lamp, shadow=shadow)], camera=camera)
        with Tracer(device, shaders, scene, SIZE) as tracer:
            if shadow == "ssdo":
                return tracer.runs(near(scene, radius), RUNS)["directional_irradiance"][..., :3]
            item = TracedShadowsPass(TracedShadowsSettings(shadow_rays=16), RayFeatures.of(scene))
            return tracer.runs(item, RUNS)["direct_irradiance"][..., :3]

    unshadowed = directional([FLOOR], np.inf)
    # As much as a lamp with a shadow map gives: only the name of the term differs.
    assert two_sample_deviation(unshadowed, directional([FLOOR], 1.0, "map"), 1e-5) <= 1.0
    assert two_sample_deviation(directional([FLOOR, lid], 0.5), unshadowed) <= 1.0
    assert not directional([FLOOR, lid], 2.0).any()


def test_points_marked_ssdo_follow_one_ray(device, shaders) -> None:
    light = PointLight((0.6, 1.5, 0.0), (2.0, 2.0, 2.0), shadow="ssdo")
    sun = DirectionalLight((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), shadow="ssdo")
    blocker = quad([-5, 0.3, -5], [0, 0, 10], [5.5, 0, 0])  # x < 0.5
    camera = dataclasses.replace(CAMERA, position=(0.6, 0.29, 0.0))
    for lights, radius, hidden in (([light], 1.0, True), ([sun], 1.0, True), ([sun], 0.2, False)):
        scene = make_scene([FLOOR, blocker], lights=lights, camera=camera)
        with Tracer(device, shaders, scene, SIZE) as tracer:
            image = tracer.run(near(scene, radius, 2))["directional_irradiance"][..., 0]
            x = tracer.positions_ws()[..., 0]
        # Light from 1.5 above x = 0.6 passes the edge at (0.5, 0.3): shadow to 0.475.
        edge = 0.6 - 0.1 * 1.5 / 1.2 if lights == [light] else 0.5
        assert np.all(image[x > edge + 0.01] > 0.0)
        assert np.all((image[x < edge - 0.01] == 0.0) == hidden)


def test_emission_counts_as_bounce_only_where_no_light_delivers_it(device, shaders) -> None:
    lamp = RectangleLight((-0.2, 0.5, -0.2), (0.4, 0, 0), (0, 0, 0.4), (5.0, 5.0, 5.0))
    body = quad(lamp.corner, lamp.edge_u, lamp.edge_v)
    glow = Material(albedo=(0.0,) * 3, emission=(5.0,) * 3)
    camera = Camera((0.0, 0.45, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), fov_y=50.0)
    means = []
    for light in (0, None):
        scene = make_scene(
            [FLOOR, body],
            materials=[grey(0.5), glow],
            objects=[SceneObject(0, 0), SceneObject(1, 1, light=light)],
            lights=[lamp] if light == 0 else [],
            camera=camera,
        )
        with Tracer(device, shaders, scene, SIZE) as tracer:
            item = TracedShadowsPass(TracedShadowsSettings(shadow_rays=64), RayFeatures.of(scene))
            direct = tracer.run(item)["direct_irradiance"][..., 0].mean()
            bounce = tracer.run(near(scene, np.inf, 256))["bounce_irradiance"][..., 0].mean()
        means.append((direct, bounce))
    assert means[0][0] > 0.5
    assert means[0][1] == 0.0
    assert means[1][0] == 0.0
    # The same light, found by the rays themselves.
    assert means[1][1] == pytest.approx(means[0][0], rel=0.01)


def test_a_gradient_sky_is_weighted_by_direction(device, shaders) -> None:
    gradient = GradientEnvironment((3.0, 2.0, 1.0), (0.5, 0.5, 0.5), (0.0, 0.2, 0.4))
    scene = make_scene([FLOOR], materials=[grey(0.5)], environment=gradient, camera=CAMERA)
    with Tracer(device, shaders, scene, SIZE) as tracer:
        runs = tracer.runs(near(scene, 1.0), RUNS)
    # Integral of (h + (z - h) y) cos over the upper hemisphere: pi h + (z - h) 2 pi / 3.
    zenith, horizon = np.array([3.0, 2.0, 1.0]), np.array([0.5, 0.5, 0.5])
    exact = np.pi * horizon + (zenith - horizon) * 2.0 * np.pi / 3.0
    assert worst_deviation(runs["directional_irradiance"][..., :3], exact) <= 1.0
    np.testing.assert_array_equal(runs["directional_irradiance"][..., 3], 1.0)


def test_background_is_neutral(device, shaders) -> None:
    small = quad([0.5, 0, 0.1], [0.2, 0, 0], [0, 0, -0.2])
    scene = make_scene([small], environment=SKY, camera=CAMERA)
    with Tracer(device, shaders, scene, SIZE) as tracer:
        images = tracer.run(near(scene, 0.5), ["z_vs"])
    empty = images["z_vs"][..., 0] == 0.0
    assert empty.any()
    np.testing.assert_array_equal(images["directional_irradiance"][empty][:, :3], 0.0)
    np.testing.assert_array_equal(images["directional_irradiance"][empty][:, 3], 1.0)
    np.testing.assert_array_equal(images["bounce_irradiance"][empty], 0.0)
