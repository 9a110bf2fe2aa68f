"""Shadow maps: depth as each light sees it, all of them in one atlas."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

import moderngl
import numpy as np

from ssdo_gl import math3d
from ssdo_gl.effects.decisions import Decision
from ssdo_gl.effects.effect import Effect, ReasonedPass
from ssdo_gl.effects.request import Request
from ssdo_gl.effects.shadows.map_readers import unread_maps
from ssdo_gl.effects.shadows.shadow_settings import ShadowMapSettings, tile_size
from ssdo_gl.gpu.geometry import CameraPose, Features
from ssdo_gl.gpu.program import Program
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.graph.depth_range import depth_uniforms, far_plane, wide_depth_range
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.light_bodies import parts_of_bodies
from ssdo_gl.scene.lights import Light
from ssdo_gl.scene.shadow_frames import (
    FACE_FROM_LIGHT,
    ShadowFrame,
    atlas_layout,
    shadow_frames,
)

# Texels around each face that show what lies beyond its edge, so that filtering there
# needs no neighbour. A 2 x 2 footprint reaches one texel out, jitter half of one more.
BORDER_TEXELS = 2
# Nearer to the plane of a light that shares its body with others than this part of its
# extent, nothing blocks it: the panels of a box meet there, off by 1e-4 in some files.
CLEARANCE = 1e-3
CLIP_DISTANCE_0 = 0x3000  # GL_CLIP_DISTANCE0
# Nothing blocks: farther than any receiver, yet finite.
EMPTY_DEPTH = 3.0e38
# Geometry looks along -z, a face along its third axis.
VIEW_FROM_FACE = np.diag([1.0, 1.0, -1.0])


def border_scale(size: int) -> float:
    """Return by how much a tile of `size` texels is wider than its face."""
    return size / (size - 2 * BORDER_TEXELS)


@dataclass(frozen=True)
class OwnBody:
    """What a light's map leaves out of the light's own body.

    Attributes
    ----------
    skip_light : int or None
        The light whose body is left out.
    sides : int
        Else on how many sides of the light's plane, 1 or 2, all that stands off it by
        `clearance` (scene units) is kept; 0: everything.
    """

    skip_light: int | None
    sides: int = 0
    clearance: float = 0.0

    @classmethod
    def of(cls, light: Light) -> OwnBody:
        """Return it of a light that shares its body with others."""
        outline = light.outline()
        assert outline is not None, "parallel light has no body"
        sides = 2 if light.shader_row().two_sided else 1
        return cls(None, sides, CLEARANCE * float(np.ptp(outline, axis=0).max()))


class ShadowMapPass(RenderPass):
    """Draws `shadow_atlas`: squares of one or more tiles for each face of each light's map.

    The parts of a rectangle share a tile in equal squares. A texel holds the linear depth
    along the axis of its face, `EMPTY_DEPTH` where there is nothing. A light that has a body
    of its own does not see it; one that shares its body with others sees only what of it, and
    of all else, stands off its plane: whatever touches the plane would block it or not by
    rounding. Lights whose maps are `unread` have none.
    """

    name = "shadow_map"
    writes: Mapping[str, TextureSpec] = {"shadow_atlas": TextureSpec(1, "f4", own=True)}
    # A window draws with other maps in motion than at rest; to make them takes as long as all
    # else of a small frame, and whoever presses a key waits for it.
    keeps_two = True

    def __init__(
        self,
        settings: ShadowMapSettings | None = None,
        *,
        by_chance: bool = False,
        unread: frozenset[int] = frozenset(),
    ) -> None:
        self.settings = settings or ShadowMapSettings()
        self._unread = unread
        self.depends_on = ("geometry", "lights", *(("seed",) if by_chance else ()))

    def settings_key(self) -> Hashable:
        return self.settings, self._unread

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        lights = context.frame.scene.lights
        parts_per_side = self.settings.parts_per_side
        layout = atlas_layout(lights, self._unread)
        size = tile_size(self.settings, layout)
        atlas = make_texture(context.gl, (layout.columns * size, layout.rows * size), 1, "f4")
        target = make_framebuffer(context.gl, [atlas], depth=True)
        before = context.gl.fbo
        target.use()
        target.clear(EMPTY_DEPTH, depth=1.0)
        context.gl.enable_only(moderngl.DEPTH_TEST)
        bounds_of = context.geometry.bounds_along
        frames = shadow_frames(lights, bounds_of, parts_per_side, self._unread)
        parts = parts_of_bodies(context.frame.scene)
        for index, frame in enumerate(frames):
            if frame is None:
                continue
            own = OwnBody.of(lights[index]) if index in parts else OwnBody(index)
            part_size = size * frame.span // frame.parts_per_side
            for face, part in np.ndindex(frame.face_count, len(frame.parts)):
                y, x = divmod(part, frame.parts_per_side)
                corner = (
                    (frame.tile[0] + face * frame.span) * size + x * part_size,
                    frame.tile[1] * size + y * part_size,
                )
                # Rasterization is clipped to the viewport, so tiles stay apart.
                target.viewport = (*corner, part_size, part_size)
                origin = frame.origin_ws + frame.parts[part]
                _draw_face(context, frame, origin, face, own, border_scale(part_size))
        # A framebuffer that is released while bound makes the next one an OpenGL error.
        if before is not None:
            before.use()
        if target.depth_attachment is not None:
            target.depth_attachment.release()
        target.release()
        return {"shadow_atlas": atlas}


def _draw_face(
    context: PassContext,
    frame: ShadowFrame,
    origin_ws: FloatArray,
    face: int,
    own: OwnBody,
    scale: float,
) -> None:
    rotation = VIEW_FROM_FACE @ FACE_FROM_LIGHT[face] @ frame.light_from_world
    eye = CameraPose(origin_ws, rotation)
    half_size = (frame.half_size[0] * scale, frame.half_size[1] * scale)
    if frame.is_parallel:
        clip_from_view = math3d.orthographic(half_size, 0.0, frame.depth)
        near, far = 1.0, 2.0
    else:
        near, far = context.geometry.near_far(eye, half_size, skip_light=own.skip_light)
        clip_from_view = math3d.perspective(half_size, near, far_plane(far))

    def program_of(features: Features) -> Program:
        defines = features.cutout_defines()
        defines["IS_PARALLEL"] = int(frame.is_parallel)
        defines["EMITTING_SIDES"] = own.sides
        defines["WIDE_DEPTH_RANGE"] = wide_depth_range(near, far)
        return context.shaders.program(
            "effects/shadow_map.vert", "effects/shadow_map.frag", defines
        )

    by_chance = context.frame.coverage_uniforms()
    uniforms: dict[str, object] = {**depth_uniforms(near, far), **by_chance}
    if own.sides:
        normal_vs = rotation @ frame.light_from_world[2]
        uniforms = {**uniforms, "u_light_plane": (*normal_vs, own.clearance)}
        context.gl.enable_direct(CLIP_DISTANCE_0)
    context.geometry.draw(
        eye,
        clip_from_view,
        program_of,
        uniforms,
        hide_backs=True,
        skip_light=own.skip_light,
    )
    context.gl.disable_direct(CLIP_DISTANCE_0)


class ShadowMaps(Effect):
    """The maps that direct light reads."""

    name = "shadow_map"
    after = ("shadow_edges",)
    settings: ClassVar[Mapping[str, type]] = {"shadow_map": ShadowMapSettings}

    def is_asked(self, request: Request) -> bool:
        """Return whether direct light runs and takes its shadows from maps."""
        return request.runs("direct") and request.settings.chosen_shadows == "map"

    def need(self, request: Request) -> Decision:
        """Run where a light that matters casts its shadow by a map that is read."""
        has_maps, unread = request.has_light("map"), unread_maps(request)
        lights = enumerate(request.content.lights)
        is_read = any(i not in unread for i, light in lights if light.shadow == "map")
        decision = request.decision(
            "shadow maps",
            "lights cast shadows",
            [
                (not has_maps, "no light that matters is marked shadow = map"),
                (not is_read, "rays find all penumbrae, and nothing in view is glossy"),
            ],
            ("shadow_map",),
        )
        # There is no map to be made even where nothing is skipped.
        return decision if has_maps else dataclasses.replace(decision, run=False)

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield the one pass."""
        settings = request.settings_of("shadow_map", ShadowMapSettings)
        # A light without a map leaves the others theirs, no finer and no coarser.
        size = tile_size(settings, atlas_layout(request.scene.lights))
        settings = dataclasses.replace(settings, resolution=size)
        item = ShadowMapPass(
            settings, by_chance=request.content.has_translucency, unread=unread_maps(request)
        )
        yield item, "lights cast shadows"
