"""Tables that glossy surfaces are looked up in: reflectance, and the environment by lobes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.effects.decisions import Decision
from ssdo_gl.effects.effect import Effect, ReasonedPass
from ssdo_gl.effects.request import Request
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.math3d import FloatArray
from ssdo_gl.passes.environment_uniforms import environment_kind
from ssdo_gl.scene.environment import lobe_levels

# Nodes along cosine and roughness, both from 0 to 1. The reflectance of roughness 0.1 to 1
# is interpolated to 1e-3 at 5 degrees above the horizon.
TABLE_SIZE = 32
# Of heights and azimuths of microfacet normals: good to 1e-3 from roughness and cosine 0.1 on.
_HEIGHTS, _AZIMUTHS = 96, 16


def reflectance_table() -> NDArray[np.float32]:
    """Return how much of evenly spread light the glossy layer reflects, (32, 32, 2).

    Row i is roughness i / 31, column j the cosine of the view j / 31. The reflectance is f0
    times the first plus f90 times the second number (Karis 2013).
    """
    node = np.linspace(0.0, 1.0, TABLE_SIZE)
    # At the ends themselves there is 0 / 0.
    cosine, roughness = np.maximum(node, 1e-3), np.maximum(node, 0.03)
    place, weight = np.polynomial.legendre.leggauss(_HEIGHTS)
    u, u_weight = 0.5 * (place + 1.0), 0.5 * weight
    phi = (np.arange(_AZIMUTHS) + 0.5) * np.pi / _AZIMUTHS
    rows = [_reflectance(cosine, r**2, u, u_weight, phi) for r in roughness]
    return np.stack(rows).astype(np.float32)


def _reflectance(
    cos_out: FloatArray, alpha: float, u: FloatArray, u_weight: FloatArray, phi: FloatArray
) -> FloatArray:
    """Return both numbers for views at each cosine: an integral over normals of facets.

    Normals drawn as D cos are at tan^2 = alpha^2 u / (1 - u) for even u.
    """
    cos_out = cos_out[:, None, None]
    tan_2 = alpha**2 * u / (1.0 - u)
    h_z = (1.0 / np.sqrt(1.0 + tan_2))[:, None]
    h_x = np.sqrt(1.0 - h_z**2) * np.cos(phi)
    sin_out = np.sqrt(1.0 - cos_out**2)
    v_h = np.maximum(sin_out * h_x + cos_out * h_z, 0.0)
    cos_in = 2.0 * v_h * h_z - cos_out
    is_up = cos_in > 0.0
    cos_in = np.where(is_up, cos_in, 1.0)
    a_2 = alpha**2
    smith = 0.5 / (
        cos_in * np.sqrt(a_2 + (1.0 - a_2) * cos_out**2)
        + cos_out * np.sqrt(a_2 + (1.0 - a_2) * cos_in**2)
    )
    # D cos_h over the density of the light's direction leaves 4 (v.h) / cos_h.
    share = np.where(is_up, smith * 4.0 * v_h * cos_in / h_z, 0.0) * u_weight[:, None]
    grazing = (1.0 - v_h) ** 5
    return np.stack(
        [((1.0 - grazing) * share).mean(axis=2).sum(axis=1), (grazing * share).mean(2).sum(1)],
        axis=-1,
    )


class ReflectanceTablePass(RenderPass):
    """Uploads `reflectance`: `reflectance_table`, linearly interpolated."""

    name = "reflectance_table"
    writes: Mapping[str, TextureSpec] = {"reflectance": TextureSpec(2, "f4", own=True)}
    depends_on = ()

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        size = (TABLE_SIZE, TABLE_SIZE)
        texture = make_texture(context.gl, size, 2, "f4", reflectance_table())
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        return {"reflectance": texture}


class EnvironmentLobesPass(RenderPass):
    """Uploads `environment_lobes`: `lobe_levels` as the mip levels of a lat-long image.

    As in `environment`, row 0 is the top, +y.
    """

    name = "environment_lobes"
    writes: Mapping[str, TextureSpec] = {"environment_lobes": TextureSpec(4, "f4", own=True)}
    depends_on = ("environment",)

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        environment = context.frame.scene.environment
        assert environment is not None
        levels = lobe_levels(environment)
        height, width, _ = levels[0].shape
        texture = context.gl.texture((width, height), 4, dtype="f4")
        texture.build_mipmaps(0, len(levels) - 1)
        for number, level in enumerate(levels):
            texture.write(np.ascontiguousarray(level).tobytes(), level=number)
        texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
        texture.repeat_x, texture.repeat_y = True, False
        return {"environment_lobes": texture}


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
