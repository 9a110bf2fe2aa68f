"""Light that arrives straight from the scene's lights."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, ClassVar

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.effects.effect import Effect, ReasonedPass, Term
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.effects.scene_lights import USELESS_LIGHTS, lights_of_glow, need_of_direct_light
from ssdo_gl.effects.shadows import ShadowMapSettings, unread_maps
from ssdo_gl.gpu.clear import clear
from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.last_made import LastMade
from ssdo_gl.math3d import FloatArray
from ssdo_gl.passes.brdf_wiring import brdf_wiring, gloss_draws
from ssdo_gl.passes.light_draws import FILTERED, Edge, LightDraw, draw_light, draw_tiles
from ssdo_gl.passes.light_rows import light_rows
from ssdo_gl.passes.light_tiles import MapsInQuads, light_tiles
from ssdo_gl.passes.quads import quads_of
from ssdo_gl.passes.rays import bvh_of, ray_defines, ray_reads, ray_uniforms
from ssdo_gl.passes.screen_space_settings import pattern_offset
from ssdo_gl.raytracing.slats import lamps_behind, slats_of
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.lights import Form, Light, RectangleLight, kind_number
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.shadow_frames import ShadowFrame, atlas_layout, shadow_frames
from ssdo_gl.settings.fields import setting
from ssdo_gl.settings.methods import ALL, REFERENCES


@dataclass(frozen=True)
class DirectSettings:
    """How soft shadows are sampled, and highlights of small lights filtered."""

    blocker_samples: int = setting(
        2,
        "shadow-map reads per part of a light that look for what stands before it",
        low=1,
        high=256,
    )
    filter_samples: int = setting(
        8, "shadow-map reads per part of a light in its penumbra: smoother", low=1, high=256
    )
    penumbra_rays: int = setting(
        16,
        "rays of gi from every pixel to a light with a size, where one walk through the hierarchy "
        "does not tell how much of it is hidden; 1.75 times as many in motion",
        unit="rays",
        low=4,
        high=256,
    )
    gloss_footprint: float = setting(
        1.0,
        "how much of the way to its neighbours a pixel reaches, over which highlights of lights "
        "without an area are averaged; 0: what is at its centre",
        unit="px",
        low=0.0,
        high=1.0,
    )


# Shadow maps of all lights, columns of their atlas, and the switches of those that shine.
_ShadowPlaces = tuple[list[ShadowFrame | None], int, dict[int, dict[str, int]]]


def is_smooth(scene: Scene) -> bool:
    """Return whether any surface is shaded by normals that are not its triangles' own."""
    has_maps = any(material.normal_texture is not None for material in scene.materials)
    return has_maps or any(mesh.normals is not None for mesh in scene.meshes)


# Pixels of a block, each of which has a set of points of its own, and frames in which its
# quarters exchange them: they share the points that are set off by a seed.
BLOCK_SETS, TURNS = 16, 4
# Lines over a light, fewer in each of several frames of a picture, and points on each.
LINES, LINES_OF_SEVERAL, LINE_POINTS = 8, 4, 32
LEAST_SEVERAL = 4
# How many times the rays of a frame at rest, which is one of several, a frame in motion sends where
# a walk through the hierarchy does not tell. Twice as many stand in step with the points of lines:
# the temporal error of direct light is .0015 for .0006 (cornell_meso).
RAYS_IN_MOTION = 1.5
# Records of a walk before rays take over, for each column of lines: strips have more before them.
# And those behind slats, where so few rays alias, and towards suns: a forest takes .87 of the time.
STEPS, MOST_STEPS = 24, 256


def _turned(i: int, bits: int) -> int:
    return int(f"{i:0{bits}b}"[::-1], 2)


@cache
def lines_over_a_light(
    number: int, count: int, *, columns: int = 1, is_mirrored: bool = False, is_round: bool = False
) -> Mapping[str, Any]:
    """Return the points of a light that frame `number` of `count` asks for, as uniforms.

    Lines stand in `columns` along its longer edge. Each crosses its strip of the light, or in
    several frames the part of it that is the frame's, so that edges along the lines pass one
    point after the other, too.
    """
    size = LINES_OF_SEVERAL if count >= LEAST_SEVERAL else LINES
    rows = size // columns
    order = [_turned(i, 32) for i in range(count)]  # van der Corput's sequence
    part = sorted(order).index(order[number]) / count
    row, column = np.arange(size) % rows, np.arange(size) // rows
    shifts = (
        np.array([_turned(int(i), rows.bit_length() - 1) for i in row]) + (number + 0.5) / count
    )
    places = (np.arange(LINE_POINTS) + shifts[:, None] / rows) / LINE_POINTS
    along = (column[:, None] + places) / columns
    across = (row[:, None] + part + places / count) / rows
    x, y = 2.0 * along - 1.0, (2.0 * across - 1.0) * (-1.0 if is_mirrored else 1.0)
    bits = np.ones(LINE_POINTS, np.uint32) << np.arange(LINE_POINTS, dtype=np.uint32)
    is_there = x * x + y * y <= 1.0 if is_round else np.full(x.shape, True)

    def in_groups(values: Any) -> FloatArray:
        return math3d.read_only(values.reshape(-1, 4))

    return {
        "u_shaft_x": in_groups(x[:, 0]),
        "u_shaft_y": in_groups(y[:, 0]),
        "u_shaft_step": (float(x[0, 1] - x[0, 0]), float(y[0, 1] - y[0, 0])),
        "u_shaft_points": in_groups((is_there * bits).sum(axis=1, dtype=np.uint32)),
    }


def columns_of(light: Light) -> int:
    """Return in how many columns lines stand along a light's longer edge."""
    if not isinstance(light, RectangleLight):
        return 1
    edges = sorted(np.linalg.norm([light.edge_u, light.edge_v], axis=1))
    aspect = edges[1] / max(edges[0], 1e-30)
    # One of exactly 4 has one, however that is rounded.
    return 4 if aspect > 16.1 else 2 if aspect > 4.1 else 1


def uniforms(frame: Frame) -> dict[str, object]:
    """Return the uniforms of ``effects/direct.frag`` that all lights share."""
    number = frame.seed - frame.first_seed
    return {
        **frame.view.uniforms(),
        "u_pattern_offset": pattern_offset(frame.first_seed + number // TURNS),
        "u_pattern_turn": number % BLOCK_SETS,
    }


class DirectPass(RenderPass):
    """Writes `direct_irradiance`: rgb irradiance; background 0.

    Points, spots and directional lights are exact; rectangles by Lambert's polygon
    formula, in glossy layers by 36 points or 84. Linear in the light; exactly 0 where none arrives.

    Parameters
    ----------
    shadow_maps : bool
        Read `shadow_atlas` for lights whose shadow is "map"; without it and rays they cast none.
    unread : frozenset of int
        Lights that are not in it.
    elsewhere : frozenset of int
        Lights that another pass brings.
    parts_per_side : int
        That of the shadow maps' settings.
    lifts : bool
        Read `lift_vs`, without which triangles shadow the smooth surface they stand for.
    glossy : bool
        Write `direct_gloss`, too: rgb radiance that glossy surfaces reflect to the camera.
    rays : RayFeatures or None
        What rays meet that tell where shadows end; None: the map does.
    whole_map : bool
        Read `whole_shadow_atlas`, too: where it tells no end of a shadow, no ray is asked.
    """

    name = "direct"
    overwrites: ClassVar[bool] = True

    def __init__(
        self,
        settings: DirectSettings | None = None,
        *,
        shadow_maps: bool = True,
        unread: frozenset[int] = frozenset(),
        elsewhere: frozenset[int] = frozenset(),
        parts_per_side: int = 1,
        lifts: bool = False,
        glossy: bool = False,
        rays: RayFeatures | None = None,
        whole_map: bool = False,
    ) -> None:
        self.settings = settings or DirectSettings()
        self.shadow_maps = shadow_maps
        self._unread = unread
        self._elsewhere = elsewhere
        self.parts_per_side = parts_per_side
        self.lifts = lifts
        self.glossy = glossy
        self._rays = rays
        self._placed: LastMade[_ShadowPlaces] = LastMade()
        self._rows: LastMade[list[FloatArray]] = LastMade()
        self._slats: LastMade[FloatArray] = LastMade()
        self._behind: LastMade[frozenset[int]] = LastMade()
        self.writes = {"direct_irradiance": TextureSpec(4, "f4")}
        if glossy:
            self.writes["direct_gloss"] = TextureSpec(4, "f4")
        more = *(("shadow_atlas",) if shadow_maps else ()), *(("lift_vs",) if lifts else ())
        tables = () if rays is None else ray_reads(rays, shades=True)
        tables = (*tables, "whole_shadow_atlas") if whole_map else tables
        self._ray_wiring = {f"t_{name}": name for name in tables}
        self._wiring = {f"t_{name}": name for name in ("z_vs", "normals_vs", *more)}
        surface = self._wiring | (brdf_wiring(glossy) if glossy else {})
        self.reads = (*surface.values(), *tables)
        # The map of a directional light encloses the geometry; the seed turns the
        # pattern of soft shadows.
        casts = shadow_maps or rays is not None
        self.depends_on = ("view", "lights", *(("geometry", "seed") if casts else ()))

    def execute(self, context: PassContext) -> None:
        """Draw one triangle over the target for each light, adding up; then over what is glossy."""
        assert context.target is not None
        scene, view = context.frame.scene, context.frame.view
        frames, columns, chosen = self._placed.get(
            (scene.lights, scene.materials, scene.meshes, context.geometry.instances),
            lambda: self._places(scene, context.geometry),
        )
        rows = self._rows.get(
            (frames, view.position_ws, view.view_from_world),
            lambda: [math3d.read_only(row) for row in light_rows(scene.lights, frames, view)],
        )
        behind = frozenset() if self._rays is None else self._behind_slats(context)
        common = uniforms(context.frame)
        inputs, maps = dict(context.inputs), None
        if self.shadow_maps:
            atlas = inputs["shadow_atlas"]
            texels = common["u_shadow_tile_texels"] = atlas.width // columns
            quads = quads_of(context.gl, context.shaders, atlas, self)
            if quads is not None:
                inputs["shadow_quads"], maps = quads, MapsInQuads(quads, frames, texels, self)
        draws = gloss_draws(context.frame, self.glossy)
        if not chosen or len(draws) > 1:
            clear(context.gl, context.shaders, context.target)
        for glossy, region in draws:
            wiring = self._wiring | (brdf_wiring(True) if glossy else {})
            if maps is not None:
                del wiring["t_shadow_atlas"]
                wiring["t_shadow_quads"] = "shadow_quads"
            textures = {sampler: inputs[name] for sampler, name in wiring.items()}
            filters = glossy and self.settings.gloss_footprint > 0.0
            footprint = {"u_gloss_footprint": self.settings.gloss_footprint} if filters else {}
            gloss = {"GLOSSY": glossy, "FILTERS_GLOSS": int(filters)}
            for i, switches in chosen.items():
                defines = {**switches, **gloss, "IN_QUADS": int(maps is not None)}
                casts = switches["CASTS_SHADOW"]
                edge = self._edge(context, scene.lights[i], i in behind) if casts else FILTERED
                drawing = LightDraw(
                    edge,
                    defines,
                    {**common, **footprint, "u_light": rows[i]},
                    textures,
                    region,
                    # The first overwrites, which is cheaper.
                    adds=i != next(iter(chosen)),
                    keeps_last=self.glossy and not glossy,
                )
                tiles = None
                if maps is not None and not glossy and drawing.is_told_by_map:
                    tiles = light_tiles(context, maps, i, drawing)
                draw_light(context, drawing) if tiles is None else draw_tiles(
                    context, drawing, tiles
                )

    def _behind_slats(self, context: PassContext) -> frozenset[int]:
        """Return which lights many slats stand close before."""
        lights, triangles = context.frame.scene.lights, bvh_of(context).triangles
        if not any(light.form == Form.AREA for light in lights):
            return frozenset()
        # In a window they stay what they were while bodies only move.
        source = context.frame.scene.meshes if context.frame.is_live else triangles
        slats = self._slats.get((source,), lambda: slats_of(triangles))
        return self._behind.get((slats, lights), lambda: lamps_behind(slats, lights))

    def _edge(self, context: PassContext, light: Light, is_behind_slats: bool) -> Edge:
        """Return how it is judged where shadows of a light end."""
        if self._rays is None:
            return FILTERED
        frame = context.frame
        tables = {sampler: context.inputs[name] for sampler, name in self._ray_wiring.items()}
        number = 0 if frame.moves else (frame.seed - frame.first_seed) % frame.count
        columns = columns_of(light)
        lines = lines_over_a_light(
            number,
            1 if frame.moves else frame.count,
            columns=columns,
            is_mirrored=frame.first_seed % 2 == 1,
            is_round=light.form == Form.PARALLEL,
        )
        groups = {"SHAFT_GROUPS": len(lines["u_shaft_x"])}
        groups["HAS_WHOLE_MAP"] = int("t_whole_shadow_atlas" in tables and not light.is_soft)
        times = RAYS_IN_MOTION if frame.moves else 1
        looks_longer = is_behind_slats or light.form == Form.PARALLEL
        uniforms = {
            **ray_uniforms(context),
            **lines,
            "u_shaft_steps": MOST_STEPS if looks_longer else STEPS * columns,
            "u_shaft_rays": int(self.settings.penumbra_rays * times),
        }
        return Edge("traced", ray_defines(context, self._rays) | groups, uniforms, tables)

    def _places(self, scene: Scene, geometry: Geometry) -> _ShadowPlaces:
        """Return what does not depend on the view."""
        lights = scene.lights
        unread = self._unread
        frames = shadow_frames(lights, geometry.bounds_along, self.parts_per_side, unread)
        smooth = is_smooth(scene)
        chosen = {
            i: self._defines(light, smooth)
            for i, light in enumerate(lights)
            if light.shadow != "ssdo" and light.power > 0 and i not in self._elsewhere
        }
        return frames, atlas_layout(lights, unread).columns, chosen

    def _defines(self, light: Light, smooth: bool) -> dict[str, int]:
        has_shadows = self.shadow_maps or self._rays is not None
        casts = has_shadows and light.shadow == "map"
        return {
            "LIGHT_KIND": kind_number(light),
            "LIGHT_FORM": light.form,
            "IS_SOFT": int(light.is_soft),
            "CASTS_SHADOW": int(casts),
            "HAS_LIFT": int(casts and self.lifts and smooth),
            "HAS_SHADING_NORMALS": int(smooth),
            "BLOCKER_COUNT": self.settings.blocker_samples,
            "FILTER_COUNT": self.settings.filter_samples,
        }


class Direct(Effect):
    """Light of the scene's lights, shadowed by maps or not at all."""

    name = "direct"
    after = ("emission",)
    methods = ALL - {"reference-gi"}
    shown_by = ALL
    terms = (
        Term("direct", "direct_irradiance"),
        Term("specular", "direct_gloss", "radiance", glossy=True),
    )
    shortcuts = (USELESS_LIGHTS,)
    settings: ClassVar[Mapping[str, type]] = {"direct": DirectSettings}

    def is_asked(self, request: Request) -> bool:
        """Return whether shadows are not traced: then another effect has this light."""
        return super().is_asked(request) and request.settings.chosen_shadows != "traced"

    def need(self, request: Request) -> Decision:
        """Run where any light can light what is in view."""
        return need_of_direct_light(request)

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield the one pass."""
        settings = request.settings_of("direct", DirectSettings)
        if request.settings.method in REFERENCES:
            # Which look at the centres of pixels.
            settings = replace(settings, gloss_footprint=0.0)
        maps = request.settings_of("shadow_map", ShadowMapSettings)
        has_shadows = request.runs("shadow_map", "shadow_edges")
        item = DirectPass(
            settings,
            shadow_maps=request.runs("shadow_map"),
            unread=unread_maps(request),
            elsewhere=lights_of_glow(request),
            parts_per_side=maps.parts_per_side,
            lifts=has_shadows and is_smooth(request.scene),
            glossy=request.is_glossy,
            rays=request.ray_features if request.runs("shadow_edges") else None,
            whole_map=request.content.has_translucency
            and request.runs("shadow_map")
            and request.runs("shadow_edges"),
        )
        yield item, "light of the scene's lights"
