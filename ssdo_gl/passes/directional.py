"""Light through open directions: directional occlusion."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.graph.environment_uniforms import (
    MAP_IRRADIANCE,
    MAP_RADIANCE,
    environment_uniforms,
)
from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.screen_space_settings import ScreenSpaceSettings, defines, estimator_uniforms

# By `SceneContent.environment`, for `lib/environment.glsl`.
ENVIRONMENT_NUMBERS = {"none": 0, "constant": 1, "gradient": 2, "map": 3}


@dataclass(frozen=True)
class DirectionalSettings(ScreenSpaceSettings):
    """Settings of directional occlusion."""


def uniforms(settings: DirectionalSettings, frame: Frame) -> dict[str, Any]:
    """Return the uniforms of `directional.frag`."""
    return {**estimator_uniforms(settings, frame), **environment_uniforms(frame)}


class DirectionalPass(RenderPass):
    """Estimates the integral of L_in(w) V_R(w) cos(theta) dw at every receiver.

    Writes ``directional_raw``: rgb = irradiance, a = visibility. Background: 0 and 1.

    Parameters
    ----------
    settings : DirectionalSettings
    environment : str
        none, constant, gradient or map.
    has_ssdo_lights : bool
        Some light is marked ``shadow = "ssdo"``: read the light table.
    has_back_layer : bool
        Read ``z_back_vs`` to know where solids end.
    """

    def __init__(
        self,
        settings: DirectionalSettings,
        *,
        environment: str = "none",
        has_ssdo_lights: bool = False,
        has_back_layer: bool = False,
    ) -> None:
        self.name = "directional"
        self.settings = settings
        self.reads = (
            "z_vs",
            "normals_vs",
            *(("z_back_vs",) if has_back_layer else ()),
            *((MAP_RADIANCE, MAP_IRRADIANCE) if environment == "map" else ()),
        )
        self.writes = {"directional_raw": TextureSpec(4, scale=settings.resolution_scale)}
        self.depends_on = ("view", "seed", "lights", "environment")
        self._defines = {
            **defines(settings, has_back_layer),
            "ENVIRONMENT_KIND": ENVIRONMENT_NUMBERS[environment],
        }

    def settings_key(self) -> Hashable:
        """Return the settings and switches."""
        return self.settings, tuple(self._defines.items())

    def execute(self, context: PassContext) -> None:
        """Draw one triangle over the target."""
        assert context.target is not None
        draw_fullscreen(
            context.gl,
            context.shaders.fullscreen("directional.frag", self._defines),
            context.target,
            uniforms(self.settings, context.frame),
            {f"t_{name}": context.inputs[name] for name in self.reads},
        )
