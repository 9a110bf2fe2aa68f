"""Which screen-space passes make the near field, and why."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import TypeVar

from ssdo_gl.graph.render_pass import RenderPass
from ssdo_gl.passes.back_faces import BackFacesPass
from ssdo_gl.passes.bounce import BouncePass, BounceSettings
from ssdo_gl.passes.constant import ConstantPass
from ssdo_gl.passes.depth_layers import DepthLayersPass
from ssdo_gl.passes.directional import (
    ENVIRONMENT_NUMBERS,
    DirectionalPass,
    DirectionalSettings,
)
from ssdo_gl.passes.edge_aware_filter import EdgeAwareFilterPass, EdgeAwareFilterSettings
from ssdo_gl.passes.environment_uniforms import environment_kind
from ssdo_gl.passes.screen_space_settings import ScreenSpaceSettings, default_thickness
from ssdo_gl.passes.sender_radiance import SenderRadiancePass
from ssdo_gl.passes.ssao import SsaoPass, SsaoSettings
from ssdo_gl.planning.content import SceneContent
from ssdo_gl.planning.effects import Effects
from ssdo_gl.planning.near_field import estimator_of, sender_bound
from ssdo_gl.planning.traced_passes import with_overrides
from ssdo_gl.scene.environment import ConstantEnvironment, Environment
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

EstimatorSettings = TypeVar("EstimatorSettings", bound=ScreenSpaceSettings)


def near_field_passes(
    scene: Scene,
    content: SceneContent,
    settings: Settings,
    effects: Effects,
    environment: Environment | None,
) -> Iterator[tuple[RenderPass, str]]:
    """Yield the passes that march through the G-buffer, each with its reason.

    Parameters
    ----------
    scene : Scene
    content : SceneContent
    settings : Settings
        With its radius filled in.
    effects : Effects
    environment : Environment or None
        The scene's, or the simplest that gives the same light.
    """
    yield from _NearField(scene, content, settings, effects, environment).passes


class _NearField:
    """Wires the passes to each other, in the order in which they are added."""

    def __init__(
        self,
        scene: Scene,
        content: SceneContent,
        settings: Settings,
        effects: Effects,
        environment: Environment | None,
    ) -> None:
        self.scene = scene
        self.content = content
        self.settings = settings
        self.effects = effects
        self.environment = environment
        assert settings.radius is not None, "the renderer fills the radius in"
        self.radius: float = settings.radius
        self.passes: list[tuple[RenderPass, str]] = []
        self._add_all()

    def add(self, item: RenderPass, reason: str) -> None:
        self.passes.append((item, reason))

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

    def _add_all(self) -> None:
        effects = self.effects
        if effects.back_layer:
            self.add(BackFacesPass(), "the thickness of closed bodies")
            self.add(DepthLayersPass(), "fronts and backs in one texture, one fetch for both")
        bounce = self.estimator_settings("bounce", BounceSettings)
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
