"""Tables that glossy surfaces are looked up in."""

from __future__ import annotations

from collections.abc import Iterator

from ssdo_gl.effects.decisions import Decision
from ssdo_gl.effects.effect import Effect, ReasonedPass
from ssdo_gl.effects.request import Request
from ssdo_gl.passes.environment_uniforms import environment_kind
from ssdo_gl.passes.lobe_tables import EnvironmentLobesPass, ReflectanceTablePass


class GlossTables(Effect):
    """Reflectance of lobes, and the environment blurred by them."""

    name = "gloss_tables"

    def is_asked(self, request: Request) -> bool:
        return request.is_glossy

    def need(self, request: Request) -> Decision:
        """Run wherever anything is glossy."""
        passes = ("reflectance_table", "environment_lobes")
        return Decision("tables of gloss", True, "some surfaces are glossy", passes)

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield the uploads; those that nothing reads are dropped."""
        yield ReflectanceTablePass(), "how much each roughness reflects"
        if environment_kind(request.scene.environment) > 1:
            yield EnvironmentLobesPass(), "the environment as rough surfaces reflect it"
