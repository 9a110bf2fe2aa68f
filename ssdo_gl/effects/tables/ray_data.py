"""The scene as rays need it: the hierarchy, materials and emitters as tables."""

from __future__ import annotations

from collections.abc import Iterator

from ssdo_gl.effects.effect import Effect, ReasonedPass
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.passes.rays import (
    BvhUploadPass,
    EmitterTablesPass,
    MaterialTablePass,
    SurfaceTablesPass,
)


class RayData(Effect):
    """The tables that every pass reads that traces rays."""

    name = "ray_data"
    after = ("surface_cache", "shadow_edges")

    def is_asked(self, request: Request) -> bool:
        return request.traces

    def need(self, request: Request) -> Decision:
        """Run whenever rays are traced."""
        passes = ("bvh_upload", "surface_tables", "material_table", "emitter_tables")
        return Decision("ray data", True, "rays are traced", passes)

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield the four uploads."""
        yield BvhUploadPass(), "the triangles, in a tree that rays descend"
        yield SurfaceTablesPass(), "what rays hit, from corner to corner"
        yield MaterialTablePass(), "the materials of what rays hit"
        yield EmitterTablesPass(), "the lights that rays are sent to"
