"""When ambient visibility is called for, and what it multiplies."""

from __future__ import annotations

from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.settings.settings import Combine


def combine_of(request: Request) -> Combine:
    """Return what visibility multiplies: the chosen mode, or by the scene's light.

    Environment light alone where there is one (the physical reading), else direct
    light too, as common viewers do.
    """
    if request.settings.combine is not None:
        return request.settings.combine
    return "multiply" if request.content.environment == "none" else "ambient"


def need_of_visibility(request: Request, *, multiplies_direct: bool) -> Decision:
    """Return whether ambient visibility can matter.

    Parameters
    ----------
    multiplies_direct : bool
        In the mode ``report`` it multiplies direct light; else it is a light of its own.
    """
    if "visibility" in request.wanted:
        return Decision("ambient visibility", True, "the image visibility was asked for")
    combine = combine_of(request)
    no_sky = request.content.environment == "none"
    needs_direct = (combine == "report" and multiplies_direct) or (combine == "multiply" and no_sky)
    return request.decision(
        "ambient visibility",
        "visibility multiplies light",
        [
            (request.is_view_empty, "no surface is in view"),
            (
                combine == "ambient" and no_sky,
                "there is no environment light for it to multiply",
            ),
            (
                needs_direct and not request.runs("direct", "traced_shadows"),
                "there is no light for it to multiply",
            ),
        ],
        ("ssao", "ssao_filter", "reference_ao"),
    )
