"""Tables that glossy surfaces are looked up in: reflectance, and the environment by lobes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.effects.effect import Effect, ReasonedPass
from ssdo_gl.effects.request import Decision, Request
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.environment import kind_of, lobe_levels

# Nodes along the view and roughness, both from 0 to 1.
TABLE_SIZE = 32
# `shaders/lib/brdf.glsl` has no narrower lobe, and looks no flatter.
_MIN_ALPHA, _MIN_COSINE = 1e-3, 1e-4
# Of heights and azimuths of microfacet normals.
_HEIGHTS, _AZIMUTHS = 40, 16


@cache
def reflectance_table() -> NDArray[np.float32]:
    """Return how much of evenly spread light facets reflect once, (32, 32, 3).

    Row i is roughness i / 31. The reflectance is f0 times the first plus f90 times the second
    number (Karis 2013); in column j towards the cosine j / 31, which Fresnel's changes follow
    evenly. The third is their sum towards `cosine_of_node` of j / 31, which it follows evenly:
    between nodes it is good to 2.5e-3, the others from a roughness of 0.1 on to 2e-3 at 5 degrees
    above the horizon.
    """
    place, weight = np.polynomial.legendre.leggauss(_HEIGHTS)
    t, t_weight = 0.5 * (place + 1.0), 0.5 * weight
    # Dense at both ends, where facets mirror to the horizon.
    u, u_weight = t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t) * t_weight
    phi = (np.arange(_AZIMUTHS) + 0.5) * np.pi / _AZIMUTHS
    node = np.linspace(0.0, 1.0, TABLE_SIZE)
    rows = []
    for alpha in np.maximum(node**2, _MIN_ALPHA):
        cosines = np.concatenate([np.maximum(node, 1e-3), cosine_of_node(node, alpha)])
        shares, warped = np.split(_reflectance(cosines, alpha, u, u_weight, phi), 2)
        rows.append(np.column_stack([shares, warped.sum(axis=1)]))
    return np.stack(rows).astype(np.float32)


def cosine_of_node(place: FloatArray, alpha: float) -> FloatArray:
    """Return the cosines of views at places from 0, the horizon, to 1, the normal.

    place^2 = cosine (1 + alpha) / (cosine + alpha): facets hide each other most where the
    cosine is about alpha, which so is half-way for all.
    """
    square = place**2
    return np.clip(alpha * square / (1.0 + alpha - square), _MIN_COSINE, 1.0)


def _reflectance(
    cos_out: FloatArray, alpha: float, u: FloatArray, u_weight: FloatArray, phi: FloatArray
) -> FloatArray:
    """Return both numbers for views at each cosine: means over the facets that they see.

    Visible normals are drawn as by `sampled_visible_normal` of the shader; each reflects
    Fresnel's share of what masking leaves, G2 / G1.
    """
    cos_out = cos_out[:, None, None]
    sin_out = np.sqrt(1.0 - cos_out**2)
    size = np.hypot(alpha * sin_out, cos_out)
    z = 1.0 - u[:, None] * (1.0 + cos_out / size)
    sine = np.sqrt(np.clip(1.0 - z * z, 0.0, 1.0))
    h = (
        alpha * (sine * np.cos(phi) + alpha * sin_out / size),
        alpha * sine * np.sin(phi),
        z + cos_out / size,
    )
    h_size = np.sqrt(h[0] ** 2 + h[1] ** 2 + h[2] ** 2)
    v_h = (sin_out * h[0] + cos_out * h[2]) / h_size
    cos_in = 2.0 * v_h * h[2] / h_size - cos_out
    is_up = cos_in > 0.0
    cos_in = np.where(is_up, cos_in, 1.0)
    slope_out, slope_in = (np.sqrt(alpha**2 + (1.0 - alpha**2) * c**2) for c in (cos_out, cos_in))
    share = (cos_out + slope_out) * cos_in / (cos_in * slope_out + cos_out * slope_in)
    share = np.where(is_up, share, 0.0) * u_weight[:, None]
    grazing = np.clip(1.0 - v_h, 0.0, 1.0) ** 5
    return np.stack(
        [((1.0 - grazing) * share).mean(axis=2).sum(axis=1), (grazing * share).mean(2).sum(1)],
        axis=-1,
    )


class ReflectanceTablePass(RenderPass):
    """Uploads `reflectance`: `reflectance_table`, linearly interpolated."""

    name = "reflectance_table"
    writes: Mapping[str, TextureSpec] = {"reflectance": TextureSpec(3, "f4", own=True)}
    depends_on = ()

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        size = (TABLE_SIZE, TABLE_SIZE)
        texture = make_texture(context.gl, size, 3, "f4", reflectance_table())
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
        if kind_of(request.scene.environment) in ("gradient", "map"):
            yield EnvironmentLobesPass(), "the environment as rough surfaces reflect it"
