"""When direct light is needed, whether its shadows come by maps or by rays."""

from __future__ import annotations

from ssdo_gl.effects.request import Decision, Request, Shortcut
from ssdo_gl.scene.light_bodies import approximations
from ssdo_gl.settings.methods import METHODS


def _reason_to_drop_lights(request: Request) -> str | None:
    useless = request.lights.count(False)
    if not useless or not request.shows_picture:
        return None
    several = (
        f"{useless} of {len(request.lights)} lights are" if len(request.lights) > 1 else "it is"
    )
    return f"{several} off"


USELESS_LIGHTS = Shortcut("useless lights", _reason_to_drop_lights, ("direct",))


def takes_stand_ins(request: Request) -> bool:
    """Return whether rays to glowing bodies take the place of lights that approximate them.

    Those are kept where gloss has no other light of them, because nothing is sent on that rays
    of its lobes would find; traced shadows are of the bodies in any case.
    """
    content, settings = request.content, request.settings
    by_gi = METHODS[settings.method].is_all_light and not settings.is_reference
    by_maps = settings.chosen_shadows == "map"
    by_rays = content.has_albedo or not content.has_gloss
    return content.has_stand_ins and by_gi and by_maps and by_rays


def has_glow(request: Request) -> bool:
    """Return whether bodies glow that no light of the scene is exactly."""
    return request.content.has_glow or takes_stand_ins(request)


def lights_of_glow(request: Request) -> frozenset[int]:
    """Return the lights of bodies whose light the effect `emitters` brings exactly."""
    if not (request.runs("emitters") and takes_stand_ins(request)):
        return frozenset()
    lights = request.scene.lights
    return frozenset(i for i in approximations(request.scene) if lights[i].shadow == "map")


def need_of_direct_light(request: Request) -> Decision:
    """Return whether light of the scene's lights can matter."""
    content = request.content
    return request.decision(
        "direct light",
        "the scene has lights",
        [
            (request.is_view_empty, "no surface is in view"),
            (not content.has_lights, "the scene has no light that is on"),
            (not content.has_direct_lights, "all light comes through open directions"),
        ],
        ("direct", "direct_radiance", "traced_shadows"),
    )
