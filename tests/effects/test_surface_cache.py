"""The surface cache is planned for effects that read it, and says what reaches a surface."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar

import numpy as np
import pytest

from ssdo_gl.effects.decisions import Decision
from ssdo_gl.effects.effect import Effect, ImageSource, ReasonedPass
from ssdo_gl.effects.registry import registered
from ssdo_gl.effects.request import Request
from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.ray_uniforms import ray_defines, ray_reads, ray_uniforms
from ssdo_gl.passes.surfel_light import CACHE_TABLES
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.mesh import Mesh, SceneObject
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.shapes import box
from ssdo_gl.settings import Settings

CACHE = {"surfels", "surfel_rays", "surfel_sky", "surfel_direct", "surface_cache"}
# Fewer surfels than usual, and more shadow rays: quick, and of little noise.
FEW = {"surface_cache.texel": 0.1, "surface_cache.light_samples": 64}

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
        o_irradiance = vec4(cached_irradiance(hit, met, w), 1.0);
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
        program = context.shaders.fullscreen_source(LOOKUP, ray_defines(context, self.features))
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
