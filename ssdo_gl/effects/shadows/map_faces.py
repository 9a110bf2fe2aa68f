"""The faces of all shadow maps: where in the atlas each lies, what it sees, and how it is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.effects.shadows.shadow_settings import ShadowMapSettings, tile_size
from ssdo_gl.gpu.geometry import CameraPose, Features
from ssdo_gl.gpu.program import Program
from ssdo_gl.graph.frame import depth_uniforms, far_plane, wide_depth_range
from ssdo_gl.graph.render_pass import PassContext
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


class Face(NamedTuple):
    """One face of one light's map, seen from one part of the light.

    Attributes
    ----------
    viewport : (int, int, int, int)
        Where in the atlas: column, row, width and height in texels.
    clip_from_view : ndarray, shape (4, 4)
    depths : (float, float)
        Clip distances, near and far.
    normal_ws : ndarray, shape (3,)
        Of the light's plane, if it has one.
    """

    viewport: tuple[int, int, int, int]
    eye: CameraPose
    clip_from_view: FloatArray
    depths: tuple[float, float]
    is_parallel: bool
    own: OwnBody
    normal_ws: FloatArray

    def draw(self, context: PassContext, *, by_chance: bool | None) -> None:
        """Draw into the bound framebuffer all that it sees, or what is translucent or not."""
        near, far = self.depths

        def program_of(features: Features) -> Program:
            defines = features.cutout_defines()
            defines["IS_PARALLEL"] = int(self.is_parallel)
            defines["EMITTING_SIDES"] = self.own.sides
            defines["WIDE_DEPTH_RANGE"] = wide_depth_range(near, far)
            return context.shaders.program(
                "effects/shadow_map.vert", "effects/shadow_map.frag", defines
            )

        uniforms: dict[str, object] = {
            **depth_uniforms(near, far),
            **context.frame.coverage_uniforms(),
        }
        if self.own.sides:
            normal_vs = self.eye.view_from_world @ self.normal_ws
            uniforms = {**uniforms, "u_light_plane": (*normal_vs, self.own.clearance)}
            context.gl.enable_direct(CLIP_DISTANCE_0)
        # Rasterization is clipped to the viewport, so tiles stay apart.
        context.gl.fbo.viewport = self.viewport
        context.geometry.draw(
            self.eye,
            self.clip_from_view,
            program_of,
            uniforms,
            hide_backs=True,
            by_chance=by_chance,
            skip_light=self.own.skip_light,
        )
        context.gl.disable_direct(CLIP_DISTANCE_0)

    def sees_translucent(self, context: PassContext) -> bool:
        """Return whether anything that it sees may be translucent."""
        return context.geometry.shows_by_chance(self.eye, self.clip_from_view, self.own.skip_light)


def atlas_size(
    lights: Sequence[Light], settings: ShadowMapSettings, unread: frozenset[int]
) -> tuple[int, int]:
    """Return columns and rows of the atlas, texels."""
    layout = atlas_layout(lights, unread)
    size = tile_size(settings, layout)
    return layout.columns * size, layout.rows * size


def faces_of(
    context: PassContext, settings: ShadowMapSettings, unread: frozenset[int]
) -> list[Face]:
    """Return the faces of all maps but those of lights that are `unread`."""
    scene = context.frame.scene
    lights, size = scene.lights, tile_size(settings, atlas_layout(scene.lights, unread))
    bounds_of = context.geometry.bounds_along
    frames = shadow_frames(lights, bounds_of, settings.parts_per_side, unread)
    parts = parts_of_bodies(scene)
    found = []
    for index, frame in enumerate(frames):
        if frame is None:
            continue
        own = OwnBody.of(lights[index]) if index in parts else OwnBody(index)
        part_size = size * frame.span // frame.parts_per_side
        for face, part in np.ndindex(frame.face_count, len(frame.parts)):
            y, x = divmod(part, frame.parts_per_side)
            viewport = (
                (frame.tile[0] + face * frame.span) * size + x * part_size,
                frame.tile[1] * size + y * part_size,
                part_size,
                part_size,
            )
            origin = frame.origin_ws + frame.parts[part]
            found.append(_face(context, frame, origin, face, own, viewport))
    return found


def _face(
    context: PassContext,
    frame: ShadowFrame,
    origin_ws: FloatArray,
    face: int,
    own: OwnBody,
    viewport: tuple[int, int, int, int],
) -> Face:
    rotation = VIEW_FROM_FACE @ FACE_FROM_LIGHT[face] @ frame.light_from_world
    eye, scale = CameraPose(origin_ws, rotation), border_scale(viewport[2])
    half_size = (frame.half_size[0] * scale, frame.half_size[1] * scale)
    if frame.is_parallel:
        clip_from_view = math3d.orthographic(half_size, 0.0, frame.depth)
        depths = 1.0, 2.0
    else:
        depths = context.geometry.near_far(eye, half_size, skip_light=own.skip_light)
        clip_from_view = math3d.perspective(half_size, depths[0], far_plane(depths[1]))
    normal_ws = frame.light_from_world[2]
    return Face(viewport, eye, clip_from_view, depths, frame.is_parallel, own, normal_ws)
