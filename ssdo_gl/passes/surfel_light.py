"""Light that the scene's surfaces receive, all bounces, kept in surfels whatever the view.

The rays of every surfel are traced once for each state of the geometry. What they met is
kept, so that light is gathered anew, bounce after bounce, without any ray: only shadow
rays follow where lights move.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.readback import read_texture
from ssdo_gl.gpu.shader import Program
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.passes.environment_uniforms import (
    MAP_RADIANCE,
    environment_kind,
    environment_uniforms,
)
from ssdo_gl.passes.ray_uniforms import (
    EMITTER_TABLES,
    bvh_of,
    emitters_of,
    ray_defines,
    ray_reads,
    ray_uniforms,
    stream_of,
)
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.raytracing.surfels import Surfels, build_surfels
from ssdo_gl.raytracing.torn_surfels import torn
from ssdo_gl.scene.environment_kinds import Environment
from ssdo_gl.settings.fields import setting

# What rays/surface_cache.glsl reads beside the tables of rays that shade what they hit.
CACHE_TABLES = ("surfel_places", "surfel_splits", "surface_cache")
# As rays/surface_cache.glsl lays its textures out.
SURFELS_PER_ROW = 256
SLOTS_PER_ROW = 1024
# Surfels have numbers of 16 bits, and one stands for the sky.
MOST_SURFELS = 65535
# More groups of lights than this are drawn from by chance instead of gone through.
MOST_GROUPS = 16
# Bounces whose growth tells how much light stays in the scene.
PROBED_BOUNCES = 4
# The light that is left when the iteration ends, relative to all.
TOLERANCE = 1e-4


@dataclass(frozen=True)
class SurfaceCacheSettings:
    """Settings of the surface cache."""

    surfels: int = setting(
        32768, "pieces of surface that keep light, both sides, at most", low=64, high=MOST_SURFELS
    )
    texel: float = setting(
        0.03, "side of the smallest piece", unit="of the scene's half-diagonal", low=1e-3, high=1.0
    )
    rays_per_side: int = setting(8, "root of the rays that a piece gathers by", low=2, high=16)
    light_samples: int = setting(16, "shadow rays of a piece, all lights together", low=1, high=64)


def surfel_rows(count: int) -> int:
    """Return the height of a texture with a texel for each of `count` surfels."""
    return -(-count // SURFELS_PER_ROW)


def _texture(gl: moderngl.Context, values: NDArray[Any]) -> moderngl.Texture:
    """Return a texture of values (S, N, 4) of surfels: a tile for each of N, bottom up."""
    count, tiles = values.shape[:2]
    image = np.zeros((tiles, surfel_rows(count) * SURFELS_PER_ROW, 4), dtype=values.dtype)
    image[:, :count] = values.swapaxes(0, 1)
    size = (SURFELS_PER_ROW, tiles * surfel_rows(count))
    dtype = "u4" if values.dtype == np.uint32 else "f4"
    return make_texture(gl, size, 4, dtype, image.tobytes())


class _SurfelPass(RenderPass):
    """What passes share whose rays start from surfels."""

    def __init__(
        self,
        settings: SurfaceCacheSettings,
        features: RayFeatures,
        environment: Environment | None = None,
    ) -> None:
        self.settings = settings
        self.features = features
        self.environment_kind = environment_kind(environment)

    def settings_key(self) -> Hashable:
        """Return the settings, the features and the kind of sky."""
        return self.settings, self.features, self.environment_kind

    def program(self, context: PassContext, *further: str) -> Program:
        """Return the pass' program, with what all share set."""
        defines = ray_defines(context, self.features)
        defines["ENVIRONMENT_KIND"] = self.environment_kind
        own = {"SURFEL_RAYS_PER_SIDE": self.settings.rays_per_side}
        defines |= {name: own[name] for name in further}
        program = context.shaders.fullscreen(f"passes/{self.name}.frag", defines)
        program.set(
            {
                **ray_uniforms(context),
                **environment_uniforms(context.frame),
                "u_surfel_rows": _rows(context),
                "u_stream": stream_of(0, 0),
                "u_shared_bits": (1 << int(math.log2(self.settings.rays_per_side))) - 1,
            },
            {f"t_{name}": context.inputs[name] for name in self.reads},
        )
        return program


def _rows(context: PassContext) -> int:
    return surfel_rows(context.facts["surfel_points"])


class SurfelsPass(_SurfelPass):
    """Uploads `surfel_points`, `surfel_places` and `surfel_splits`.

    The number of surfels comes with `surfel_points`.
    """

    name = "surfels"
    writes: Mapping[str, TextureSpec] = {
        "surfel_points": TextureSpec(4, "u4", own=True),
        "surfel_places": TextureSpec(2, "u4", own=True),
        "surfel_splits": TextureSpec(4, "f4", own=True),
    }
    depends_on = ("geometry",)

    def __init__(self, settings: SurfaceCacheSettings, features: RayFeatures) -> None:
        super().__init__(settings, features)
        self.reads = ray_reads(features)

    def execute(self, context: PassContext) -> Produced:
        """Cut the surfaces up and return the tables as new textures."""
        gl, bvh = context.gl, bvh_of(context)
        whole = build_surfels(bvh, self.settings.surfels, self.settings.texel)
        surfels = torn(whole, bvh, *self._walls(context, whole), MOST_SURFELS)
        points = np.empty((*surfels.positions.shape[:2], 4), dtype=np.uint32)
        points[..., :3], points[..., 3] = surfels.positions.view(np.uint32), surfels.normals
        splits = np.zeros((surfels.count, 2, 4), dtype=np.float32)
        splits[:, 0], splits[:, 1, 0] = surfels.planes, surfels.others
        rows = -(-len(whole.places) // SLOTS_PER_ROW)
        places = np.zeros((rows * SLOTS_PER_ROW, 2), dtype=np.uint32)
        places[: len(whole.places)] = whole.places
        return {
            "surfel_points": TextureWithFacts(_texture(gl, points), surfels.count),
            "surfel_places": make_texture(gl, (SLOTS_PER_ROW, rows), 2, "u4", places.tobytes()),
            "surfel_splits": _texture(gl, splits),
        }

    def _walls(self, context: PassContext, surfels: Surfels) -> tuple[IntArray, FloatArray]:
        """Return what each line across each surfel meets, and how far along."""
        ends = np.zeros((*surfels.ends.shape[:2], 4), dtype=np.float32)
        ends[..., :3] = surfels.ends
        rows = surfel_rows(surfels.count)
        lines = surfels.ends.shape[1]
        met = make_texture(context.gl, (SURFELS_PER_ROW, rows * lines), 2, "u4")
        program = context.shaders.fullscreen(
            "passes/surfel_lines.frag", ray_defines(context, self.features)
        )
        uniforms = {**ray_uniforms(context), "u_surfel_rows": rows}
        textures = {f"t_{name}": context.inputs[name] for name in self.reads}
        textures["t_surfel_ends"] = _texture(context.gl, ends)
        with _target(context.gl, met) as target:
            draw_fullscreen(context.gl, program, target, uniforms, textures)
        words = np.frombuffer(met.read(), dtype=np.uint32).reshape(lines, -1, 2)
        words = words[:, : surfels.count].swapaxes(0, 1)
        return words[..., 0].astype(np.int64), words[..., 1].copy().view(np.float32)


class SurfelRaysPass(_SurfelPass):
    """Writes `surfel_hits`: what the rays of all surfels meet, layout in its shader."""

    name = "surfel_rays"
    writes: Mapping[str, TextureSpec] = {"surfel_hits": TextureSpec(2, "u4", own=True)}
    depends_on = ("geometry",)

    def __init__(self, settings: SurfaceCacheSettings, features: RayFeatures) -> None:
        super().__init__(settings, features)
        self.reads = (
            "surfel_points",
            "surfel_places",
            "surfel_splits",
            *ray_reads(features, shades=True),
        )

    def execute(self, context: PassContext) -> Produced:
        """Trace, one row of tiles after the other."""
        side, rows = self.settings.rays_per_side, _rows(context)
        texture = make_texture(context.gl, (side * SURFELS_PER_ROW, side * rows), 2, "u4")
        program = self.program(context, "SURFEL_RAYS_PER_SIDE")
        with _target(context.gl, texture) as target:
            for tile in range(side):
                target.scissor = (0, tile * rows, texture.width, rows)
                draw_fullscreen(context.gl, program, target, {}, {})
                context.gl.finish()
                if context.progress is not None:
                    context.progress("surface cache", tile + 1, side)
        return {"surfel_hits": texture}


class SurfelSkyPass(_SurfelPass):
    """Writes `surfel_sky`: irradiance by a sky that is not a map; 0 where there is none."""

    name = "surfel_sky"
    writes: Mapping[str, TextureSpec] = {"surfel_sky": TextureSpec(4, "f4", own=True)}
    depends_on = ("geometry", "environment")

    def __init__(
        self,
        settings: SurfaceCacheSettings,
        features: RayFeatures,
        environment: Environment | None,
    ) -> None:
        super().__init__(settings, features, environment)
        if self.environment_kind == 3:
            self.environment_kind = 0
        self.reads = ("bvh", "surfel_points", "surfel_hits")

    def execute(self, context: PassContext) -> Produced:
        """Add up the sky in all directions that are open."""
        texture = make_texture(context.gl, (SURFELS_PER_ROW, _rows(context)), 4, "f4")
        with _target(context.gl, texture) as target:
            program = self.program(context, "SURFEL_RAYS_PER_SIDE")
            draw_fullscreen(context.gl, program, target, {}, {})
        return {"surfel_sky": texture}


class SurfelDirectPass(_SurfelPass):
    """Writes `surfel_direct`: irradiance by sky, lights and all that glows."""

    name = "surfel_direct"
    writes: Mapping[str, TextureSpec] = {"surfel_direct": TextureSpec(4, "f4", own=True)}
    depends_on = ("geometry", "lights", "environment")

    def __init__(
        self,
        settings: SurfaceCacheSettings,
        features: RayFeatures,
        environment: Environment | None,
    ) -> None:
        super().__init__(settings, features, environment)
        self.reads = (
            "surfel_points",
            "surfel_sky",
            *ray_reads(features, shades=True),
            *EMITTER_TABLES,
            *((MAP_RADIANCE,) if self.environment_kind == 3 else ()),
        )

    def execute(self, context: PassContext) -> Produced:
        """Trace shadow rays."""
        groups = emitters_of(context).group_count
        draws = groups > MOST_GROUPS
        samples = self.settings.light_samples
        uniforms = {
            "u_samples": samples if draws else max(1, samples // max(groups, 1)),
            "u_draws_groups": draws,
        }
        texture = make_texture(context.gl, (SURFELS_PER_ROW, _rows(context)), 4, "f4")
        with _target(context.gl, texture) as target:
            draw_fullscreen(context.gl, self.program(context), target, uniforms, {})
        return {"surfel_direct": texture}


class SurfaceCachePass(RenderPass):
    """Writes `surface_cache`: irradiance of surfels by all light, any number of bounces."""

    name = "surface_cache"
    reads = ("surfel_points", "surfel_hits", "surfel_direct")
    writes: Mapping[str, TextureSpec] = {"surface_cache": TextureSpec(4, "f4", own=True)}

    def __init__(self, settings: SurfaceCacheSettings) -> None:
        self.settings = settings

    def execute(self, context: PassContext) -> Produced:
        """Add bounces until what is missing is below the tolerance."""
        bounces = _Bounces(context, self.settings.rays_per_side)
        kept = bounces.share_kept()
        return {"surface_cache": bounces.gathered(context.inputs["surfel_direct"], kept)}


class _Bounces:
    """Textures between which light goes to and fro."""

    def __init__(self, context: PassContext, rays_per_side: int) -> None:
        self.gl = context.gl
        self.size = context.inputs["surfel_direct"].size
        self.program = context.shaders.fullscreen(
            "passes/surface_cache.frag", {"SURFEL_RAYS_PER_SIDE": rays_per_side}
        )
        self.program.set(
            {"u_surfel_rows": self.size[1]}, {"t_surfel_hits": context.inputs["surfel_hits"]}
        )

    def texture(self, value: float) -> moderngl.Texture:
        """Return a texture with a number for each surfel."""
        data = np.full((self.size[1], self.size[0], 4), value, dtype=np.float32)
        return make_texture(self.gl, self.size, 4, "f4", data)

    def share_kept(self) -> float:
        """Return a bound on the share of light that a bounce keeps, on average over bounces.

        Some norm of each bounce's map is 1 or less for albedos up to 1, and that of four
        bounces, by its root, bounds how light dies away, whatever the light.
        """
        last, black = self.texture(1.0), self.texture(0.0)
        for _ in range(PROBED_BOUNCES):
            last = self.step(black, last, black, 1.0)
        most = float(read_texture(last)[..., :3].max())
        return float(min(most ** (1.0 / PROBED_BOUNCES), 1.0 - 1e-3))

    def gathered(self, direct: moderngl.Texture, kept: float) -> moderngl.Texture:
        """Return all light by Chebyshev's iteration."""
        last_but_one, last = self.texture(0.0), self.texture(0.0)
        for over in relaxation(kept):
            last_but_one, last = last, self.step(direct, last, last_but_one, over)
        return last

    def step(
        self,
        direct: moderngl.Texture,
        last: moderngl.Texture,
        last_but_one: moderngl.Texture,
        over: float,
    ) -> moderngl.Texture:
        """Return one more bounce than `last` as a new texture."""
        texture = make_texture(self.gl, self.size, 4, "f4")
        inputs = {"t_surfel_direct": direct, "t_last": last, "t_last_but_one": last_but_one}
        with _target(self.gl, texture) as target:
            draw_fullscreen(self.gl, self.program, target, {"u_over": over}, inputs)
        return texture


def relaxation(kept: float, tolerance: float = TOLERANCE) -> Iterator[float]:
    """Yield the factor of each step of Chebyshev's iteration until it has converged.

    Parameters
    ----------
    kept : float
        Bound on the spectrum of one bounce, [0, 1).
    tolerance : float
        Of what was missing at first.
    """
    # The error shrinks by `rate` with every step (Golub and Varga 1961), where plain
    # bounces, which shrink it by `kept`, take 500 steps for 0.99 instead of 70.
    rate = kept / (1.0 + math.sqrt(1.0 - kept**2))
    count = 1 if rate == 0.0 else math.ceil(math.log(tolerance / 2.0) / math.log(rate))
    over = 1.0
    for step in range(max(count, 1)):
        yield over
        over = 1.0 / (1.0 - kept**2 * over / (2.0 if step == 0 else 4.0))
    # A plain bounce of what has converged smooths what single surfels are off by.
    yield 1.0


@contextmanager
def _target(gl: moderngl.Context, texture: moderngl.Texture) -> Iterator[Any]:
    """Lend a framebuffer that draws into `texture`."""
    target = make_framebuffer(gl, [texture])
    try:
        yield target
    finally:
        target.release()
