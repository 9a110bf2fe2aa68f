"""The light that per-pixel rays have gathered, for each of the frames that share them."""

from __future__ import annotations

from collections.abc import Mapping

from ssdo_gl.effects.moving_rays import FORMATS, trace
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.environment_uniforms import MAP_IRRADIANCE, MAP_RADIANCE
from ssdo_gl.passes.far_probes import FarFieldSettings
from ssdo_gl.passes.own_lookup import GATHERED, OWN_RAYS, OwnRays
from ssdo_gl.passes.own_textures import textures_of
from ssdo_gl.passes.rays import ray_reads
from ssdo_gl.passes.surfels import BRIGHT_TABLES, cache_tables
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.environment import EnvironmentKind


class GatheredLightPass(RenderPass):
    """Writes `gathered_far` and `gathered_near`: light from beyond R and within, of every pixel.

    They are those of `OWN_RAYS` in the very frame whose pixels traced. A frame that is moved a
    little against it takes them where a pixel, or one beside it, shows the same surface. All others
    trace as many rays as pixels at contacts do.
    """

    name = "gathered_light"
    writes: Mapping[str, TextureSpec] = {name: TextureSpec(4, "f4", own=True) for name in GATHERED}

    def __init__(
        self,
        settings: FarFieldSettings,
        features: RayFeatures,
        environment: EnvironmentKind,
        stride: int,
    ) -> None:
        self.settings = settings
        self.features = features
        self.environment = environment
        self.stride = stride
        self._bright = BRIGHT_TABLES if settings.aimed_rays else ()
        self._traced = (
            *("z_vs", "normals_vs"),
            *ray_reads(features, shades=True),
            *cache_tables(features),
            *((MAP_RADIANCE, MAP_IRRADIANCE, "ray_map_cells") if environment == "map" else ()),
        )
        self.reads = (*OWN_RAYS, *self._traced, *self._bright)
        self.depends_on = ("view", "seed", "geometry", "environment")

    def execute(self, context: PassContext) -> Produced:
        """Hand on what the frame itself has traced, or look it up and trace what is missing."""
        rays, size = context.facts[OWN_RAYS[0]], context.frame.view.size
        assert isinstance(rays, OwnRays)
        if rays.shown_view == context.frame.view.key():
            made = [context.inputs[name] for name in OWN_RAYS[1:]]
        else:
            made = [make_texture(context.gl, size, *form) for form in FORMATS[:2]]
            chosen = self.settings
            trace(
                *(context, made, chosen.radius, chosen.aimed_rays, self.features),
                *(self.environment, self.stride, self._traced, textures_of(context, OWN_RAYS)),
                many=max(chosen.edge_rays, chosen.pixel_rays),
            )
        named = zip(GATHERED, made, strict=True)
        return {name: TextureWithFacts(item, rays) for name, item in named}
