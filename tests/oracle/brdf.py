"""Float64 twin of ``shaders/lib/brdf.glsl``. Imports nothing from ssdo_gl.

Directions are unit vectors (N, 3) away from the surface, in one space with the normal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from oracle import screen_space

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Brdf:
    """N surfaces.

    Attributes
    ----------
    albedo : ndarray, shape (N, 3)
        Share of diffuse light that leaves again, [0, 1].
    """

    albedo: Array

    def times_cosine(self, normal: Array, w_out: Array, w_in: Array) -> Array:
        """Return reflected radiance per radiance and solid angle at w_in, (N, 3)."""
        return np.asarray(self.albedo / np.pi * _cosine(normal, w_in)[:, None])

    def density(self, normal: Array, w_out: Array, w_in: Array) -> Array:
        """Return the density over solid angle with which `sample` draws w_in, (N,)."""
        return np.asarray(_cosine(normal, w_in) / np.pi)

    def sample(self, normal: Array, w_out: Array, u: Array) -> tuple[Array, Array, Array]:
        """Return w_in, its weight and its density from points (N, 2) of the unit square."""
        local = screen_space.cosine_hemisphere(u)
        w_in = np.einsum("nij,nj->ni", screen_space.frame_from_z(normal), local)
        return w_in, self.albedo, self.density(normal, w_out, w_in)

    def reflectance(self) -> Array:
        """Return about the largest share of light that leaves again, (N, 3)."""
        return self.albedo

    def diffuse_radiance(self, irradiance: Array) -> Array:
        """Return the radiance that diffuse reflection makes of an irradiance, (N, 3)."""
        return np.asarray(self.albedo / np.pi * irradiance)


def _cosine(normal: Array, w_in: Array) -> Array:
    return np.asarray(np.maximum(np.einsum("ni,ni->n", normal, w_in), 0.0))
