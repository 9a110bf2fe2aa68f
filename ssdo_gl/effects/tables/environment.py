"""Uploads an environment that is an image: its radiance, and the irradiance it gives."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import moderngl
import numpy as np

from ssdo_gl import math3d
from ssdo_gl.effects.effect import Effect, ReasonedPass
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.environment import MapEnvironment, irradiance, radiance_image

# Cells along the octahedral map of irradiance, an even number: they interpolate it to 6e-4.
CELLS = 64


class EnvironmentPass(RenderPass):
    """Writes `environment` (lat-long) and `environment_irradiance` (octahedral), RGBA.

    Both in world orientation, for ``lib/environment.glsl``. Unlike other textures,
    row 0 of `environment` is its top, +y. Constant and gradient environments are
    evaluated from uniforms and need neither.
    """

    name = "environment"
    writes: Mapping[str, TextureSpec] = {
        "environment": TextureSpec(4, "f4", own=True),
        "environment_irradiance": TextureSpec(4, "f4", own=True),
    }
    depends_on = ("environment",)

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        """Return both maps as new textures."""
        environment = context.frame.scene.environment
        assert environment is not None
        normals = octahedral_nodes(CELLS)
        return {
            "environment": _upload(context.gl, radiance_image(environment)),
            "environment_irradiance": _upload(context.gl, irradiance(environment, normals)),
        }


def octahedral_nodes(cells: int) -> FloatArray:
    """Return unit normals at the nodes of a grid over the octahedral map.

    Returns
    -------
    ndarray, shape (n, n, 3)
        n = `cells` + 1, `cells` even; the first index runs along +y of the map, the second
        along +x, both from -1 to 1. See ``shaders/lib/environment.glsl``.
    """
    half = cells // 2
    place = np.arange(-half, half + 1) / half
    x, y = np.meshgrid(place, place)
    z = 1.0 - np.abs(x) - np.abs(y)
    fold = np.maximum(-z, 0.0)
    x, y = x - np.copysign(fold, x), y - np.copysign(fold, y)
    return math3d.normalized(np.stack([x, y, z], axis=-1))


def _upload(gl: moderngl.Context, rgb: FloatArray) -> moderngl.Texture:
    height, width, _ = rgb.shape
    # Four channels: three are not guaranteed to be a renderable, hence fast, format.
    rgba = np.concatenate([rgb, np.ones((height, width, 1))], axis=-1)
    return make_texture(gl, (width, height), 4, "f4", rgba)


class EnvironmentImage(Effect):
    """The image of the environment, for whoever looks it up."""

    name = "environment"

    def is_asked(self, request: Request) -> bool:
        """Return whether the scene has an environment."""
        return request.scene.environment is not None

    def need(self, request: Request) -> Decision:
        """Run where it is an image that is not the same everywhere."""
        is_map = isinstance(request.scene.environment, MapEnvironment)
        reason = "the sky is an image" if is_map else "the sky is given by few colours"
        return Decision("sky", is_map, reason, ("environment",))

    def passes(self, request: Request) -> Iterator[ReasonedPass]:
        """Yield the one pass."""
        yield EnvironmentPass(), "the image of the environment, and its irradiance"
