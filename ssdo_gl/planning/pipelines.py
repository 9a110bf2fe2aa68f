"""Turns effects into passes and their wiring."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from ssdo_gl.graph.graph import compile_graph
from ssdo_gl.graph.render_pass import RenderPass
from ssdo_gl.passes.bounce import BounceSettings
from ssdo_gl.passes.composite import Combine, CompositePass
from ssdo_gl.passes.direct import DirectPass, DirectSettings
from ssdo_gl.passes.directional import DirectionalSettings
from ssdo_gl.passes.edge_aware_filter import EdgeAwareFilterSettings
from ssdo_gl.passes.environment import EnvironmentPass
from ssdo_gl.passes.gbuffer import GBufferPass
from ssdo_gl.passes.radiance_aov import RadianceAovPass
from ssdo_gl.passes.shadow_map import ShadowMapPass, ShadowMapSettings
from ssdo_gl.passes.ssao import SsaoSettings
from ssdo_gl.passes.tone_map import ToneMapPass, ToneMapSettings
from ssdo_gl.planning.content import SceneContent, simplest_environment
from ssdo_gl.planning.effects import Decision, Effects, decide, effective_combine
from ssdo_gl.planning.near_field_passes import near_field_passes
from ssdo_gl.planning.traced_passes import TRACED_SETTINGS, traced_passes, with_overrides
from ssdo_gl.scene.environment import Environment, MapEnvironment
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

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
            for item, reason in near_field_passes(
                self.scene, self.content, settings, effects, self.environment
            ):
                self.add(item, reason)
        self._add_composite()
        outputs = {name: self._output(name) for name in self.wanted}
        pipeline = Pipeline(tuple(self.passes), outputs, self.effects.decisions, self.reasons)
        return pipeline if settings.effects == "full" else _without_unread_targets(pipeline)

    def add(self, item: RenderPass, reason: str) -> None:
        self.passes.append(item)
        self.reasons[item.name] = reason

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
        aov = RadianceAovPass(f"{name}_irradiance", resource)
        self.add(aov, f"the image {name} was asked for")
        return Output(resource, 3)


def _without_unread_targets(pipeline: Pipeline) -> Pipeline:
    """Return `pipeline` with a G-buffer of what the passes that will run read of it."""
    order = compile_graph(pipeline.passes, pipeline.resources).order
    read = {resource for item in order for resource in item.reads} | set(pipeline.resources)
    passes = tuple(
        GBufferPass(read) if isinstance(item, GBufferPass) else item for item in pipeline.passes
    )
    return dataclasses.replace(pipeline, passes=passes)
