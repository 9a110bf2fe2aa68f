"""What the camera sees first: linear depth, normals, albedo, emission, gloss."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import partial
from typing import Any, ClassVar

import moderngl

from ssdo_gl.gpu.clear import clear, clear_last_in, last_kept
from ssdo_gl.gpu.geometry import (
    Features,
    TriangleRasterizer,
    can_rasterize,
    draw_surfaces,
)
from ssdo_gl.gpu.program import Program
from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec

# The images that show it: resource and channels. Positions and normals are finished on the
# host, in float64, from what they start with.
GBUFFER_IMAGES: Mapping[str, tuple[str, int]] = {
    "albedo": ("albedo", 3),
    "normal_ws": ("normals_vs", 4),
    "position_ws": ("z_vs", 1),
    "depth": ("z_vs", 1),
}


def uniforms(frame: Frame) -> dict[str, object]:
    """Return the uniforms of ``passes/gbuffer.frag``."""
    depth = frame.view.depth_uniforms()
    return {**frame.view.uniforms(), **depth, **frame.coverage_uniforms()}


class GBufferPass(RenderPass):
    """Draws the scene once into up to seven targets.

    Surfaces are two-sided: both normals are turned towards the camera. `emission`
    leaves the front side only unless the material says otherwise; its alpha is 1
    where no light delivers it, so that it may be counted as a sender. `lift_vs` is how far
    above its triangle, along the shading normal, the smooth surface lies that the triangle
    stands for; 0 where it does not bulge, or by less than what is known of positions.
    `gloss` is the reflectance at normal incidence and the roughness, `finish` the
    reflectance at grazing incidence and the baked visibility of the environment; where
    neither is read, nor written, `albedo` is the base colour of metals, too.

    Parameters
    ----------
    wanted : collection of str, optional
        The targets that somebody reads; `z_vs` is always written.
    by_chance : bool
        Some surfaces are translucent: which of their fragments are drawn follows the seed.
    clears_emission : bool
        Outside `Frame.emitting_part` `emission` holds anything, if not.

    Attributes
    ----------
    is_computed : bool
        Whether the last frame was drawn by compute shaders, where those are faster.
    """

    name = "gbuffer"
    TARGETS: ClassVar[Mapping[str, TextureSpec]] = {
        "z_vs": TextureSpec(1, "f4"),
        "normals_vs": TextureSpec(4, "nu2"),
        "albedo": TextureSpec(4, "nu2"),
        "lift_vs": TextureSpec(1, "f4"),
        "gloss": TextureSpec(4, "nu2"),
        "finish": TextureSpec(2, "nu2"),
        # The last, so that draws can leave it out.
        "emission": TextureSpec(4, "f4"),
    }
    needs_depth: ClassVar[bool] = True
    # It clears what it does not.
    overwrites: ClassVar[bool] = True

    def __init__(
        self,
        wanted: Collection[str] = tuple(TARGETS),
        *,
        by_chance: bool = False,
        clears_emission: bool = True,
    ) -> None:
        self.by_chance = by_chance
        self._clears_emission = clears_emission or "emission" not in wanted
        self.is_computed = False
        self._rasterizer: TriangleRasterizer | None = None
        self.depends_on = ("view", "geometry", "materials", *(("seed",) if by_chance else ()))
        self.writes = {
            name: spec for name, spec in self.TARGETS.items() if name == "z_vs" or name in wanted
        }
        written = list(self.writes)
        self._defines = {
            f"{name.removesuffix('_vs').upper()}_LOCATION": (
                written.index(name) if name in written else 0
            )
            for name in self.TARGETS
            if name != "z_vs"
        }

    def execute(self, context: PassContext) -> None:
        view, target = context.frame.view, context.target
        assert target is not None
        self.is_computed = context.shaders.computes and self._compute(context)
        if self.is_computed:
            return

        shared, program_of = uniforms(context.frame), partial(self._rasterizing, context)

        def draw(emitting: bool | None = None) -> None:
            context.geometry.draw(
                view,
                view.clip_from_view,
                program_of,
                shared,
                hide_backs=True,
                emitting=emitting,
            )

        if self._clears_emission or context.shaders.computes:
            clear(context.gl, context.shaders, target)
        else:
            clear_last_in(target, context.frame.emitting_part)
        context.gl.enable_only(moderngl.DEPTH_TEST)
        if "emission" not in self.writes:
            draw()
            return
        # What emits comes last: the others leave the widest target as it was cleared.
        with last_kept(context.gl.fbo):
            draw(emitting=False)
        draw(emitting=True)

    def _rasterizing(self, context: PassContext, features: Features) -> Program:
        depth = context.frame.view.depth_defines()
        defines = {**features.defines, **self._defines, **depth}
        if not features.emits:
            defines["EMISSION_LOCATION"] = 0
        return context.shaders.program("passes/gbuffer.vert", "passes/gbuffer.frag", defines)

    def _compute(self, context: PassContext) -> bool:
        """Draw by compute shaders; return whether they can, and the driver links them."""
        view = context.frame.view
        parts = context.geometry.visible_triangles(view, view.clip_from_view)
        if not can_rasterize(parts):
            return False
        programs = [self._shading(context, part.features) for part in parts]
        if not all(program.compute for program in programs):
            return False
        assert context.target is not None
        outputs: Any = context.target.color_attachments
        if self._rasterizer is None or self._rasterizer.size != view.size:
            self._rasterizer = TriangleRasterizer(context.gl, view.size, ids=True)
        self._rasterizer.draw(context.shaders, parts, view.raster_uniforms())
        ids, shared = self._rasterizer.ids, uniforms(context.frame)
        draw_surfaces(context.gl, ids, parts, programs, outputs, shared)
        return True

    def _shading(self, context: PassContext, features: Features) -> Program:
        # Holes and depth were the rasterizer's.
        settled = {"HAS_ALPHA_CUTOUT": 0, "WIDE_DEPTH_RANGE": 0}
        defines = {**features.defines, **self._defines, **settled}
        return context.shaders.visible_surface(
            "passes/gbuffer.vert", "passes/gbuffer.frag", defines
        )
