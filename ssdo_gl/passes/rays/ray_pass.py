"""What all passes that add up rays of every pixel share."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.passes.brdf_wiring import brdf_wiring
from ssdo_gl.passes.environment_uniforms import (
    MAP_RADIANCE,
    environment_defines,
    environment_uniforms,
)
from ssdo_gl.passes.rays.accumulate import Schedule, SumOutput, Sums, accumulate
from ssdo_gl.passes.rays.ray_libraries import EMITTER_TABLES, ray_defines, ray_reads, ray_uniforms
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.environment import EnvironmentKind

# Of more lights than MOST_ALL each sample asks MOST_ASKED by chance: rays/emitters.glsl.
MOST_ALL, MOST_ASKED = 1536, 256


def asked_lights(count: int) -> int:
    """Return to how many of `count` lights a sample sends a ray."""
    return MOST_ASKED if count > MOST_ALL else count


class RayPass(RenderPass):
    """Draws ``effects/<name>.frag`` until `schedule` is fulfilled, and writes the mean.

    Parameters
    ----------
    settings : dataclass
        The pass' own.
    features : RayFeatures
        Of the scene: `RayFeatures.of`.
    environment : str
        Kind of the scene's.

    Attributes
    ----------
    outputs : sequence of SumOutput
        In the order of ``writes``.
    label : str
        What progress calls it.
    surface : tuple of str
        What it reads of the surface that a pixel shows.
    gathers_light : bool
        Whether rays bring light, of what they hit or are sent to, or visibility alone.
    reflects : bool
        Whether the surface that a pixel shows, if it is glossy, reflects what they bring.
    """

    outputs: Sequence[SumOutput]
    label: ClassVar[str]
    surface: ClassVar[tuple[str, ...]] = ("z_vs", "normals_vs")
    gathers_light: ClassVar[bool] = True
    reflects: ClassVar[bool] = False

    def __init__(
        self, settings: Any, features: RayFeatures, environment: EnvironmentKind = "none"
    ) -> None:
        self.settings = settings
        self.features = features
        self.environment = environment
        gloss = tuple(brdf_wiring(True).values()) if self.reflects and features.glossy else ()
        self.reads = (
            *self.surface,
            *(name for name in gloss if name not in self.surface),
            *ray_reads(features, shades=self.gathers_light),
            *(EMITTER_TABLES if self.gathers_light else ()),
            *((MAP_RADIANCE,) if environment == "map" else ()),
        )
        self.statistics: Mapping[str, Any] = {}
        self._sums: Sums | None = None

    @abstractmethod
    def schedule(self, context: PassContext) -> Schedule:
        """Return how many samples are taken, and what each costs."""

    def defines(self, context: PassContext) -> dict[str, int]:
        """Return the defines of the shader."""
        sky = environment_defines(self.environment) if self.gathers_light else {}
        return {**ray_defines(context, self.features), **sky}

    def uniforms(self, context: PassContext) -> dict[str, object]:
        """Return the uniforms of the shader."""
        sky = environment_uniforms(context.frame) if self.gathers_light else {}
        return {**ray_uniforms(context), **sky}

    def execute(self, context: PassContext) -> None:
        assert context.target is not None
        size = context.target.size
        if self._sums is None or self._sums.size != size:
            self._sums = Sums(context.gl, size, len(self.outputs))
        self.statistics = accumulate(
            context,
            context.shaders.fullscreen(f"effects/{self.name}.frag", self.defines(context)),
            self.uniforms(context),
            {f"t_{name}": context.inputs[name] for name in self.reads},
            self._sums,
            self.outputs,
            self.schedule(context),
            self.label,
        )
