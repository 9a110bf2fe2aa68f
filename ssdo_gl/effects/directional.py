"""Light through open directions: directional occlusion."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from ssdo_gl import math3d
from ssdo_gl.effects.effect import Effect, ImageSource, ReasonedPass, Term
from ssdo_gl.effects.near_field import (
    OPEN_DIRECTIONS,
    estimator_of,
    estimator_settings,
    filtered,
)
from ssdo_gl.effects.request import Decision, Request, Shortcut
from ssdo_gl.graph.frame import Frame, FrameView
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.last_made import LastMade
from ssdo_gl.passes.draw_inputs import draw_inputs
from ssdo_gl.passes.edge_aware_filter import EdgeAwareFilterSettings
from ssdo_gl.passes.environment_uniforms import (
    MAP_IRRADIANCE,
    MAP_RADIANCE,
    environment_defines,
    environment_uniforms,
)
from ssdo_gl.passes.light_rows import UNSHADOWED_ROWS, light_rows
from ssdo_gl.passes.own_lookup import GATHERED
from ssdo_gl.passes.screen_space_settings import (
    ScreenSpaceSettings,
    defines,
    estimator_uniforms,
    kept_resources,
)
from ssdo_gl.scene.environment import (
    EnvironmentKind,
    kind_of,
)
from ssdo_gl.scene.lights import Form, Light
from ssdo_gl.settings.estimators import ESTIMATORS
from ssdo_gl.settings.fields import setting

CONTROL_NUMBERS = {"none": 0, "ratio": 1, "subtract": 2}


@dataclass(frozen=True)
class DirectionalSettings(ScreenSpaceSettings):
    """Settings of directional occlusion."""

    control: str = setting(
        "auto",
        "march: how the environment's exact light corrects the sampled light; "
        "auto: ratio for a map, else subtract",
        choices=("auto", "subtract", "ratio", "none"),
    )
    light_steps: int = setting(
        16, "depth reads towards each point, spot or directional ssdo light", low=1, high=256
    )


def ssdo_lights(lights: Sequence[Light]) -> list[Light]:
    """Return the lights that arrive through SSDO, those with an area first."""
    chosen = [light for light in lights if light.shadow == "ssdo"]
    return sorted(chosen, key=lambda light: light.form is not Form.AREA)


def light_uniforms(lights: Sequence[Light], view: FrameView) -> dict[str, Any]:
    """Return the uniforms of `lights/ssdo_lights.glsl`: `ssdo_lights` in view space."""
    if not lights:
        return {}
    rows = light_rows(lights, [None] * len(lights), view)
    return {"u_ssdo_lights": math3d.read_only(rows[:, :UNSHADOWED_ROWS].reshape(-1, 4))}


def uniforms(settings: DirectionalSettings, frame: Frame, has_back_layer: bool) -> dict[str, Any]:
    """Return the uniforms of `effects/directional.frag`."""
    return {
        **estimator_uniforms(settings, frame, has_back_layer),
        **environment_uniforms(frame),
    }


class DirectionalPass(RenderPass):
    """Estimates the integral of L_in(w) V_R(w) cos(theta) dw at every receiver.

    Writes ``directional_raw``: rgb = irradiance, a = visibility. Background: 0 and 1.

    Parameters
    ----------
    settings : DirectionalSettings
        With ``estimator="rgs09"`` the open light is summed as in the paper, whatever
        ``control`` says.
    environment : str
        Kind of the scene's: none, constant, gradient or map. For a map, the resources
        ``environment`` and ``environment_irradiance`` are read.
    has_baked_occlusion : bool
        Read from ``finish`` how much of the environment images say that surfaces see.
    is_gathered : bool
        The light of per-pixel rays takes the place of the march's, which finds visibility alone.
    has_back_layer : bool
        Read ``z_layers`` to know where solids end.
    marches_to_lights : bool
        There may be lights that arrive through SSDO.
    needs_visibility : bool
        Whether anyone reads the visibility. Without it and without an environment whose light
        marches find, the hemisphere is not sampled at all (lights have directions of their own),
        and visibility comes out as 1.
    is_open : bool
        It is known that nothing in view blocks any direction within R.
    keeps : int or None
        Keep what blocks each direction, refined by so many bisections, for a bounce:
        ``kept_0``, ``kept_1``, ... (see ``screen_space/kept_directions.glsl``). None: do not.
    """

    overwrites: ClassVar[bool] = True

    def __init__(
        self,
        settings: DirectionalSettings,
        *,
        environment: EnvironmentKind = "none",
        has_back_layer: bool = False,
        marches_to_lights: bool = True,
        needs_visibility: bool = True,
        is_open: bool = False,
        keeps: int | None = None,
        is_gathered: bool = False,
        has_baked_occlusion: bool = False,
    ) -> None:
        self.name = "directional"
        self.settings = settings
        self.reads = (
            "z_vs",
            "normals_vs",
            *(GATHERED[:1] if is_gathered else ()),
            *(("z_layers",) if has_back_layer else ()),
            *((MAP_RADIANCE, MAP_IRRADIANCE) if environment == "map" else ()),
            *(("finish",) if has_baked_occlusion else ()),
        )
        spec = TextureSpec(4, scale=settings.resolution_scale, transient=True)
        self.writes = {"directional_raw": spec}
        if keeps is not None:
            self.writes |= kept_resources(settings)
        self.depends_on = ("view", "seed", "lights", "environment")
        control = settings.control
        if control == "auto":
            control = "ratio" if environment == "map" else "subtract"
        is_paper = ESTIMATORS[settings.estimator].sums_open_light and not is_gathered
        if is_paper:
            control = "none"
        self._has_back_layer = has_back_layer
        self._marches_to_lights = marches_to_lights
        self._lights: LastMade[list[Light]] = LastMade()
        self._light_values: LastMade[dict[str, Any]] = LastMade()
        is_lit = environment != "none" and not is_gathered
        self._defines = {
            **defines(
                settings,
                has_back_layer,
                keeps or 0,
                is_open=is_open,
                keeps_directions=keeps is not None,
            ),
            **environment_defines(environment),
            "HAS_BAKED_OCCLUSION": int(has_baked_occlusion),
            "GATHERED": int(is_gathered),
            "CONTROL_VARIATE": CONTROL_NUMBERS[control],
            "LIGHT_STEP_COUNT": settings.samples if is_paper else settings.light_steps,
            "SUMS_OPEN_LIGHT": int(is_paper),
            "NEEDS_HEMISPHERE": int(needs_visibility or is_lit or is_paper),
        }

    def execute(self, context: PassContext) -> None:
        frame, view = context.frame, context.frame.view
        lights = self._lights.get((frame.scene.lights,), lambda: ssdo_lights(frame.scene.lights))
        light_values = self._light_values.get(
            (lights, view.position_ws, view.view_from_world), lambda: light_uniforms(lights, view)
        )
        area_count = sum(light.form is Form.AREA for light in lights)
        all_defines = {
            **self._defines,
            "SSDO_AREA_COUNT": area_count,
            "SSDO_POINT_COUNT": len(lights) - area_count,
        }
        draw_inputs(
            context,
            context.shaders.fullscreen(
                "effects/directional.frag",
                all_defines,
                ESTIMATORS[self.settings.estimator].choices,
            ),
            {
                **uniforms(self.settings, frame, self._has_back_layer),
                **light_values,
            },
            self.reads,
        )


def _reason_for_lights_only(request: Request) -> str | None:
    """Return why no other directions than those to lights are looked in, or None."""
    looks = request.content.environment != "none" or request.runs("far_field")
    sums_open_light = ESTIMATORS[estimator_of(request, "directional")].sums_open_light
    if looks or sums_open_light or "visibility" in request.wanted:
        return None
    return "light comes from lights only, so no other direction is looked in"


# `ssdo` in coloured_lights takes .77 of a frame.
LIGHTS_ONLY = Shortcut("hemisphere", _reason_for_lights_only, ("directional",))


class Directional(Effect):
    """Light of the environment and of ``ssdo`` lights through open directions."""

    name = "directional"
    after = ("far_field",)
    methods = frozenset({"ssdo", "bounce", "gi"})
    terms = (Term("directional", "directional_irradiance"),)
    images = ("visibility",)
    shortcuts = (OPEN_DIRECTIONS, LIGHTS_ONLY)
    settings: ClassVar[Mapping[str, type]] = {
        "directional": DirectionalSettings,
        "directional_filter": EdgeAwareFilterSettings,
    }
    looks_around = True

    def need(self, request: Request) -> Decision:
        """Run where any light comes from the environment or from lights marked ``ssdo``.

        Without, a frame of a Cornell box (a model made by others) takes .84 of the time.
        """
        arrives = (
            request.content.environment != "none"
            or request.has_light("ssdo")
            or request.runs("far_field")
        )
        return request.decision(
            "directional occlusion",
            "light comes from the environment or from lights marked shadow = ssdo",
            [
                (request.is_view_empty, "no surface is in view"),
                (not arrives, "there is neither an environment nor an ssdo light that is on"),
            ],
            ("directional", "directional_filter", "directional_radiance"),
        )

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield estimator and filter."""
        settings = estimator_settings(request, "directional", DirectionalSettings)
        is_open = request.takes(OPEN_DIRECTIONS)
        is_gathered, is_baked = request.runs("far_field"), request.content.has_baked_occlusion
        needs_visibility = not request.takes(LIGHTS_ONLY)
        if is_gathered:
            needs_visibility = is_baked or "visibility" in request.wanted
        marches_to_lights = request.has_light("ssdo")
        marches = not is_gathered or needs_visibility or marches_to_lights
        item = DirectionalPass(
            settings,
            environment=kind_of(request.scene.environment),
            is_gathered=is_gathered,
            has_back_layer=marches and request.runs("back_layer"),
            marches_to_lights=marches_to_lights,
            needs_visibility=needs_visibility,
            has_baked_occlusion=is_baked,
            is_open=is_open,
            keeps=None if is_open else request.kept_refinements,
        )
        yield item, "light through open directions"
        yield filtered(
            request,
            "directional_filter",
            "directional_raw",
            "directional_irradiance",
            holds_z=False,
        )

    def sent_terms(self, request: Request) -> Iterable[Term]:
        """Return the unfiltered image.

        The bounce averages over its senders anyway. The blur of a filter that comes first
        costs accuracy: relative RMSE of the picture +.2 to +.8 % over six scenes. At half the
        size the mean of four pixels does, within -.6 to +2 % over five scenes.
        """
        return (Term("directional", "directional_raw"),)

    def image(self, request: Request, name: str) -> ImageSource:
        """Return the visibility, which rides along in the alpha of the irradiance."""
        return ImageSource("directional_irradiance", 1, first_channel=3)

    def marches(self, request: Request) -> str | None:
        """Return the pass whose settings hold, if it looks in all directions."""
        return None if request.takes(LIGHTS_ONLY) else "directional"
