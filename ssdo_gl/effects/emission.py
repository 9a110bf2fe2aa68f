"""Light that surfaces emit of their own accord."""

from __future__ import annotations

from collections.abc import Iterator

from ssdo_gl.effects.effect import Effect, ReasonedPass, Term
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.settings.methods import ALL


class Emission(Effect):
    """L_e, as the G-buffer holds it; senders pass on what no light of the scene delivers."""

    name = "emission"
    methods = ALL - {"reference-gi"}
    shown_by = ALL
    terms = (Term("emission", "emission", "radiance"),)

    def need(self, request: Request) -> Decision:
        """Run where any surface emits. Without, a frame of `corner` takes .94 of the time."""
        return request.decision(
            "emission",
            "surfaces emit",
            [
                (not request.content.has_emission, "no surface emits"),
                (
                    request.view is not None and request.view.emission_region is None,
                    "no surface in view emits",
                ),
            ],
            ("gbuffer", "composite"),
        )

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield nothing: the G-buffer writes it wherever it is read."""
        yield from ()

    def sends(self, request: Request) -> bool:
        """Return whether any surface emits light that does not arrive as direct light."""
        if request.runs("emitters") and request.content.has_glow:
            return False
        return request.is_full or request.content.has_unlit_emission
