"""Direct light of glowing bodies that no light of the scene stands for exactly."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

from ssdo_gl.effects.effect import Effect, ReasonedPass, Term
from ssdo_gl.effects.request import Decision, Request, overridden
from ssdo_gl.effects.scene_lights import has_glow, takes_stand_ins
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.draw_inputs import draw_inputs
from ssdo_gl.passes.edge_aware_filter import (
    FILTER,
    EdgeAwareFilterPass,
    EdgeAwareFilterSettings,
    Levels,
    Signal,
)
from ssdo_gl.passes.rays import (
    EMITTER_TABLES,
    GLOW_PLACES,
    GLOW_TREE,
    GlowTreePass,
    ray_defines,
    ray_reads,
    ray_uniforms,
    stream_of,
    tree_of,
    tree_uniforms,
)
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.light_bodies import has_crowd_of_panels
from ssdo_gl.settings.fields import setting

SURFACES = ("z_vs", "normals_vs")
# In pixels on the surface, times the root of the frames of a picture: half of what comes from so
# near a body is not filtered. docs/far-field-lights.md has other numbers.
NEAR_REACH = 0.5
# Of light, in its variance, which rays drawn apart have; others: docs/far-field-lights.md.
NOISE_TOLERANCE = 3.0


@dataclass(frozen=True)
class EmittersSettings:
    """How many rays look for the light of glowing bodies."""

    rays: int = setting(
        8,
        "shadow rays of each pixel and frame to points of glowing bodies, of all of them together; "
        "twice as many where these are more than 32 panels and not summed",
        unit="rays",
        low=1,
        high=64,
    )
    summed_panels: int = setting(
        128,
        "where no more than so many panels glow, and nothing else, rays tell but how much of their "
        "light is blocked",
        low=0,
        high=4096,
    )


class EmittersPass(RenderPass):
    """Writes `emitters_raw` and `emitters_near`: rgb irradiance of all bodies of the tree; a 1.

    The former is a share of `emitters_whole`, which is 1 where it is not known what bodies send
    if nothing blocks it. `emitters_light` is what it holds of all colours together, and its
    variance.
    """

    name = "emitters"
    writes: Mapping[str, TextureSpec] = {
        "emitters_raw": TextureSpec(4, "f4", transient=True),
        "emitters_near": TextureSpec(4, "f4"),
        "emitters_light": TextureSpec(2, "f4", transient=True),
        "emitters_whole": TextureSpec(4, "f4", transient=True),
    }
    overwrites: ClassVar[bool] = True
    depends_on = ("view", "geometry", "lights", "seed")

    def __init__(
        self, settings: EmittersSettings, features: RayFeatures, *, is_crowd: bool
    ) -> None:
        self.settings = settings
        self.features = features
        # Of panels that are exact lights where there are fewer.
        self.is_crowd = is_crowd
        tables = (*EMITTER_TABLES, *GLOW_TREE, GLOW_PLACES)
        self.reads = (*SURFACES, *ray_reads(features, shades=True), *tables)

    def execute(self, context: PassContext) -> None:
        """Trace the rays of all pixels."""
        frame = context.frame
        number = frame.seed - frame.first_seed
        picture = frame.first_seed + number // frame.count + (frame.moves << 32)
        uniforms = {
            **ray_uniforms(context),
            "u_stream": stream_of(picture, 0),
            "u_frame_number": (number % frame.count, frame.count),
            **tree_uniforms(context),
        }
        sums = 0 < tree_of(context).panel_count <= self.settings.summed_panels
        uniforms["u_ray_count"] = self.settings.rays * (2 if self.is_crowd and not sums else 1)
        if not sums:
            # Where frames are averaged there is less noise to filter.
            uniforms["u_near_reach"] = NEAR_REACH * frame.count**0.5
        bends = self.features.smooth_normals or self.features.normal_maps
        defines = {
            "ENVIRONMENT_KIND": 0,
            "SUMS_PANELS": int(sums),
            "HAS_SHADING_NORMALS": int(bends),
        }
        program = context.shaders.fullscreen(
            "effects/emitters.frag", {**ray_defines(context, self.features), **defines}
        )
        draw_inputs(context, program, uniforms, self.reads)


class Emitters(Effect):
    """Light of glowing bodies that are no exact lights of the scene, by shadow rays."""

    name = "emitters"
    after = ("traced_shadows",)
    methods = frozenset({"gi"})
    terms = (Term("direct", "emitters_irradiance"), Term("direct", "emitters_near"))
    settings: ClassVar[Mapping[str, type]] = {
        "emitters": EmittersSettings,
        "emitters_filter": EdgeAwareFilterSettings,
    }
    traces = True

    def need(self, request: Request) -> Decision:
        """Run where bodies glow that no light of the scene is exactly."""
        return request.decision(
            "light of glowing bodies",
            "bodies glow that no light of the scene is exactly",
            [
                (request.is_view_empty, "no surface is in view"),
                (
                    not has_glow(request),
                    "lights of the scene stand for all that glows",
                ),
            ],
            ("glow_tree", "emitters", "emitters_filter"),
        )

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield the rays and their filter."""
        yield GlowTreePass(stand_ins=takes_stand_ins(request)), "finds those that matter to a point"
        features = replace(request.ray_features, glow_is_direct=True)
        settings = request.settings_of("emitters", EmittersSettings)
        item = EmittersPass(settings, features, is_crowd=has_crowd_of_panels(request.scene))
        yield item, "light of glowing bodies, by shadow rays"
        of_all = request.settings_of(FILTER, EdgeAwareFilterSettings)
        yield (
            EdgeAwareFilterPass(
                "emitters_filter",
                overridden(request.settings, "emitters_filter", of_all),
                Signal("emitters_raw", "emitters_irradiance"),
                levels=Levels("emitters_light", NOISE_TOLERANCE),
                factor="emitters_whole",
            ),
            "removes the sampling noise along surfaces",
        )
