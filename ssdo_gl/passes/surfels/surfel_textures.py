"""What all passes of the surface cache share: settings, sizes, programs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.program import Program
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.passes.environment_uniforms import environment_defines, environment_uniforms
from ssdo_gl.passes.own_textures import drawing_into
from ssdo_gl.passes.rays import ray_defines, ray_uniforms, stream_of
from ssdo_gl.raytracing.openings import Openings
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.raytracing.torn_surfels import TornSurfels
from ssdo_gl.scene.environment import EnvironmentKind
from ssdo_gl.settings.fields import setting

# What rays/surface_cache.glsl reads beside the tables of rays that shade what they hit.
CACHE_TABLES = ("surfel_places", "surfel_splits", "surface_cache")


def cache_tables(features: RayFeatures) -> tuple[str, ...]:
    """Return what rays/surface_cache.glsl reads beside the tables of rays."""
    return (*CACHE_TABLES, *(("surfel_quarters", "surfel_rest") if features.lobes else ()))


# As rays/surface_cache.glsl lays its textures out.
SURFELS_PER_ROW = 256
SLOTS_PER_ROW = 1024
# Surfels have numbers of 16 bits, and one stands for the sky.
MOST_SURFELS = 65535
# Of the hemisphere over a surfel, which keep light apart that is sent on in lobes.
QUARTERS = 4


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


@dataclass(frozen=True, eq=False)
class SurfelSet:
    """Surfels that were made together; they stay the same ones while what bears them moves.

    Attributes
    ----------
    topology : tuple
        Settings, meshes, sides of materials, and mesh, material and number of instances of each
        object: while these are the same, triangles keep their numbers, and surfels theirs.
    depth : int
        As in `Surfels`.
    openings : Openings
        Through which rooms see the sky; of a scene that has one.
    """

    surfels: TornSurfels
    topology: tuple[object, ...]
    depth: int
    openings: Openings

    @property
    def count(self) -> int:
        """Number of surfels."""
        return self.surfels.count


def opening_uniforms(context: PassContext) -> tuple[int, dict[str, object]]:
    """Return how many openings there are, and the uniform of rays/openings.glsl.

    Of a pass that reads `CACHE_TABLES` or the points of surfels.
    """
    known = context.facts.get("surfel_points")
    openings = known.openings if isinstance(known, SurfelSet) else context.facts[CACHE_TABLES[0]]
    assert isinstance(openings, Openings)
    count = openings.count
    return count, {"u_openings": openings.corners.reshape(-1, 3)} if count else {}


def surfel_rows(count: int) -> int:
    """Return the height of a texture with a texel for each of `count` surfels."""
    return -(-count // SURFELS_PER_ROW)


def upload(gl: moderngl.Context, values: NDArray[Any]) -> moderngl.Texture:
    """Return a texture of values (S, N, 4) of surfels: a tile for each of N, bottom up."""
    count, tiles = values.shape[:2]
    image = np.zeros((tiles, surfel_rows(count) * SURFELS_PER_ROW, 4), dtype=values.dtype)
    image[:, :count] = values.swapaxes(0, 1)
    size = (SURFELS_PER_ROW, tiles * surfel_rows(count))
    dtype = "u4" if values.dtype == np.uint32 else "f4"
    return make_texture(gl, size, 4, dtype, image.tobytes())


def drawn(
    gl: moderngl.Context,
    rows: int,
    program: Program,
    uniforms: Mapping[str, object],
    textures: Mapping[str, moderngl.Texture],
) -> moderngl.Texture:
    """Return a new texture with what a program says of each surfel."""
    texture = make_texture(gl, (SURFELS_PER_ROW, rows), 4, "f4")
    with drawing_into(gl, texture) as target:
        draw_fullscreen(gl, program, target, uniforms, textures)
    return texture


@dataclass(frozen=True)
class SurfelProgram:
    """What identifies a program whose rays start from surfels."""

    settings: SurfaceCacheSettings
    features: RayFeatures
    environment: EnvironmentKind = "none"

    @property
    def light_count(self) -> int:
        """Into how many textures light is drawn: with lobes, as rays/quarter_sums.glsl says."""
        return 1 + QUARTERS * self.features.lobes

    def light_textures(
        self, gl: moderngl.Context, size: tuple[int, int]
    ) -> tuple[moderngl.Texture, ...]:
        """Return textures for light to be drawn into."""
        return tuple(make_texture(gl, size, 4, "f4") for _ in range(self.light_count))

    def ready(self, context: PassContext, name: str, *further: str) -> Program:
        """Return the program ``passes/<name>.frag``, with the uniforms that all share set.

        `further` names the defines of its own.
        """
        side = self.settings.rays_per_side
        openings, aims = opening_uniforms(context)
        own = {"SURFEL_RAYS_PER_SIDE": side, "OPENINGS": openings}
        defines = ray_defines(context, self.features)
        defines |= environment_defines(self.environment)
        defines["SURFEL_DEPTH"] = context.facts["surfel_points"].depth
        defines |= {key: own[key] for key in further}
        program = context.shaders.fullscreen(f"passes/{name}.frag", defines)
        program.set(
            {
                **ray_uniforms(context),
                **environment_uniforms(context.frame),
                "u_surfel_rows": surfel_rows(context.facts["surfel_points"].count),
                "u_rays_per_sample": side**2 / self.settings.light_samples,
                "u_stream": stream_of(0, 0),
                "u_shared_bits": (1 << int(math.log2(side))) - 1,
                **(aims if "OPENINGS" in further else {}),
            }
        )
        return program
