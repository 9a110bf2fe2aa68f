"""The surface of glTF 2.0's appendix B as a BSDF of Mitsuba 3, written apart from ours.

Mitsuba's own ``principled`` differs: exact Fresnel, Burley's diffuse part, separable Smith.
For scalar variants: one surface at a time.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Ours is no narrower, either.
MIN_ALPHA = 1e-3


# Views that what facets reflect once is worked out for, by the root of their cosine.
VIEWS = 128


def reflected_once(alpha: float) -> NDArray[np.float64]:
    """Return the share of even light that facets reflect at once, (VIEWS,).

    By normals that are drawn as D cos, with tan^2 = alpha^2 u / (1 - u) for even u.
    """
    cos_o = np.maximum(np.linspace(0.0, 1.0, VIEWS) ** 2, 1e-4)[:, None, None]
    u = (np.arange(512) + 0.5) / 512
    h_z = 1.0 / np.sqrt(1.0 + alpha**2 * u / (1.0 - u))[:, None]
    h_x = np.sqrt(1.0 - h_z**2) * np.cos((np.arange(64) + 0.5) * np.pi / 64)
    o_h = np.maximum(np.sqrt(1.0 - cos_o**2) * h_x + cos_o * h_z, 0.0)
    cos_i = np.maximum(2.0 * o_h * h_z - cos_o, 0.0)
    slopes = (np.sqrt(alpha**2 + (1.0 - alpha**2) * c * c) for c in (cos_i, cos_o))
    below = cos_o * next(slopes) + cos_i * next(slopes)
    return np.asarray((2.0 * o_h * cos_i / (h_z * np.maximum(below, 1e-30))).mean(axis=(1, 2)))


def register(mi: ModuleType) -> None:
    """Make ``gltf`` a kind of BSDF of the variant in force."""
    dr = __import__("drjit")

    class Gltf(mi.BSDF):  # type: ignore[name-defined, misc]
        """Parameters ``base_color`` (rgb), ``metallic``, ``roughness``, ``f0``."""

        def __init__(self, props: Any) -> None:
            mi.BSDF.__init__(self, props)
            base = mi.Color3f(props["base_color"])
            metallic = float(props["metallic"])
            self.alpha = max(float(props["roughness"]) ** 2, MIN_ALPHA)
            self.once = reflected_once(self.alpha).tolist()
            self.diffuse = base * (1.0 - metallic)
            self.f0 = dr.lerp(mi.Color3f(float(props["f0"])), base, metallic)
            self.m_components = [mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide]
            self.m_flags = self.m_components[0]
            shiny, dull = (max(float(c[i]) for i in range(3)) for c in (self.f0, self.diffuse))
            self.chance = shiny / (shiny + dull)

        def _terms(self, si: Any, wo: Any) -> tuple[Any, Any, Any, Any]:
            """Return half vector, distribution, visibility (G over 4 cos cos) and Fresnel."""
            h = dr.normalize(si.wi + wo)
            a_2 = self.alpha**2
            d = a_2 / (dr.pi * dr.square(dr.square(h.z) * (a_2 - 1.0) + 1.0))
            c_i, c_o = si.wi.z, wo.z
            below = c_o * dr.sqrt(a_2 + (1.0 - a_2) * c_i * c_i)
            below += c_i * dr.sqrt(a_2 + (1.0 - a_2) * c_o * c_o)
            power = (1.0 - dr.clip(dr.dot(wo, h), 0.0, 1.0)) ** 5
            return h, d, 0.5 / dr.maximum(below, 1e-30), self.f0 + (1.0 - self.f0) * power

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            is_up = (si.wi.z > 0.0) & (wo.z > 0.0)
            _, d, v, f = self._terms(si, wo)
            # Light that facets scatter on: Turquin 2019.
            place = dr.sqrt(dr.clip(si.wi.z, 0.0, 1.0)) * (VIEWS - 1)
            node = min(int(place), VIEWS - 2)
            once = dr.lerp(self.once[node], self.once[node + 1], place - node)
            more = 1.0 + self.f0 * (1.0 / once - 1.0)
            value = ((1.0 - f) * self.diffuse / dr.pi + more * f * d * v) * wo.z
            return dr.select(is_up & active, value, 0.0)

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            is_up = (si.wi.z > 0.0) & (wo.z > 0.0)
            h, d, _, _ = self._terms(si, wo)
            glossy = d * h.z / dr.maximum(4.0 * dr.dot(wo, h), 1e-30)
            density = dr.lerp(wo.z / dr.pi, glossy, self.chance)
            return dr.select(is_up & active, density, 0.0)

        def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> Any:
            even = mi.warp.square_to_cosine_hemisphere(sample2)
            tan_2 = self.alpha**2 * sample2.x / (1.0 - sample2.x)
            cosine = dr.rsqrt(1.0 + tan_2)
            sine = dr.sqrt(dr.maximum(1.0 - cosine * cosine, 0.0))
            phi = 2.0 * dr.pi * sample2.y
            h = mi.Vector3f(sine * dr.cos(phi), sine * dr.sin(phi), cosine)
            mirrored = 2.0 * dr.dot(si.wi, h) * h - si.wi
            bs = mi.BSDFSample3f()
            bs.wo = dr.select(sample1 < self.chance, mirrored, even)
            bs.pdf = self.pdf(ctx, si, bs.wo, active)
            bs.eta = 1.0
            bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
            bs.sampled_component = 0
            value = self.eval(ctx, si, bs.wo, active) / dr.maximum(bs.pdf, 1e-30)
            return bs, dr.select(active & (bs.pdf > 0.0), value, 0.0)

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

    mi.register_bsdf("gltf", Gltf)
