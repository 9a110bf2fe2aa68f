"""Glossy reflections of surfaces in view and of the environment."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from ssdo_gl.effects.effect import Effect, ReasonedPass, Term
from ssdo_gl.effects.near_field import filtered
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.effects.scene_lights import has_glow
from ssdo_gl.effects.sender_bound import sender_bound
from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.brdf_wiring import brdf_wiring
from ssdo_gl.passes.draw_inputs import draw_inputs
from ssdo_gl.passes.edge_aware_filter import EdgeAwareFilterSettings
from ssdo_gl.passes.environment_uniforms import (
    MAP_RADIANCE,
    environment_defines,
    environment_uniforms,
)
from ssdo_gl.passes.rays import (
    EMITTER_TABLES,
    GLOW_PLACES,
    GLOW_TREE,
    ray_defines,
    ray_reads,
    ray_uniforms,
    stream_of,
    tree_of,
    tree_uniforms,
)
from ssdo_gl.passes.screen_space_settings import (
    ScreenSpaceSettings,
    estimator_uniforms,
    pattern_offset,
)
from ssdo_gl.passes.surfels import cache_tables
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.environment import EnvironmentKind, kind_of
from ssdo_gl.settings.fields import setting

# Up to this roughness a march finds what lies beyond R, and mirrors show what surfaces reflect.
SMOOTH = 0.4
# Where more panels glow, their highlights come by points and rays of the lobe, which is noisier.
MOST_SUMMED = 128


@dataclass(frozen=True)
class ReflectionsSettings:
    """Settings of glossy reflections."""

    lobe_samples: int = setting(4, "directions of the lobe per pixel", low=1, high=64)
    march_steps: int = setting(16, "depth reads along each direction", low=2, high=256)
    refine_steps: int = setting(4, "bisections that find where a direction meets", low=0, high=8)
    max_roughness: float | None = setting(
        None,
        "rougher surfaces reflect what is within R only, and are matt in mirrors; none: 0.4, and"
        " with gi, by rays, 1 but in mirrors",
        low=0.0,
        high=1.0,
    )
    mirror_bounces: int = setting(
        3, "how often light goes on from mirror to mirror, by rays", low=0, high=8
    )
    glow_rays: int = setting(
        4,
        "rays of each pixel and frame to points of glowing bodies that its lobe may reflect, of"
        " all of them together; with gi",
        unit="rays",
        low=1,
        high=64,
    )


def uniforms(
    settings: ReflectionsSettings,
    march: ScreenSpaceSettings,
    frame: Frame,
    has_back_layer: bool,
    bound: float | None,
    *,
    has_rays: bool,
) -> dict[str, Any]:
    """Return the uniforms of ``effects/reflections.frag``; no `bound` where nothing is sent."""
    given = settings.max_roughness
    smooth = SMOOTH if given is None else given
    senders = {} if bound is None else {"u_sender_bound": bound, "u_hidden_senders": 0.25}
    return {
        **estimator_uniforms(march, frame, has_back_layer),
        # What is not averaged over frames keeps its pattern while the camera moves.
        "u_pattern_offset": pattern_offset(frame.seed),
        **environment_uniforms(frame),
        **senders,
        "u_max_roughness": 1.0 if has_rays and given is None else smooth,
        **({"u_mirror_roughness": smooth} if has_rays else {}),
    }


class ReflectionsPass(RenderPass):
    """Writes `reflections_raw`: rgb mean radiance of each glossy surface's lobe, a = z; else 0.

    Parameters
    ----------
    march : ScreenSpaceSettings
        How blockers are told from the depth buffer.
    bound : float or None
        As `sender_bound` of `BouncePass`; None: what blocks a direction is black.
    has_back_layer : bool
        Read ``z_layers`` to know where solids end.
    rays : RayFeatures or None
        What rays meet that surfaces reflect; the surface cache lights it. None: smooth ones
        reflect what the picture shows, and the environment where it shows nothing.
    """

    name = "reflections"

    def __init__(
        self,
        settings: ReflectionsSettings,
        march: ScreenSpaceSettings,
        environment: EnvironmentKind,
        *,
        bound: float | None = None,
        has_back_layer: bool = False,
        rays: RayFeatures | None = None,
    ) -> None:
        self.settings, self._march, self._bound = settings, march, bound
        self._rays = rays
        tables = (
            ()
            if rays is None
            else (
                *ray_reads(rays, shades=True),
                *EMITTER_TABLES,
                *cache_tables(rays),
                *((*GLOW_TREE, GLOW_PLACES) if rays.glow_is_direct else ()),
            )
        )
        has_lobes = environment in ("gradient", "map")
        self._wiring = {
            "t_z_vs": "z_vs",
            "t_normals_vs": "normals_vs",
            **brdf_wiring(glossy=True),
            **({"t_environment_lobes": "environment_lobes"} if has_lobes else {}),
            **({"t_environment": MAP_RADIANCE} if environment == "map" else {}),
            **({"t_sender_radiance": "sender_radiance"} if bound is not None else {}),
            **({"t_z_layers": "z_layers"} if has_back_layer else {}),
            **{f"t_{name}": name for name in tables},
        }
        self.reads = tuple(self._wiring.values())
        self.writes = {"reflections_raw": TextureSpec(4, transient=True)}
        self.depends_on = ("view", "seed", "environment", *(("geometry",) if tables else ()))
        self._has_back_layer = has_back_layer
        self._defines = {
            "SAMPLE_COUNT": settings.lobe_samples,
            "STEP_COUNT": settings.march_steps,
            "REFINE_COUNT": settings.refine_steps,
            "HAS_BACK_LAYER": int(has_back_layer),
            "GATHERS_SENDERS": int(bound is not None),
            **environment_defines(environment),
        }

    def execute(self, context: PassContext) -> None:
        """Draw one triangle over what is glossy."""
        defines, beyond = self._defines, "beyond_screens/unknown.glsl"
        values = uniforms(
            self.settings,
            self._march,
            context.frame,
            self._has_back_layer,
            self._bound,
            has_rays=self._rays is not None,
        )
        if self._rays is not None:
            defines = {**defines, **ray_defines(context, self._rays)}
            # The shader is glossy by itself.
            del defines["GLOSSY"]
            defines["MIRROR_BOUNCES"] = self.settings.mirror_bounces
            values |= {**ray_uniforms(context), "u_stream": stream_of(context.frame.seed, 0)}
            defines["SUMS_PANELS"] = 0
            if self._rays.glow_is_direct:
                values |= {**tree_uniforms(context), "u_glow_rays": self.settings.glow_rays}
                count = tree_of(context).panel_count
                defines["SUMS_PANELS"] = int(0 < count <= MOST_SUMMED)
            beyond = "beyond_screens/traced.glsl"
        program = context.shaders.fullscreen(
            "effects/reflections.frag", defines, {"beyond_screen": beyond}
        )
        draw_inputs(context, program, values, self._wiring, context.frame.gloss_region)


class ReflectedRadiancePass(RenderPass):
    """Writes `reflections`: rgb radiance towards the camera, a = 0."""

    name = "reflected_radiance"
    WIRING: ClassVar[Mapping[str, str]] = {
        "t_z_vs": "z_vs",
        "t_normals_vs": "normals_vs",
        **brdf_wiring(glossy=True),
        "t_reflections_raw": "reflections_raw",
        "t_reflections_filtered": "reflections_filtered",
    }
    reads = tuple(WIRING.values())
    writes: Mapping[str, TextureSpec] = {"reflections": TextureSpec(4)}
    depends_on = ("view",)

    def execute(self, context: PassContext) -> None:
        """Draw one triangle over what is glossy."""
        program = context.shaders.fullscreen("effects/reflected_radiance.frag")
        frame = context.frame
        draw_inputs(context, program, frame.view.uniforms(), self.WIRING, frame.gloss_region)


class Reflections(Effect):
    """What glossy surfaces reflect of the environment and of each other."""

    name = "reflections"
    after = ("bounce",)
    methods = frozenset({"ssdo", "bounce", "gi"})
    terms = (Term("specular", "reflections", "radiance", glossy=True),)
    settings: ClassVar[Mapping[str, type]] = {
        "reflections": ReflectionsSettings,
        "reflections_filter": EdgeAwareFilterSettings,
    }
    gathers_from_senders = True

    def need(self, request: Request) -> Decision:
        """Run where a glossy surface may be seen."""
        has_sky = request.content.environment != "none"
        return request.decision(
            "reflections",
            "glossy surfaces reflect what is around them",
            [
                (request.is_view_empty, "no surface is in view"),
                (not request.is_glossy, "every surface in view is diffuse"),
                (not (has_sky or request.anything_is_sent), "there is nothing to reflect"),
            ],
            ("reflections", "reflections_filter", "reflected_radiance"),
        )

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield estimator, filter and what the surface makes of it."""
        settings = request.settings_of(self.name, ReflectionsSettings)
        is_bounce = request.settings.method != "ssdo"
        bound = sender_bound(
            request.scene, request.radius, has_all_bounces=request.runs("far_field")
        )
        # By rays that find them, too.
        glows = has_glow(request) and request.runs("emitters") and request.runs("surface_cache")
        item = ReflectionsPass(
            settings,
            ScreenSpaceSettings(radius=request.radius),
            kind_of(request.scene.environment),
            bound=bound if is_bounce else None,
            has_back_layer=request.runs("back_layer"),
            rays=replace(request.ray_features, glow_is_direct=glows)
            if request.runs("surface_cache")
            else None,
        )
        yield item, "what the lobes of glossy surfaces take in"
        images = ("reflections_raw", "reflections_filtered")
        yield filtered(request, "reflections_filter", *images, is_of_gloss=True)
        yield ReflectedRadiancePass(), "what glossy surfaces reflect"

    def sends(self, request: Request) -> bool:
        """Return that reflections are not sent on."""
        return False
