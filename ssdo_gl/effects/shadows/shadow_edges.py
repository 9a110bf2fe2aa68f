"""Shadow rays where shadow maps are too coarse: at edges, and in penumbrae."""

from __future__ import annotations

from collections.abc import Iterator

from ssdo_gl.effects.effect import Effect, ReasonedPass
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.settings.methods import METHODS


class ShadowEdges(Effect):
    """Shadow rays for the edges of shadows, of `gi`, which has the hierarchy anyway.

    A map of a long scene has texels larger than pixels of what is near. In `colonnade` at 640x360
    rays take the RMSE of direct light from 7.1 to 0.7 % of its mean; in `carousel`, whose lamps
    move, maps had a third of the squared temporal error, in `cornell_meso` two thirds.
    """

    name = "shadow_edges"
    after = ("direct",)
    traces = True

    def is_asked(self, request: Request) -> bool:
        """Return whether lights cast shadows by maps where far light comes by rays."""
        settings = request.settings
        by_rays = METHODS[settings.method].is_all_light and not settings.is_reference
        by_maps = settings.chosen_shadows == "map" and request.has_light("map")
        return by_rays and by_maps and request.runs("direct")

    def need(self, request: Request) -> Decision:
        """Run where a light may throw a shadow on what is in view."""
        return request.decision(
            "shadow edges",
            "rays tell where shadows end",
            [
                (request.is_view_empty, "no surface is in view"),
                (
                    request.view is not None and request.view.is_alone,
                    "what is in view is a box that stands alone",
                ),
            ],
            (),
        )

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield none: the pass of direct light sends them."""
        yield from ()
