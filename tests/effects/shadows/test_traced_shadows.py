"""Direct light by shadow rays against closed forms (FIELD 4.4 D, F)."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from oracle.closed_forms import rectangle_form_factor
from oracle.monte_carlo import worst_deviation
from passes.pass_harness import box, make_scene, quad
from passes.ray_harness import Tracer

from ssdo_gl.effects.shadows.traced_shadows import TracedShadowsPass, TracedShadowsSettings
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import sphere
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

SIZE = (24, 16)
RUNS = 24
CAMERA = Camera((0.5, 1.6, 0.2), (0.5, 0.0, 0.2), up=(0.0, 0.0, -1.0), fov_y=60.0)
FLOOR = quad([-10, 0, 10], [20, 0, 0], [0, 0, -20])
RADIANCE = (3.0, 2.0, 1.0)
# Rays start 4e-6 of the half-diagonal, here 14, off the floor: light at height 1 moves
# by 6e-5 of its height.
ALLOWANCE = 2e-4


def direct(scene: Scene, rays: int = 8) -> TracedShadowsPass:
    return TracedShadowsPass(TracedShadowsSettings(shadow_rays=rays), RayFeatures.of(scene))


def rectangle(corner, edge_u, edge_v, **more) -> RectangleLight:
    return RectangleLight(corner, edge_u, edge_v, RADIANCE, visible=False, **more)


LAMPS = {
    # Front down: edge_u x edge_v = -y. D1, in general position.
    "parallel": ((0.1, 1.5, -0.2), (1.0, 0.0, 0.0), (0.0, 0.0, 0.7)),
    # Front towards +x, standing clear of the floor. D2.
    "perpendicular": ((-0.9, 0.05, 0.6), (0.0, 0.0, -0.9), (0.0, 1.1, 0.0)),
    # A skew parallelogram, which cannot be drawn from by solid angle. F.
    "skew": ((0.2, 0.9, -0.3), (0.6, 0.2, 0.1), (0.25, 0.1, 0.8)),
    # Small and far: drawn from by area.
    "small": ((0.5, 6.0, 0.0), (0.05, 0.0, 0.0), (0.0, 0.0, 0.05)),
}


@pytest.mark.parametrize("name", list(LAMPS))
def test_rectangles_match_lamberts_formula(device, shaders, name: str) -> None:
    corner, edge_u, edge_v = (np.array(v) for v in LAMPS[name])
    flipped = name == "skew" and np.cross(edge_u, edge_v)[1] > 0.0
    if flipped:
        edge_u, edge_v = edge_v, edge_u
    light = rectangle(tuple(corner), tuple(edge_u), tuple(edge_v))
    scene = make_scene([FLOOR], lights=[light], camera=CAMERA)
    with Tracer(device, shaders, scene, SIZE) as tracer:
        runs = tracer.runs(direct(scene, 64), RUNS)["direct_irradiance"][..., :3]
        at = tracer.positions_ws()
    corners = np.array([corner, corner + edge_u, corner + edge_u + edge_v, corner + edge_v])
    factor = np.array(
        [[rectangle_form_factor(corners - p, np.array([0.0, 1.0, 0.0])) for p in row] for row in at]
    )
    factor = np.abs(factor)
    if name == "perpendicular":
        # Points behind the lamp's plane see its dark side.
        factor = np.where(at[..., 0] > corner[0], factor, 0.0)
    exact = np.pi * factor[..., None] * np.array(RADIANCE)
    assert exact.max() > 0.0
    assert worst_deviation(runs, exact, ALLOWANCE * exact.max()) <= 1.0
    assert worst_deviation(runs, exact * 1.01, ALLOWANCE * exact.max()) > 1.0


def test_point_spot_and_directional_lights_are_exact(device, shaders) -> None:
    place = np.array([0.3, 1.2, 0.1])
    scene = make_scene(
        [FLOOR],
        lights=[
            PointLight(tuple(place), (2.0, 0.0, 0.0)),
            SpotLight(tuple(place), (0.0, -1.0, 0.0), (0.0, 2.0, 0.0), 10.0, 30.0),
            DirectionalLight((-0.6, -0.8, 0.0), (0.0, 0.0, 2.0)),
        ],
        camera=CAMERA,
    )
    with Tracer(device, shaders, scene, SIZE) as tracer:
        image = tracer.run(direct(scene, 1))["direct_irradiance"].astype(np.float64)
        at = tracer.positions_ws()
    to_light = place - at
    distance = np.linalg.norm(to_light, axis=-1)
    cosine = to_light[..., 1] / distance
    inner, outer = np.cos(np.radians([10.0, 30.0]))
    ramp = np.clip((cosine - outer) / (inner - outer), 0.0, 1.0) ** 2
    np.testing.assert_allclose(image[..., 0], 2.0 * cosine / distance**2, rtol=2e-4)
    np.testing.assert_allclose(image[..., 1], 2.0 * ramp * cosine / distance**2, atol=5e-4)
    np.testing.assert_allclose(image[..., 2], 2.0 * 0.8, rtol=1e-5)


def test_shadows_fall_where_they_should(device, shaders) -> None:
    blocker = quad([-5, 1.0, -5], [0, 0, 10], [5.5, 0, 0])  # covers x < 0.5
    lights = [DirectionalLight((0.0, -1.0, 0.0), (1.0, 0.0, 0.0))]
    lights += [dataclasses.replace(lights[0], irradiance=(0.0, 1.0, 0.0), shadow="none")]
    lights += [dataclasses.replace(lights[0], irradiance=(0.0, 0.0, 1.0), shadow="ssdo")]
    # The camera looks from below the blocker.
    camera = dataclasses.replace(CAMERA, position=(0.5, 0.9, 0.2))
    scene = make_scene([FLOOR, blocker], lights=lights, camera=camera)
    with Tracer(device, shaders, scene, SIZE) as tracer:
        image = tracer.run(direct(scene, 4))["direct_irradiance"]
        x = tracer.positions_ws()[..., 0]
    np.testing.assert_array_equal(image[..., 0], np.where(x < 0.5, 0.0, 1.0))
    np.testing.assert_array_equal(image[..., 1], 1.0)
    np.testing.assert_array_equal(image[..., 2], 0.0)


def test_a_half_hidden_rectangle_gives_half_its_light(device, shaders) -> None:
    # Straight below the middle of a lamp whose +x half is hidden from everywhere near.
    light = rectangle((-0.5, 2.0, -0.5), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    blocker = quad([0, 1.9997, -1], [0, 0, 2], [2, 0, 0])
    camera = dataclasses.replace(CAMERA, position=(0, 1.0, 0), target=(0, 0, 0), fov_y=1.0)
    scene = make_scene([FLOOR, blocker], lights=[light], camera=camera)
    bare = make_scene([FLOOR], lights=[light], camera=camera)
    means = []
    for each in (scene, bare):
        with Tracer(device, shaders, each, (8, 8)) as tracer:
            means.append(tracer.run(direct(each, 1024))["direct_irradiance"][..., 0].mean())
    # The camera sees 1 % of the lamp's extent, over which the share is even. A blocker
    # as near to the lamp as 3e-4, 2e-5 of the half-diagonal, still counts.
    assert means[0] / means[1] == pytest.approx(0.5, abs=3e-3)


def test_an_emissive_mesh_shines_as_it_is_and_not_as_its_stand_ins(device, shaders) -> None:
    ball = sphere(128)
    ball = Mesh(ball.positions * 0.4 + [0.5, 1.0, 0.2], ball.triangles)
    glow = Material(albedo=(0.0, 0.0, 0.0), emission=RADIANCE)
    # What `emitters` makes of such a body: rectangles on it that nobody sees.
    stand_in = RectangleLight(
        (0.4, 0.6, 0.1), (0.2, 0.0, 0.0), (0.0, 0.0, 0.2), (99.0, 99.0, 99.0), visible=False
    )
    scene = make_scene(
        [FLOOR, ball],
        materials=[Material(), glow],
        objects=[SceneObject(0, 0), SceneObject(1, 1, light=0)],
        lights=[stand_in],
        camera=Camera((2.2, 1.6, 0.2), (2.2, 0.0, 0.2), up=(0.0, 0.0, -1.0), fov_y=60.0),
    )
    with Tracer(device, shaders, scene, SIZE) as tracer:
        runs = tracer.runs(direct(scene, 32), RUNS)["direct_irradiance"][..., :3]
        at = tracer.positions_ws()
    # D4, wholly above the horizon: cos / H^2; exact for the sphere, facets cover
    # (pi / 128)^2 / 2 less of its radius, twice that of its disk.
    to_ball = np.array([0.5, 1.0, 0.2]) - at
    distance = np.linalg.norm(to_ball, axis=-1)
    exact = np.pi * to_ball[..., 1] / distance * (0.4 / distance) ** 2
    exact = exact[..., None] * np.array(RADIANCE)
    allowance = (ALLOWANCE + (np.pi / 128) ** 2) * exact.max()
    assert worst_deviation(runs, exact, allowance) <= 1.0


def test_nothing_lit_is_exactly_black(device, shaders) -> None:
    behind = rectangle((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    upward = rectangle((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    lid = box([-9, 0.5, -9], [9, 0.6, 9])
    camera = dataclasses.replace(CAMERA, position=(0.5, 0.4, 0.2))
    for lights in ([], [behind], [upward]):
        scene = make_scene([FLOOR, lid], lights=lights, camera=camera)
        with Tracer(device, shaders, scene, SIZE) as tracer:
            image = tracer.run(direct(scene))["direct_irradiance"]
        assert not image.any()


def test_light_adds_up(device, shaders) -> None:
    lights = [
        rectangle((0.1, 1.5, -0.2), (1.0, 0.0, 0.0), (0.0, 0.0, 0.7)),
        PointLight((0.9, 0.7, 0.0), (0.3, 0.2, 0.1)),
    ]
    pillar = box([0.7, 0, 0.3], [0.8, 0.4, 0.4])
    images = []
    for chosen in (lights, lights[:1], lights[1:]):
        scene = make_scene([FLOOR, pillar], lights=chosen, camera=CAMERA)
        with Tracer(device, shaders, scene, SIZE) as tracer:
            images.append(tracer.runs(direct(scene), RUNS)["direct_irradiance"][..., :3])
    both, first, second = images
    # A point light has no noise, only the rounding of sums.
    assert worst_deviation(both - first - second, 0.0, 1e-5) <= 1.0


def test_hundreds_of_lights_all_arrive(device, shaders) -> None:
    # llvmpipe ends loops after 65535 turns: too many rays in one draw would go missing.
    rng = np.random.default_rng(2)
    places = rng.uniform([-3, 1.0, -3], [3, 2.0, 3], (1500, 3))
    lights = [PointLight(tuple(p), (0.1, 0.1, 0.1)) for p in places]
    # Out of view, so that the hierarchy has levels.
    stones = [box([x, 0, z], [x + 0.1, 0.1, z + 0.1]) for x in range(3, 9) for z in range(3, 9)]
    scene = make_scene([FLOOR, *stones], lights=lights, camera=CAMERA)
    with Tracer(device, shaders, scene, (8, 6)) as tracer:
        image = tracer.run(direct(scene, 64))["direct_irradiance"][..., 0]
        at = tracer.positions_ws()
    gaps = places[:, None, None] - at
    distance = np.linalg.norm(gaps, axis=-1)
    exact = np.sum(0.1 * gaps[..., 1] / distance**3, axis=0)
    np.testing.assert_allclose(image, exact, rtol=2e-4)


def test_of_ten_thousands_of_lights_some_are_asked_by_chance(device, shaders) -> None:
    # In one loop the last third of them would go missing.
    rng = np.random.default_rng(3)
    places = rng.uniform([-3, 1.5, -3], [3, 2.5, 3], (20_000, 3))
    power = rng.uniform(0.001, 0.02, 20_000)
    lights = [PointLight(tuple(p), (i, i, i)) for p, i in zip(places, power, strict=True)]
    scene = make_scene([FLOOR], lights=lights, camera=CAMERA)
    with Tracer(device, shaders, scene, (8, 6)) as tracer:
        runs = tracer.runs(direct(scene, 4), 4)["direct_irradiance"][..., 0]
        at = tracer.positions_ws()
    gaps = places[:, None, None] - at
    exact = np.einsum("n,nij->ij", power, gaps[..., 1] / np.linalg.norm(gaps, axis=-1) ** 3)
    # 4 times 4 samples of 256 lights, whose light differs by as much as itself: 1 in 64.
    np.testing.assert_allclose(runs.mean(axis=0), exact, rtol=0.07)
    assert runs.mean() == pytest.approx(exact.mean(), rel=0.01)
