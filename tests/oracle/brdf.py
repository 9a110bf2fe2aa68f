"""Float64 twin of ``shaders/lib/brdf.glsl``. Imports nothing from ssdo_gl.

Directions are unit vectors (N, 3) away from the surface, in one space with the normal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from oracle import screen_space

Array = NDArray[np.float64]

MIN_ALPHA = 1e-3
MIN_COSINE = 1e-4
TABLE_MARGIN = 0.997


@dataclass(frozen=True)
class Brdf:
    """N surfaces.

    Attributes
    ----------
    albedo : ndarray, shape (N, 3)
        Share of diffuse light that leaves again, [0, 1].
    f0 : ndarray, shape (N, 3)
        Reflectance of the microfacets at normal incidence.
    f90, roughness : ndarray, shape (N,)
        Reflectance at grazing incidence, 0: there are none; perceptual roughness.
    once : ndarray, shape (n, n), or None
        Share of even light that facets reflect once, at nodes of roughness and view. None:
        what they reflect more than once is left out.
    """

    albedo: Array
    f0: Array
    f90: Array
    roughness: Array
    once: Array | None = None

    @classmethod
    def diffuse(cls, albedo: Array) -> Brdf:
        """Return surfaces that are diffuse only."""
        count = len(albedo)
        return cls(albedo, np.zeros((count, 3)), np.zeros(count), np.ones(count))

    @classmethod
    def glossy(cls, albedo: Array, f0: Array, f90: Array, roughness: Array) -> Brdf:
        """Return surfaces with a glossy layer."""
        return cls(albedo, f0, f90, roughness)

    @property
    def alpha(self) -> Array:
        """Width of the distribution of facets."""
        return np.maximum(self.roughness**2, MIN_ALPHA)

    @property
    def is_glossy(self) -> NDArray[np.bool_]:
        """Which surfaces have a glossy layer."""
        return np.asarray(self.f90 > 0.0)

    def fresnel(self, cosine: Array) -> Array:
        """Return Schlick's reflectance, (N, 3)."""
        power = np.clip(1.0 - cosine, 0.0, 1.0)[:, None] ** 5
        return np.asarray(self.f0 + (self.f90[:, None] - self.f0) * power)

    def distribution(self, normal: Array, h: Array) -> Array:
        """Return the density of facets with the normal h, (N,)."""
        cosine = _dot(normal, h)
        sine_2 = np.sum(np.cross(normal, h) ** 2, axis=1)
        d = (self.alpha * cosine) ** 2 + sine_2
        return np.where(cosine > 0.0, self.alpha**2 / (np.pi * np.maximum(d, 1e-30) ** 2), 0.0)

    def rescattered(self, cos_out: Array) -> Array:
        """Return the lobe over what facets reflect once, (N, 3)."""
        if self.once is None:
            return np.ones((len(cos_out), 3))
        view = np.sqrt(cos_out * (1.0 + self.alpha) / (cos_out + self.alpha))
        places = [np.clip(x, 0.0, 1.0) * (len(self.once) - 1) for x in (self.roughness, view)]
        (i, j), (a, b) = zip(*((np.floor(x).astype(int), x % 1.0) for x in places), strict=True)
        i_1, j_1 = (np.minimum(k + 1, len(self.once) - 1) for k in (i, j))
        near, far = ((1.0 - b) * self.once[k, j] + b * self.once[k, j_1] for k in (i, i_1))
        more = np.maximum(TABLE_MARGIN / ((1.0 - a) * near + a * far) - 1.0, 0.0)
        return np.asarray(1.0 + self.f0 * more[:, None])

    def gloss_times_cosine(self, normal: Array, w_out: Array, w_in: Array) -> Array:
        """Return what the glossy layer alone reflects, (N, 3)."""
        cos_in, cos_out = _dot(normal, w_in), np.maximum(_dot(normal, w_out), MIN_COSINE)
        h = half_vector(normal, w_out, w_in)
        a_2 = self.alpha**2
        above = np.where(cos_in > 0.0, cos_in, 1.0)
        smith = 0.5 / (
            above * np.sqrt(a_2 + (1.0 - a_2) * cos_out**2)
            + cos_out * np.sqrt(a_2 + (1.0 - a_2) * above**2)
        )
        value = self.distribution(normal, h) * smith * above
        value = np.where((cos_in > 0.0) & self.is_glossy, value, 0.0)
        fresnel = self.fresnel(_dot(w_in, h)) * self.rescattered(cos_out)
        return np.asarray(fresnel * value[:, None])

    def times_cosine(self, normal: Array, w_out: Array, w_in: Array) -> Array:
        """Return reflected radiance per radiance and solid angle at w_in, (N, 3)."""
        h = half_vector(normal, w_out, w_in)
        passed = 1.0 - self.fresnel(_dot(w_in, h))
        diffuse = self.albedo * passed / np.pi * _cosine(normal, w_in)[:, None]
        return np.asarray(diffuse + self.gloss_times_cosine(normal, w_out, w_in))

    def gloss_chance(self, cos_out: Array) -> Array:
        """Return the chance of drawing from the glossy layer, (N,)."""
        power = (1.0 - np.minimum(cos_out, 1.0))[:, None] ** 5
        glossy = np.max(self.f0 + (self.f90[:, None] - self.f0) * power, axis=1)
        chance = glossy / np.maximum(glossy + self.albedo.max(axis=1), 1e-30)
        return np.where(self.is_glossy, np.clip(chance, 0.1, 1.0), 0.0)

    def density(self, normal: Array, w_out: Array, w_in: Array) -> Array:
        """Return the density over solid angle with which `sample` draws w_in, (N,)."""
        diffuse = _cosine(normal, w_in) / np.pi
        cos_out = np.maximum(_dot(normal, w_out), MIN_COSINE)
        a_2 = self.alpha**2
        spread = np.sqrt(a_2 + (1.0 - a_2) * cos_out**2)
        h = half_vector(normal, w_out, w_in)
        glossy = self.distribution(normal, h) / (2.0 * (cos_out + spread))
        glossy = np.where(diffuse > 0.0, glossy, 0.0)
        chance = self.gloss_chance(cos_out)
        return np.asarray((1.0 - chance) * diffuse + chance * glossy)

    def sample(self, normal: Array, w_out: Array, u: Array) -> tuple[Array, Array, Array]:
        """Return w_in, its weight and its density from points (N, 2) of the unit square."""
        frame = screen_space.frame_from_z(normal)
        chance = self.gloss_chance(np.maximum(_dot(normal, w_out), MIN_COSINE))
        draws_gloss = u[:, 0] < chance
        rest = (u[:, 0] - chance) / np.where(chance < 1.0, 1.0 - chance, 1.0)
        even = screen_space.cosine_hemisphere(np.stack([np.clip(rest, 0.0, 1.0), u[:, 1]], 1))
        share = u[:, 0] / np.where(chance > 0.0, chance, 1.0)
        local = np.einsum("nij,ni->nj", frame, w_out)
        low = local[:, 2] < MIN_COSINE
        local[low, 2] = MIN_COSINE
        local /= np.linalg.norm(local, axis=1, keepdims=True)
        h = visible_normal(local, self.alpha, np.stack([share, u[:, 1]], 1))
        mirrored = 2.0 * _dot(local, h)[:, None] * h - local
        w_in = np.einsum("nij,nj->ni", frame, np.where(draws_gloss[:, None], mirrored, even))
        density = self.density(normal, w_out, w_in)
        value = self.times_cosine(normal, w_out, w_in)
        weight = value / np.where(density > 0.0, density, 1.0)[:, None]
        weight = np.where(self.is_glossy[:, None], weight, self.albedo)
        return w_in, weight, density

    def reflectance(self) -> Array:
        """Return about the largest share of light that leaves again, (N, 3)."""
        both = np.minimum(self.albedo + np.maximum(self.f0, 0.04), 1.0)
        return np.where(self.is_glossy[:, None], both, self.albedo)

    def diffuse_radiance(self, irradiance: Array) -> Array:
        """Return the radiance that diffuse reflection makes of an irradiance, (N, 3)."""
        return np.asarray(self.albedo / np.pi * irradiance)


def half_vector(normal: Array, w_out: Array, w_in: Array) -> Array:
    """Return unit half vectors; the normal where directions cancel."""
    total = w_out + w_in
    size = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(size > 1e-6, total / np.maximum(size, 1e-30), normal)


def visible_normal(w_out: Array, alpha: Array, u: Array) -> Array:
    """Return facet normals that w_out sees, in the frame of the surface, (N, 3)."""
    stretched = w_out * np.stack([alpha, alpha, np.ones_like(alpha)], 1)
    stretched /= np.linalg.norm(stretched, axis=1, keepdims=True)
    phi = 2.0 * np.pi * u[:, 0]
    z = 1.0 - u[:, 1] * (1.0 + stretched[:, 2])
    sine = np.sqrt(np.clip(1.0 - z * z, 0.0, 1.0))
    h = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], 1) + stretched
    h = np.stack([alpha * h[:, 0], alpha * h[:, 1], np.maximum(h[:, 2], 1e-7)], 1)
    return np.asarray(h / np.linalg.norm(h, axis=1, keepdims=True))


def _dot(a: Array, b: Array) -> Array:
    return np.einsum("ni,ni->n", a, b)


def _cosine(normal: Array, w_in: Array) -> Array:
    return np.asarray(np.maximum(_dot(normal, w_in), 0.0))
