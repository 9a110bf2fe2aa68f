"""G-buffers of planes and spheres, cast in float64. Imports nothing from ssdo_gl.

View space: camera at the origin, looking along -z. Rows run from the bottom up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from oracle.screen_space import Picture

Array = NDArray[np.float64]
# Steps that encode [-1, 1] in 16-bit unorm channels, so that 0 is one of them.
_HALF_RANGE = 32767.0


@dataclass(frozen=True)
class Plane:
    """Points p with (p - point) . normal = 0; seen from both sides, no thickness."""

    point: ArrayLike
    normal: ArrayLike

    def hits(self, rays: Array) -> tuple[Array, Array, Array | None]:
        """Return depth (inf where missed), unit normals, depth of the back face."""
        n = np.asarray(self.normal, np.float64)
        n = n / np.linalg.norm(n)
        with np.errstate(divide="ignore"):
            z = (np.asarray(self.point, np.float64) @ n) / (rays @ n)
        z = np.where(np.isfinite(z) & (z > 0.0), z, np.inf)
        facing = np.where((rays @ n)[..., None] <= 0.0, n, -n)
        return z, facing, None


@dataclass(frozen=True)
class Sphere:
    """A solid ball."""

    center: ArrayLike
    radius: float

    def hits(self, rays: Array) -> tuple[Array, Array, Array | None]:
        """Return depth (inf where missed), unit normals, depth of the back face."""
        c = np.asarray(self.center, np.float64)
        a, b = (rays * rays).sum(-1), rays @ c
        root = np.sqrt(np.maximum(b * b - a * (c @ c - self.radius**2), 0.0))
        hit = (b * b - a * (c @ c - self.radius**2) > 0.0) & (b > 0.0)
        z = np.where(hit, (b - root) / a, np.inf)
        normal = (rays * np.where(hit, z, 1.0)[..., None] - c) / self.radius
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        return z, normal, np.where(hit, (b + root) / a, np.inf)


Surface = Plane | Sphere


def view_rays(size: tuple[int, int], tan_half_fov: tuple[float, float]) -> Array:
    """Return (h, w, 3) rays through pixel centres, scaled to depth 1."""
    x = (np.arange(size[0]) + 0.5) / size[0] * 2.0 - 1.0
    y = (np.arange(size[1]) + 0.5) / size[1] * 2.0 - 1.0
    grid = np.stack(np.meshgrid(x * tan_half_fov[0], y * tan_half_fov[1]), -1)
    return np.concatenate([grid, -np.ones((*grid.shape[:2], 1))], -1)


def cast(
    surfaces: Sequence[Surface],
    size: tuple[int, int],
    tan_half_fov: tuple[float, float],
    near: float = 0.01,
) -> Picture:
    """Return the G-buffer of the nearest surfaces; depth as float32 would hold it.

    `z_back` is None where no surface is solid.
    """
    rays = view_rays(size, tan_half_fov)
    z = np.full(rays.shape[:2], np.inf)
    back = np.full(rays.shape[:2], np.inf)
    normal = np.zeros(rays.shape)
    for surface in surfaces:
        depth, n, end = surface.hits(rays)
        normal = np.where((depth < z)[..., None], n, normal)
        z = np.minimum(z, depth)
        if end is not None:
            back = np.minimum(back, end)
    z = np.where(np.isfinite(z), z, 0.0).astype(np.float32).astype(np.float64)
    normal = np.where(z[..., None] > 0.0, normal, [0.0, 0.0, 1.0])
    stored = oct_decode(oct_encode(normal))
    solid = any(isinstance(surface, Sphere) for surface in surfaces)
    z_back = np.where(np.isfinite(back), back, 0.0).astype(np.float32).astype(np.float64)
    return Picture(z, stored, stored, tan_half_fov, near, z_back if solid else None)


def oct_encode(n: Array) -> NDArray[np.uint16]:
    """Return octahedral 16-bit codes (..., 2) of unit vectors (..., 3)."""
    p = n / np.abs(n).sum(-1, keepdims=True)
    sign = np.where(p[..., :2] < 0.0, -1.0, 1.0)
    folded = np.where(p[..., 2:] < 0.0, (1.0 - np.abs(p[..., 1::-1])) * sign, p[..., :2])
    return np.rint((folded + 1.0) * _HALF_RANGE).astype(np.uint16)


def oct_decode(code: NDArray[np.uint16]) -> Array:
    """Return unit vectors (..., 3) of octahedral codes (..., 2)."""
    p = code.astype(np.float64) / _HALF_RANGE - 1.0
    n = np.concatenate([p, 1.0 - np.abs(p).sum(-1, keepdims=True)], -1)
    t = np.maximum(-n[..., 2:], 0.0)
    n[..., :2] -= t * np.where(n[..., :2] < 0.0, -1.0, 1.0)
    return np.asarray(n / np.linalg.norm(n, axis=-1, keepdims=True))


def textures(picture: Picture) -> dict[str, NDArray[np.float64]]:
    """Return ``z_vs``, ``normals_vs`` (and ``z_back_vs``), row 0 at the top."""
    codes = np.concatenate([oct_encode(picture.shading), oct_encode(picture.geometric)], -1)
    images = {"z_vs": picture.z[..., None], "normals_vs": codes / 65535.0}
    if picture.z_back is not None:
        images["z_back_vs"] = picture.z_back[..., None]
    return {name: image[::-1] for name, image in images.items()}
