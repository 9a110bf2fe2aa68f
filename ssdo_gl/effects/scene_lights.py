"""When direct light is needed, whether its shadows come by maps or by rays."""

from __future__ import annotations

from ssdo_gl.effects.decisions import Decision
from ssdo_gl.effects.request import Request, Shortcut


def _reason_to_drop_lights(request: Request) -> str | None:
    useless = request.lights.count(False)
    if not useless or not request.shows_picture:
        return None
    several = (
        f"{useless} of {len(request.lights)} lights are" if len(request.lights) > 1 else "it is"
    )
    return f"{several} off"


USELESS_LIGHTS = Shortcut("useless lights", _reason_to_drop_lights, ("direct",))


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
