"""Decides from a scene's content and what was asked for which effects can matter.

Every skip is exact: the images are the same with and without it. `effects = "full"`
skips nothing, so that anybody can check.
"""

from __future__ import annotations

from collections.abc import Sequence

from ssdo_gl.planning.content import SceneContent
from ssdo_gl.planning.decisions import Decision, Effects
from ssdo_gl.planning.near_field import (
    can_share_directions,
    estimator_of,
    reason_to_be_open,
)
from ssdo_gl.planning.view import Sight
from ssdo_gl.settings import Combine, Settings

__all__ = ["Decision", "Effects", "decide", "effective_combine"]


def decide(
    content: SceneContent, settings: Settings, wanted: Sequence[str], sight: Sight | None = None
) -> Effects:
    """Return what must be computed for the images `wanted` of a scene.

    Parameters
    ----------
    content : SceneContent
    settings : Settings
        ``effects="full"`` takes no notice of content and sight.
    wanted : sequence of str
        AOV names or ``display``.
    sight : Sight or None
        What is known of the view; without it, the view rules nothing out.
    """
    return _Decider(content, settings, wanted, sight).effects()


def effective_combine(content: SceneContent, settings: Settings) -> Combine:
    """Return what visibility multiplies: the chosen mode, or by the scene's light.

    Environment light alone where there is one (the physical reading), else direct
    light too, as common viewers do.
    """
    if settings.combine is not None:
        return settings.combine
    return "multiply" if content.environment == "none" else "ambient"


class _Decider:
    """Decides one effect after the other and writes down why."""

    def __init__(
        self,
        content: SceneContent,
        settings: Settings,
        wanted: Sequence[str],
        sight: Sight | None,
    ) -> None:
        self.content = content
        self.settings = settings
        self.is_full = settings.effects == "full"
        # Rays leave the view: what it does not show may matter to them.
        self.sight = None if self.is_full or settings.is_reference else sight
        self.wanted = frozenset(wanted)
        self.shaded = bool({"beauty", "display"} & self.wanted)
        self.rows: list[Decision] = []
        self.is_empty = self.sight is not None and self.sight.is_empty
        self.lights = self._lights()

    def effects(self) -> Effects:
        """Return all decisions, those that others rest on first."""
        method, shaded = self.settings.method, self.shaded
        sends = (method in ("bounce", "reference-near") and shaded) or (
            method not in ("direct", "ssao", "ssdo") and "bounce" in self.wanted
        )
        reads_direct = (shaded and method != "reference-gi") or sends or "direct" in self.wanted
        gathers = method in ("ssdo", "bounce", "reference-near") and (shaded or sends)
        reads_directional = gathers or (
            method not in ("direct", "ssao") and (sends or "directional" in self.wanted)
        )
        direct = reads_direct and self._direct()
        maps = self._shadow_maps() if direct and self.settings.chosen_shadows == "map" else ()
        directional = reads_directional and self._directional()
        is_open = self._is_open(directional)
        bounce = sends and self._bounce(direct, directional, is_open)
        visibility = "visibility" in self.wanted or (
            method in ("ssao", "reference-ao") and shaded and self._ambient_visibility(direct)
        )
        is_scalar = directional and self._is_scalar()
        samples = directional and not is_scalar and self._samples_hemisphere()
        first = "directional" if directional else "ssao" if visibility else ""
        looks_around = first == "ssao" or is_scalar or samples
        shares = bounce and looks_around and self._shares_directions(first)
        near_field = directional or bounce or visibility
        traced_shadows = direct and self.settings.chosen_shadows == "traced"
        # Tables for rays hold the scene as it is.
        traces = self.settings.is_reference or traced_shadows
        self._looked_up_images()
        return Effects(
            direct=direct,
            shadow_map=any(maps),
            traced_shadows=traced_shadows,
            visibility=visibility,
            directional=directional,
            bounce=bounce,
            back_layer=near_field and self._back_layer(is_open),
            emission=self._emission(),
            sender_emission=bounce and (self.is_full or self.content.has_unlit_emission),
            is_open=is_open,
            is_scalar=is_scalar,
            shares_directions=shares,
            samples_hemisphere=samples,
            lights=None if self.is_full or traces else self.lights,
            shadow_maps=None if self.is_full or not maps else maps,
            simplifies_environment=not self.is_full and not traces,
            decisions=tuple(self.rows),
        )

    def _wanted(
        self,
        effect: str,
        why: str,
        skips: Sequence[tuple[bool, str]],
        passes: tuple[str, ...] = (),
    ) -> bool:
        """Record `effect`: skipped for the first true reason in `skips`, else run.

        With ``effects = full`` it runs whatever the reasons say.
        """
        reason = None if self.is_full else next((text for holds, text in skips if holds), None)
        self.rows.append(Decision(effect, reason is None, reason or why, passes))
        return reason is None

    def _lights(self) -> tuple[bool, ...]:
        """Return which lights can matter."""
        lights = self.content.lights
        if self.is_full:
            return (True,) * len(lights)
        reaches = self.sight.reaches if self.sight is not None else (True,) * len(lights)
        chosen = tuple(light.is_on and r for light, r in zip(lights, reaches, strict=True))
        useless = len(lights) - sum(chosen)
        if useless and self.shaded:
            several = f"{useless} of {len(lights)} lights are" if len(lights) > 1 else "it is"
            reason = f"{several} off, or can light nothing in view"
            self.rows.append(Decision("useless lights", False, reason, ("direct",)))
        return chosen

    def _any_light(self, *shadows: str) -> bool:
        pairs = zip(self.content.lights, self.lights, strict=True)
        return any(chosen and light.shadow in shadows for light, chosen in pairs)

    def _nothing_seen(self) -> tuple[bool, str]:
        return self.is_empty, "no surface is in view"

    def _direct(self) -> bool:
        content = self.content
        return self._wanted(
            "direct light",
            "the scene has lights",
            [
                self._nothing_seen(),
                (not content.has_lights, "the scene has no light that is on"),
                (not content.has_direct_lights, "all light comes through open directions"),
                (not self._any_light("map", "none"), "no light can reach anything in view"),
            ],
            ("direct", "direct_radiance", "traced_shadows"),
        )

    def _shadow_maps(self) -> tuple[bool, ...]:
        """Return for each light whether it needs a shadow map."""
        lights = self.content.lights
        possible = (True,) * len(lights) if self.sight is None else self.sight.shadows
        maps = tuple(
            light.shadow == "map" and chosen and (self.is_full or shadowed)
            for light, chosen, shadowed in zip(lights, self.lights, possible, strict=True)
        )
        marked = sum(light.shadow == "map" for light in lights)
        some = f"{sum(maps)} of {marked} lights cast a shadow that can be seen"
        runs = self._wanted(
            "shadow maps",
            "lights cast shadows" if sum(maps) == marked else some,
            [
                (not self._any_light("map"), "no light that matters is marked shadow = map"),
                (not any(maps), "nothing can stand between a light and what is in view"),
            ],
            ("shadow_map",),
        )
        return maps if runs else ()

    def _directional(self) -> bool:
        arrives = self.content.environment != "none" or self._any_light("ssdo")
        return self._wanted(
            "directional occlusion",
            "light comes from the environment or from lights marked shadow = ssdo",
            [
                self._nothing_seen(),
                (not arrives, "there is neither an environment nor an ssdo light in reach"),
            ],
            ("directional", "directional_filter", "directional_radiance"),
        )

    def _is_open(self, directional: bool) -> bool:
        """Return whether nothing within R can block any visible point."""
        if self.sight is None:
            return False
        if self.is_empty:
            return True
        reason = reason_to_be_open(
            self.content,
            self.settings,
            self.sight,
            # A light is looked at along segments of its own.
            looks_at_lights=directional and self._any_light("ssdo"),
        )
        if reason is not None:
            passes = ("ssao", "ssao_filter", "directional", "directional_filter")
            instead = ("constant_visibility", "constant_directional_irradiance")
            self.rows.append(Decision("blocked directions", False, reason, passes, instead))
        return reason is not None

    def _bounce(self, direct: bool, directional: bool, is_open: bool) -> bool:
        content = self.content
        return self._wanted(
            "bounce",
            "lit surfaces send light to their neighbours",
            [
                self._nothing_seen(),
                (not content.has_albedo, "every surface is black, nothing is sent on"),
                (
                    not (direct or directional or content.has_unlit_emission),
                    "nothing that can be seen is lit",
                ),
                (is_open, "nothing is near enough to send light to what is in view"),
            ],
            ("sender_radiance", "bounce", "bounce_filter", "bounce_radiance"),
        )

    def _ambient_visibility(self, direct: bool) -> bool:
        combine = effective_combine(self.content, self.settings)
        no_sky = self.content.environment == "none"
        # With ray-traced visibility the report adds it as a light of its own.
        multiplies_direct = combine == "report" and self.settings.method == "ssao"
        return self._wanted(
            "ambient visibility",
            "visibility multiplies light",
            [
                self._nothing_seen(),
                (
                    combine == "ambient" and no_sky,
                    "there is no environment light for it to multiply",
                ),
                (
                    not direct and (multiplies_direct or (combine == "multiply" and no_sky)),
                    "there is no light for it to multiply",
                ),
            ],
            ("ssao", "ssao_filter", "reference_ao"),
        )

    def _is_scalar(self) -> bool:
        """Return whether visibility alone tells how much directional light arrives."""
        holds = (
            not self.is_full
            and not self.settings.is_reference
            and estimator_of(self.settings, "directional") == "march"
            and self.content.environment == "constant"
            and not self._any_light("ssdo")
        )
        if holds:
            reason = "the environment is the same from everywhere: how open a point is says it all"
            passes, instead = ("directional", "directional_filter"), ("ssao", "ssao_filter")
            self.rows.append(Decision("light by direction", False, reason, passes, instead))
        return holds

    def _samples_hemisphere(self) -> bool:
        """Return whether directional light needs more than directions to its lights."""
        needed = self.is_full or self.content.environment != "none" or "visibility" in self.wanted
        if not needed and estimator_of(self.settings, "directional") == "march":
            reason = "light comes from lights only, so no other direction is looked in"
            self.rows.append(Decision("hemisphere", False, reason, ("directional",)))
            return False
        return True

    def _shares_directions(self, first: str) -> bool:
        """Return whether one march serves the bounce and the pass `first` before it."""
        if self.is_full or self.settings.is_reference:
            return False
        if not can_share_directions(self.settings, first):
            return False
        reason = "the bounce takes over which directions were found blocked, and by what"
        self.rows.append(Decision("second march", False, reason, ("bounce",)))
        return True

    def _back_layer(self, is_open: bool) -> bool:
        marches = self.settings.chosen_estimator == "march" and not self.settings.is_reference
        return marches and self._wanted(
            "back-face layer",
            "closed bodies have a back that bounds their thickness",
            [
                (is_open, "no direction is blocked, so no thickness is asked for"),
                (
                    not self.content.has_closed_meshes,
                    "no mesh is closed, so there is no back to find",
                ),
            ],
            ("back_faces", "depth_layers"),
        )

    def _emission(self) -> bool:
        reads = self.shaded or "emission" in self.wanted
        return not reads or self._wanted(
            "emission",
            "surfaces emit",
            [(not self.content.has_emission, "no surface emits")],
            ("gbuffer", "composite"),
        )

    def _looked_up_images(self) -> None:
        """Say which images of the scene no pass has to fetch; the variants take care of it."""
        if self.is_full:
            return
        if self.content.environment_is_simplified and not self.settings.is_reference:
            reason = "it is black or of one colour everywhere, which needs no lookup"
            self.rows.append(Decision("environment image", False, reason, ("environment",)))
        if self.shaded and not self.content.has_textures:
            reason = "no material has an image, so none is fetched"
            self.rows.append(Decision("surface images", False, reason))
