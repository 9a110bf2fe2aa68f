"""Turns effects into passes and their wiring."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from ssdo_gl.effects import Decision, Effects, decide, effective_combine
from ssdo_gl.graph.environment_uniforms import environment_kind
from ssdo_gl.graph.graph import compile_graph
from ssdo_gl.graph.render_pass import RenderPass
from ssdo_gl.near_field import estimator_of, sender_bound
from ssdo_gl.passes.back_faces import BackFacesPass
from ssdo_gl.passes.bounce import BouncePass, BounceSettings
from ssdo_gl.passes.composite import Combine, CompositePass
from ssdo_gl.passes.constant import ConstantPass
from ssdo_gl.passes.depth_layers import DepthLayersPass
from ssdo_gl.passes.direct import DirectPass, DirectSettings
from ssdo_gl.passes.directional import (
    ENVIRONMENT_NUMBERS,
    DirectionalPass,
    DirectionalSettings,
)
from ssdo_gl.passes.edge_aware_filter import EdgeAwareFilterPass, EdgeAwareFilterSettings
from ssdo_gl.passes.environment import EnvironmentPass
from ssdo_gl.passes.gbuffer import GBufferPass
from ssdo_gl.passes.open_tiles import OpenTilesPass
from ssdo_gl.passes.radiance_aov import RadianceAovPass
from ssdo_gl.passes.screen_space_settings import ScreenSpaceSettings, default_thickness
from ssdo_gl.passes.sender_radiance import SenderRadiancePass
from ssdo_gl.passes.shadow_map import ShadowMapPass, ShadowMapSettings
from ssdo_gl.passes.ssao import SsaoPass, SsaoSettings
from ssdo_gl.passes.tile_planes import TilePlanesPass
from ssdo_gl.passes.tone_map import ToneMapPass, ToneMapSettings
from ssdo_gl.scene.content import SceneContent, simplest_environment
from ssdo_gl.scene.environment import ConstantEnvironment, Environment, MapEnvironment
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.traced_passes import TRACED_SETTINGS, traced_passes, with_overrides

# What ``--set PASS.FIELD=VALUE`` reaches, by pass name.
PASS_SETTINGS: dict[str, type[Any]] = {
    "shadow_map": ShadowMapSettings,
    "direct": DirectSettings,
    "ssao": SsaoSettings,
    "directional": DirectionalSettings,
    "bounce": BounceSettings,
    "edge_aware_filter": EdgeAwareFilterSettings,
    "tone_map": ToneMapSettings,
    **TRACED_SETTINGS,
}
EstimatorSettings = TypeVar("EstimatorSettings", bound=ScreenSpaceSettings)


@dataclass(frozen=True)
class Output:
    """Where an image comes from: channels of a resource, or a neutral constant."""

    resource: str | None
    channels: int
    first_channel: int = 0
    neutral: float = 0.0


@dataclass(frozen=True)
class Pipeline:
    """Passes for what was asked for.

    Attributes
    ----------
    passes : tuple of RenderPass
    outputs : dict of image name to Output
    decisions : tuple of Decision
    reasons : dict of pass name to why it runs
    skipped : dict of pass name to why it is not needed
    notes : tuple of str
    """

    passes: tuple[RenderPass, ...]
    outputs: dict[str, Output]
    decisions: tuple[Decision, ...]
    reasons: dict[str, str] = field(default_factory=dict)
    skipped: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def resources(self) -> tuple[str, ...]:
        """Resources that must be made, for the graph."""
        named = (output.resource for output in self.outputs.values())
        return tuple(dict.fromkeys(name for name in named if name is not None))


def build_pipeline(
    scene: Scene,
    content: SceneContent,
    settings: Settings,
    wanted: Sequence[str],
    effects: Effects | None = None,
) -> Pipeline:
    """Return the passes that make the images `wanted` (AOV names or ``display``).

    Parameters
    ----------
    effects : Effects or None
        None: decided from the scene's content alone.
    """
    effects = effects or decide(content, settings, wanted)
    pipeline = _Builder(scene, content, settings, wanted, effects).build()
    if settings.effects == "full":
        return pipeline
    full = build_pipeline(scene, content, dataclasses.replace(settings, effects="full"), wanted)
    return dataclasses.replace(pipeline, skipped=_reasons_to_skip(pipeline, full))


def _reasons_to_skip(pipeline: Pipeline, full: Pipeline) -> dict[str, str]:
    """Return why the passes do not run that only the full pipeline has."""
    has = {item.name for item in pipeline.passes}
    order = compile_graph(full.passes, full.resources).order
    reasons: dict[str, str] = {}
    for name in (item.name for item in order if item.name not in has):
        spared = (d.reason for d in pipeline.decisions if not d.run and name in d.passes)
        reasons[name] = next(spared, "no effect that runs needs it")
    return reasons


class _Builder:
    def __init__(
        self,
        scene: Scene,
        content: SceneContent,
        settings: Settings,
        wanted: Sequence[str],
        effects: Effects,
    ) -> None:
        self.scene = scene
        self.content = content
        self.settings = settings
        self.wanted = tuple(wanted)
        self.effects = effects
        self.passes: list[RenderPass] = []
        self.reasons: dict[str, str] = {}
        assert settings.radius is not None, "the renderer fills the radius in"
        self.radius: float = settings.radius
        self.paths = settings.method == "reference-gi"
        self.environment: Environment | None = scene.environment
        if effects.simplifies_environment:
            self.environment = simplest_environment(scene.environment)

    def build(self) -> Pipeline:
        self.add(GBufferPass(), "everything starts from what the camera sees")
        self._add_lights()
        settings, effects = self.settings, self.effects
        if settings.is_reference or effects.traced_shadows:
            for item, reason in traced_passes(self.scene, settings, effects, paths=self.paths):
                self.add(item, reason)
        if not settings.is_reference:
            self._add_near_field()
        self._add_composite()
        outputs = {name: self._output(name) for name in self.wanted}
        pipeline = Pipeline(tuple(self.passes), outputs, self.effects.decisions, self.reasons)
        return pipeline if settings.effects == "full" else _without_unread_targets(pipeline)

    def add(self, item: RenderPass, reason: str) -> None:
        self.passes.append(item)
        self.reasons[item.name] = reason

    def estimator_settings(self, name: str, cls: type[EstimatorSettings]) -> EstimatorSettings:
        settings = self.settings
        base = cls(
            estimator=estimator_of(settings, name),
            radius=self.radius,
            samples=settings.samples,
            steps=settings.steps,
            resolution_scale=settings.resolution_scale,
        )
        chosen = with_overrides(self.settings, name, base)
        if chosen.thickness is None:
            # By what the scene holds, not by whether its backs happen to be drawn.
            marches = settings.chosen_estimator == "march"
            has_backs = marches and self.content.has_closed_meshes
            thickness = default_thickness(chosen.estimator, has_backs)
            chosen = dataclasses.replace(chosen, thickness=thickness)
        return chosen

    def _add_lights(self) -> None:
        effects = self.effects
        map_settings = with_overrides(self.settings, "shadow_map", ShadowMapSettings())
        if effects.shadow_map:
            self.add(ShadowMapPass(map_settings), "lights cast shadows")
        if effects.direct and not effects.traced_shadows:
            settings_direct = with_overrides(self.settings, "direct", DirectSettings())
            self.add(
                DirectPass(
                    settings_direct,
                    shadow_maps=effects.shadow_map,
                    parts_per_side=map_settings.parts_per_side,
                ),
                "light of the scene's lights",
            )
        if isinstance(self.environment, MapEnvironment):
            self.add(EnvironmentPass(), "the image of the environment, and its irradiance")

    def _add_near_field(self) -> None:
        effects = self.effects
        if effects.back_layer:
            self.add(BackFacesPass(), "the thickness of closed bodies")
            self.add(DepthLayersPass(), "fronts and backs in one texture, one fetch for both")
        bounce = self.estimator_settings("bounce", BounceSettings)
        if effects.open_tile_size:
            self._add_open_tiles(bounce)
        keeps = bounce.refine_steps if effects.shares_directions else None
        if effects.is_scalar:
            self._add_scalar_directional(keeps)
        elif effects.directional:
            self._add_directional(keeps)
        elif effects.visibility and effects.is_open:
            self.add(ConstantPass("visibility", (1.0,)), "every visible point is open")
        elif effects.visibility:
            settings = self.estimator_settings("ssao", SsaoSettings)
            self._add_ssao(settings, keeps, "how open each point is")
            self._add_filter("ssao")
        if effects.bounce:
            self._add_bounce(bounce)

    def _add_open_tiles(self, bounce: BounceSettings) -> None:
        """Look for open tiles on behalf of every estimator that may run."""
        directional = self.estimator_settings("directional", DirectionalSettings)
        alone = self.estimator_settings("ssao", SsaoSettings)
        # Lights that are looked at may be marched to in fewer steps than the rest.
        steps = min(directional.step_count, directional.light_steps)
        relying = [(bounce, bounce.step_count), (directional, steps), (alone, alone.step_count)]
        size = self.effects.open_tile_size
        self.add(TilePlanesPass(size), "which squares of the frame show a single plane")
        self.add(OpenTilesPass(relying, size), "which of them nothing in reach rises above")

    def _add_scalar_directional(self, keeps: int | None) -> None:
        """One colour from everywhere: what arrives is that of an open point times visibility."""
        assert isinstance(self.environment, ConstantEnvironment)
        red, green, blue = (math.pi * value for value in self.environment.radiance)
        # The same directions as the directional estimator takes, whose settings hold.
        like = self.estimator_settings("directional", DirectionalSettings)
        if self.effects.is_open and like.resolution_scale != 1.0:
            # The filter leaves pixels dark of which the smaller image shows nothing.
            self._add_directional(None)
            return
        if self.effects.is_open:
            constant = ConstantPass("directional_irradiance", (red, green, blue, 1.0))
            self.add(constant, "the same light arrives at every visible point")
            return
        shared = {f.name: getattr(like, f.name) for f in dataclasses.fields(ScreenSpaceSettings)}
        reason = "how open each point is says how much of the environment's one colour arrives"
        self._add_ssao(SsaoSettings(**shared), keeps, reason)
        self._add_filter("ssao", "directional_irradiance", (red, green, blue))

    def _add_ssao(self, settings: SsaoSettings, keeps: int | None, reason: str) -> None:
        self.add(
            SsaoPass(
                settings,
                has_back_layer=self.effects.back_layer,
                keeps=keeps,
                open_tile_size=self.effects.open_tile_size,
            ),
            reason,
        )

    def _add_directional(self, keeps: int | None) -> None:
        effects = self.effects
        names = {value: name for name, value in ENVIRONMENT_NUMBERS.items()}
        self.add(
            DirectionalPass(
                self.estimator_settings("directional", DirectionalSettings),
                environment=names[environment_kind(self.environment)],
                has_back_layer=effects.back_layer,
                needs_visibility=effects.samples_hemisphere,
                is_open=effects.is_open,
                keeps=keeps,
                open_tile_size=effects.open_tile_size,
            ),
            "light through open directions",
        )
        self._add_filter("directional")

    def _add_bounce(self, settings: BounceSettings) -> None:
        effects = self.effects
        self.add(
            SenderRadiancePass(
                has_direct=effects.direct,
                has_directional=effects.directional,
                has_emission=effects.sender_emission,
            ),
            "what each surface sends on",
        )
        self.add(
            BouncePass(
                settings,
                sender_bound=sender_bound(self.scene, self.radius),
                has_back_layer=effects.back_layer,
                takes_directions=effects.shares_directions,
                open_tile_size=effects.open_tile_size,
            ),
            "light from blocked directions",
        )
        self._add_filter("bounce")

    def _add_filter(
        self,
        kind: str,
        result: str | None = None,
        open_irradiance: tuple[float, float, float] | None = None,
    ) -> None:
        """Add the filter after the estimator `kind`: ssao, directional or bounce."""
        source, usual = {
            "ssao": ("visibility_raw", "visibility"),
            "directional": ("directional_raw", "directional_irradiance"),
            "bounce": ("bounce_raw", "bounce_irradiance"),
        }[kind]
        settings = EdgeAwareFilterSettings(filter=self.settings.filter)
        self.add(
            EdgeAwareFilterPass(
                f"{kind}_filter",
                with_overrides(self.settings, "edge_aware_filter", settings),
                source=source,
                result=result or usual,
                is_visibility=kind == "ssao",
                holds_z=kind != "directional",
                open_irradiance=open_irradiance,
            ),
            "removes the sampling noise along surfaces",
        )

    def _add_composite(self) -> None:
        effects, settings = self.effects, self.settings
        gathers = settings.method not in ("ssao", "reference-ao")  # else visibility stands in
        combine: Combine = effective_combine(self.content, settings)
        if combine == "report" and settings.method == "reference-ao":
            combine = "report_traced"
        self.add(
            CompositePass(
                self.environment,
                direct="direct_irradiance" if effects.direct else None,
                directional="directional_irradiance" if gathers and effects.directional else None,
                bounce="bounce_irradiance" if gathers and effects.bounce else None,
                visibility="visibility" if effects.visibility and not gathers else None,
                combine=combine,
                has_emission=effects.emission,
            ),
            "adds up the terms",
        )
        tone = ToneMapSettings(exposure=settings.exposure or 0.0)
        source = "gi_radiance" if self.paths else "beauty"
        self.add(
            ToneMapPass(with_overrides(self.settings, "tone_map", tone), source),
            "from radiance to the display",
        )

    def _output(self, name: str) -> Output:
        """Return where image `name` is read from, adding a pass if it needs one."""
        effects = self.effects
        plain = {
            "display": Output("display", 4),
            "beauty": Output("gi_radiance" if self.paths else "beauty", 4),
            "albedo": Output("albedo", 3),
            "depth": Output("z_vs", 1),
            # Both are finished on the host, in float64, from what they start with.
            "position_ws": Output("z_vs", 1),
            "normal_ws": Output("normals_vs", 4),
        }
        if name in plain:
            return plain[name]
        if name == "visibility":
            if effects.directional and not self.settings.is_reference:
                return Output("directional_irradiance", 1, first_channel=3)
            return Output("visibility", 1)
        runs = {
            "emission": effects.emission,
            "direct": effects.direct,
            "directional": effects.directional,
            "bounce": effects.bounce,
        }[name]
        if not runs:
            return Output(None, 3)
        if name == "emission":
            return Output("emission", 3)
        resource = f"{name}_radiance"
        self.add(RadianceAovPass(f"{name}_irradiance", resource), f"the image {name} was asked for")
        return Output(resource, 3)


def _without_unread_targets(pipeline: Pipeline) -> Pipeline:
    """Return `pipeline` with a G-buffer of what the passes that will run read of it."""
    order = compile_graph(pipeline.passes, pipeline.resources).order
    read = {resource for item in order for resource in item.reads} | set(pipeline.resources)
    passes = tuple(
        GBufferPass(read) if isinstance(item, GBufferPass) else item for item in pipeline.passes
    )
    return dataclasses.replace(pipeline, passes=passes)
