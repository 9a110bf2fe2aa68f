"""The surface cache is planned for effects that read it, and says what reaches a surface."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import ClassVar

import numpy as np
import pytest
from program_of_text import fullscreen_source

from ssdo_gl.effects.effect import Effect, ImageSource, ReasonedPass
from ssdo_gl.effects.registry import registered
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.rays.ray_libraries import ray_defines, ray_reads, ray_uniforms
from ssdo_gl.passes.surfels.surfel_textures import CACHE_TABLES
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import box, quad
from ssdo_gl.scene.lights import PointLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

CACHE = {"surfels", "surfel_rays", "surfel_sky", "surfel_direct", "surface_cache"}
# Fewer surfels than usual, and more shadow rays: quick, and of little noise.
FEW = {"surface_cache.texel": 0.1, "surface_cache.light_samples": 64}

# It is .01. Texels of which only the widest are looked up rightly have .23.
WIDE_GROUND_BOUND = 0.05

LOOKUP = """#version 330 core
// What the cache holds where the camera's rays end.
#include "rays/surface_cache.glsl"
layout(location = 0) out vec4 o_irradiance;
void main()
{
    vec3 ray_vs = view_ray_at(uv_of_texel(ivec2(gl_FragCoord.xy)));
    vec3 w = u_ns_from_vs * normalize(ray_vs);
    BvhHit hit = bvh_nearest(u_eye_ns, w, RAY_FAR);
    o_irradiance = vec4(0.0);
    if (hit.record >= 0) {
        Surface met = surface_at_hit(hit, u_eye_ns, w);
        o_irradiance = vec4(cached_light(surfel_met(hit, met, w)).rgb, 1.0);
    }
}
"""


class LookupPass(RenderPass):
    """Writes `lookup_irradiance`."""

    name = "lookup"
    writes: ClassVar[Mapping[str, TextureSpec]] = {"lookup_irradiance": TextureSpec(4)}
    depends_on = ("view", "geometry")

    def __init__(self, features: RayFeatures) -> None:
        self.features = features
        self.reads = (*ray_reads(features, shades=True), *CACHE_TABLES)

    def execute(self, context: PassContext) -> None:
        program = fullscreen_source(context.shaders, LOOKUP, ray_defines(context, self.features))
        textures = {f"t_{name}": context.inputs[name] for name in self.reads}
        draw_fullscreen(context.gl, program, context.target, ray_uniforms(context), textures)


class Lookup(Effect):
    """What the cache holds, as an image."""

    name = "lookup"
    shown_by = frozenset({"direct"})
    images = ("lookup",)
    traces = True
    reads_surface_cache = True

    def need(self, request: Request) -> Decision:
        return Decision("lookup", True, "it was asked for", ("lookup",))

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        yield LookupPass(RayFeatures.of(request.scene)), "looks the cache up"

    def image(self, request: Request, name: str) -> ImageSource | None:
        return ImageSource("lookup_irradiance", 3)


@pytest.fixture
def lookup():
    with registered(Lookup()):
        yield


def glowing_room(albedo: float) -> Scene:
    material = Material(albedo=(albedo,) * 3, emission=(1.0, 1.0, 1.0))
    mesh = box()
    inward = Mesh(mesh.positions, mesh.triangles[:, ::-1])
    camera = Camera((0.1, 0.0, 0.4), (0.0, 0.0, 0.0))
    return Scene((inward,), (material,), (SceneObject(0, 0),), camera)


def test_it_is_planned_for_who_reads_it_and_kept_while_the_camera_moves(
    device, shaders, lookup
) -> None:
    scene = glowing_room(0.5)
    settings = Settings(size=(32, 18), method="direct", overrides=FEW)
    with Renderer(scene, settings, device=device, shaders=shaders) as renderer:
        plain = renderer.render(["beauty"])
        assert not CACHE & {row.name for row in plain.passes}
        first = renderer.render(["lookup"])
        assert {row.name for row in first.passes if row.ran} >= CACHE
        moved = renderer.render(["lookup"], camera=Camera((0.0, 0.1, 0.3), (0.0, 0.0, 0.0)))
        assert "lookup" in {row.name for row in moved.passes if row.ran}
        assert not CACHE & {row.name for row in moved.passes if row.ran}


def test_every_pixel_of_a_furnace_finds_its_irradiance(device, shaders, lookup) -> None:
    settings = Settings(size=(64, 36), method="direct", overrides=FEW)
    with Renderer(glowing_room(0.9), settings, device=device, shaders=shaders) as renderer:
        image = renderer.render(["lookup"]).images["lookup"]
    # A single surfel is off by the noise of its 64 shadow rays, a tenth of what is direct
    # light, and all of some 500 by the twentieth part.
    np.testing.assert_allclose(image, 10.0 * np.pi, rtol=0.05)
    np.testing.assert_allclose(image.mean(), 10.0 * np.pi, rtol=0.008)


def test_light_is_looked_up_where_it_lies_on_a_wide_ground(device, shaders, lookup) -> None:
    """Under a lamp a fifth of a unit over it, beside a box; its texels would be a unit wide."""
    ground, body = np.diag([60.0, 60.0, 1.0, 1.0]), np.diag([0.3, 0.3, 0.3, 1.0])
    ground[:2, 3], body[:3, 3] = -30.0, (0.4, 0.0, 0.15)
    black = Material(albedo=(0.0, 0.0, 0.0))
    scene = Scene(
        (quad(), box()),
        (black,),
        (SceneObject(0, 0, ground[None]), SceneObject(1, 0, body[None])),
        Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), up=(0.0, 1.0, 0.0), fov_y=40.0),
        (PointLight((0.1, 0.0, 0.2), (1.0, 1.0, 1.0)),),
    )
    settings = Settings(size=(64, 36), method="direct")
    with Renderer(scene, settings, device=device, shaders=shaders) as renderer:
        image = renderer.render(["lookup"]).images["lookup"]
    y, x = (
        (np.mgrid[:36, :64] - np.array([17.5, 31.5])[:, None, None]) * 3.0 * np.tan(np.pi / 9) / 18
    )
    expected = 0.2 / ((x - 0.1) ** 2 + y**2 + 0.04) ** 1.5
    # Where the lamp is, beside the box.
    beside = (np.abs(x) < 0.2) & (np.abs(y) < 0.2)
    error = np.abs(image[..., 0] / expected - 1.0)[beside]
    assert np.median(error) < WIDE_GROUND_BOUND


WHITE = Material(albedo=(0.7,) * 3)
BODY = box()
ROOM = Mesh(BODY.positions, BODY.triangles[:, ::-1])
INSIDE = Camera((0.1, 0.0, 0.45), (0.0, 0.0, 0.0), fov_y=80.0)


@cache
def objects(body_x: float) -> tuple[SceneObject, ...]:
    """Return the very same objects for the same place, so that nothing seems to have changed."""
    body = np.diag([0.3, 0.3, 0.3, 1.0])
    body[:3, 3] = body_x, -0.35, 0.0
    return SceneObject(0, 0), SceneObject(1, 0, body[None])


def room(lamp_x: float, body_x: float = 0.2, intensity: float = 1.0) -> Scene:
    """Return a white room with a lamp and a box in it."""
    lamp = PointLight((lamp_x, 0.3, 0.1), (intensity,) * 3)
    return Scene((ROOM, BODY), (WHITE,), objects(body_x), INSIDE, (lamp,))


class Live:
    """Draws frames as a window does."""

    def __init__(self, renderer: Renderer) -> None:
        self.renderer = renderer

    def frame(self, scene: Scene) -> tuple[np.ndarray, bool]:
        """Return what the cache holds, and whether it is settled."""
        self.renderer.use_scene(scene)
        drawing = self.renderer.draw(["lookup"], camera=scene.camera)
        return drawing.planes["lookup"].read()[..., :3].astype(np.float64), drawing.is_settled

    def settled(self, scene: Scene) -> tuple[np.ndarray, int]:
        """Return what the cache holds in the end, and after how many frames."""
        for count in range(1, 60):
            image, is_settled = self.frame(scene)
            if is_settled:
                return image, count
        raise AssertionError("it does not settle")


@pytest.fixture
def live(device, shaders, lookup) -> Iterator[Live]:
    settings = Settings(size=(64, 36), method="direct", overrides=FEW)
    with Renderer(room(-0.2), settings, device=device, shaders=shaders) as renderer:
        yield Live(renderer)


def fresh(device, shaders, scene: Scene) -> np.ndarray:
    settings = Settings(size=(64, 36), method="direct", overrides=FEW)
    with Renderer(scene, settings, device=device, shaders=shaders) as renderer:
        return renderer.render(["lookup"]).images["lookup"].astype(np.float64)


def test_the_first_live_frame_is_complete_and_costs_nothing_again(device, shaders, live) -> None:
    first, is_settled = live.frame(room(-0.2))
    assert is_settled
    np.testing.assert_array_equal(first, fresh(device, shaders, room(-0.2)))
    again = live.renderer.draw(["lookup"], camera=room(-0.2).camera)
    assert not CACHE & {row.name for row in again.passes if row.ran}


def test_a_moved_lamp_is_followed_to_the_same_light(device, shaders, live) -> None:
    before, _ = live.frame(room(-0.2))
    first, is_settled = live.frame(room(0.3))
    expected = fresh(device, shaders, room(0.3))
    assert not is_settled
    assert np.abs(first - expected).mean() < 0.8 * np.abs(before - expected).mean()
    image, count = live.settled(room(0.3))
    assert 3 <= count <= 15
    # Both have converged to 1e-4 of what was missing.
    np.testing.assert_allclose(image, expected, rtol=1e-3)


def of_metal(scene: Scene) -> Scene:
    """Return the scene with a body of metal."""
    metal = replace(WHITE, metallic=1.0, roughness=0.3, specular=1.0)
    walls, body = scene.objects
    return replace(scene, materials=(WHITE, metal), objects=(walls, replace(body, material=1)))


def test_metal_lit_by_a_moved_lamp_comes_to_the_same_light(device, shaders, live) -> None:
    live.frame(room(-0.2))
    # What is metal is known as soon as it is.
    image, _ = live.settled(of_metal(room(-0.2)))
    expected = fresh(device, shaders, of_metal(room(-0.2)))
    np.testing.assert_allclose(image.mean(), expected.mean(), rtol=2e-3)
    image, count = live.settled(of_metal(room(0.3)))
    assert 6 <= count <= 30
    expected = fresh(device, shaders, of_metal(room(0.3)))
    # From where else light arrives, and what metal makes of it, is found in turns.
    np.testing.assert_allclose(image, expected, rtol=5e-3)


def test_a_lamp_switched_off_is_gone_within_ten_frames(live) -> None:
    before, _ = live.frame(room(-0.2))
    dark = room(-0.2, intensity=0.0)
    for _ in range(10):
        image, _ = live.frame(dark)
    assert image.mean() < 0.05 * before.mean()


def test_a_moved_body_takes_its_surfels_along(device, shaders, live) -> None:
    live.frame(room(-0.2))
    image, count = live.settled(room(-0.2, body_x=-0.1))
    assert 8 <= count <= 20
    expected = fresh(device, shaders, room(-0.2, body_x=-0.1))
    # Other rays than those of surfels made for the new place, which err by a tenth of what is
    # indirect, and other texels along the shadow's edge.
    np.testing.assert_allclose(image.mean(), expected.mean(), rtol=0.02)
    error = np.abs(image - expected) / expected
    assert np.median(error) < 0.05


def test_other_settings_make_other_surfels(device, shaders, live) -> None:
    live.frame(room(-0.2))
    coarse = Settings(size=(64, 36), method="direct", overrides={**FEW, "surface_cache.texel": 0.3})
    live.renderer.use(coarse)
    image, is_settled = live.frame(room(-0.2))
    assert is_settled
    with Renderer(room(-0.2), coarse, device=device, shaders=shaders) as renderer:
        np.testing.assert_array_equal(image, renderer.render(["lookup"]).images["lookup"])


def test_other_frames_do_not_depend_on_live_ones(device, shaders, live) -> None:
    live.frame(room(-0.2))
    live.frame(room(0.3))
    image = live.renderer.render(["lookup"]).images["lookup"]
    np.testing.assert_array_equal(image, fresh(device, shaders, room(0.3)))
