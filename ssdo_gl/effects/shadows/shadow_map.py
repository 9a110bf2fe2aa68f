"""Shadow maps: depth as each light sees it, all of them in one atlas."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, ClassVar

import moderngl

from ssdo_gl.effects.effect import Effect, ReasonedPass
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.effects.shadows.map_faces import Face, atlas_size, faces_of
from ssdo_gl.effects.shadows.shadow_settings import ShadowMapSettings, tile_size, unread_maps
from ssdo_gl.gpu.texture import bound, drawing_into, make_framebuffer, make_texture
from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.last_made import LastMade
from ssdo_gl.scene.shadow_frames import atlas_layout

# Nothing blocks: farther than any receiver, yet finite.
EMPTY_DEPTH = 3.0e38
# What is whole alone, where something is translucent.
WHOLE_ATLAS = "whole_shadow_atlas"
SPEC = TextureSpec(1, "f4", own=True)


class ShadowMapPass(RenderPass):
    """Draws `shadow_atlas`: squares of one or more tiles for each face of each light's map.

    The parts of a rectangle share a tile in equal squares. A texel holds the linear depth
    along the axis of its face, `EMPTY_DEPTH` where there is nothing. A light that has a body
    of its own does not see it; one that shares its body with others sees only what of it, and
    of all else, stands off its plane: whatever touches the plane would block it or not by
    rounding. Lights whose maps are `unread` have none. With `whole_alone` it draws
    `whole_shadow_atlas`, without what is translucent.
    """

    name = "shadow_map"
    draws_over = True
    depends_on = ("geometry", "lights")

    def __init__(
        self,
        settings: ShadowMapSettings | None = None,
        *,
        whole_alone: bool = False,
        unread: frozenset[int] = frozenset(),
    ) -> None:
        self.settings = settings or ShadowMapSettings()
        self._unread = unread
        self._by_chance = False if whole_alone else None
        self.writes: Mapping[str, TextureSpec] = {
            WHOLE_ATLAS if whole_alone else "shadow_atlas": SPEC
        }

    def execute(self, context: PassContext) -> Produced:
        gl, name = context.gl, next(iter(self.writes))
        size = atlas_size(context.frame.scene.lights, self.settings, self._unread)
        last = context.last.get(name)
        if last is None or last.texture.size != size:
            atlas = make_texture(gl, size, 1, "f4")
            with drawing_into(gl, atlas, depth=True) as target:
                self._draw(context, target)
            return {name: atlas}
        # What moves has another map in each frame. Memory for it and for its depths, which drivers
        # clear, takes 75 ms of a frame's 790 (carousel: 25 million texels).
        atlas = last.texture
        is_new = not isinstance(last.facts, moderngl.Framebuffer)
        kept: Any = make_framebuffer(gl, [atlas], depth=True) if is_new else last.facts
        atlas.extra = None  # what was made of it (`quads_of`)
        with bound(gl, kept):
            self._draw(context, kept)
        return {name: TextureWithFacts(atlas, kept)}

    def _draw(self, context: PassContext, target: moderngl.Framebuffer) -> None:
        target.clear(EMPTY_DEPTH, depth=1.0)
        context.gl.enable_only(moderngl.DEPTH_TEST)
        for face in faces_of(context, self.settings, self._unread):
            face.draw(context, by_chance=self._by_chance)


class TranslucentShadowsPass(RenderPass):
    """Draws `shadow_atlas`: `whole_shadow_atlas`, and before it what is translucent, by chance.

    Other texels in each frame. Of a room of 671,000 triangles with 33 lights and one translucent
    thing, a picture of 16 frames would spend 200 s to draw all of it in each.
    """

    name = "translucent_shadows"
    reads = (WHOLE_ATLAS,)
    writes: Mapping[str, TextureSpec] = {"shadow_atlas": SPEC}
    depends_on = ("geometry", "lights", "seed")

    def __init__(self, settings: ShadowMapSettings, *, unread: frozenset[int]) -> None:
        self.settings = settings
        self._unread = unread
        self._faces: LastMade[list[Face]] = LastMade()

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        whole = context.inputs[WHOLE_ATLAS]
        atlas = make_texture(context.gl, whole.size, 1, "f4")
        made_from = context.frame.scene.lights, context.geometry.instances
        faces = self._faces.get(made_from, lambda: list(self._found(context)))
        with drawing_into(context.gl, whole) as source, drawing_into(context.gl, atlas) as target:
            context.gl.copy_framebuffer(target, source)
            # The nearer one, as by a depth test.
            context.gl.enable_only(moderngl.BLEND)
            context.gl.blend_equation = moderngl.MIN, moderngl.MIN
            for face in faces:
                face.draw(context, by_chance=True)
            context.gl.blend_equation = moderngl.FUNC_ADD, moderngl.FUNC_ADD
            context.gl.enable_only(moderngl.NOTHING)
        return {"shadow_atlas": atlas}

    def _found(self, context: PassContext) -> Iterable[Face]:
        faces = faces_of(context, self.settings, self._unread)
        return (face for face in faces if face.sees_translucent(context))


class ShadowMaps(Effect):
    """The maps that direct light reads."""

    name = "shadow_map"
    after = ("shadow_edges",)
    settings: ClassVar[Mapping[str, type]] = {"shadow_map": ShadowMapSettings}

    def is_asked(self, request: Request) -> bool:
        """Return whether direct light runs and takes its shadows from maps."""
        return request.runs("direct") and request.settings.chosen_shadows == "map"

    def need(self, request: Request) -> Decision:
        """Run where a light that matters casts its shadow by a map that is read.

        Elsewhere there is no map to be made, even where nothing is skipped.
        """
        unread = unread_maps(request)
        lights = enumerate(request.content.lights)
        reason = None
        if not request.has_light("map"):
            reason = "no light that matters is marked shadow = map"
        elif all(i in unread for i, light in lights if light.shadow == "map"):
            reason = "rays find all penumbrae"
        passes = "shadow_map", "translucent_shadows"
        return Decision("shadow maps", reason is None, reason or "lights cast shadows", passes)

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield the one pass."""
        settings = request.settings_of("shadow_map", ShadowMapSettings)
        # A light without a map leaves the others theirs, no finer and no coarser.
        size = tile_size(settings, atlas_layout(request.scene.lights))
        settings = dataclasses.replace(settings, resolution=size)
        unread, by_chance = unread_maps(request), request.content.has_translucency
        item = ShadowMapPass(settings, whole_alone=by_chance, unread=unread)
        yield item, "lights cast shadows"
        if by_chance:
            yield (
                TranslucentShadowsPass(settings, unread=unread),
                "translucent surfaces let light by",
            )
