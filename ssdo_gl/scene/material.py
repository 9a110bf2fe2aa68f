"""Diffuse materials and the images they refer to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Color = tuple[float, float, float]
Wrap = Literal["repeat", "clamp"]


@dataclass(frozen=True, eq=False)
class Texture:
    """An image used by a material.

    Attributes
    ----------
    pixels : ndarray, shape (height, width, 4), uint8 or float32
        Row 0 at the top. uint8 colour is sRGB-encoded, alpha linear; float32 is
        scene-linear.
    name : str
    wrap : pair of "repeat" or "clamp"
        What lies beyond 0..1 along u and v. Mirrored images are stored with their mirror
        image, as `ssdo_gl.scene.images.doubled` makes them.
    nearest : bool
        Whether magnified texels stay squares of one colour.
    """

    pixels: NDArray[np.uint8] | NDArray[np.float32]
    name: str = ""
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")
    nearest: bool = False


@dataclass(frozen=True, eq=False)
class Material:
    """A Lambertian surface, BRDF = albedo / pi, two-sided unless it says otherwise.

    Attributes
    ----------
    albedo : Color
        Scene-linear Rec.709, [0, 1]; multiplies texture and vertex colour.
    emission : Color
        Radiance, W sr^-1 m^-2, >= 0; multiplies the emission texture.
    albedo_texture, emission_texture : Texture or None
    alpha_cutoff : float or None
        Fragments whose alpha is below it are cut out; None keeps all of them.
    alpha : float
        Factor of the texture's alpha, [0, 1].
    single_sided : bool
        Whether what looks at the back, camera, light or ray, passes through the surface.
    two_sided_emission : bool
        Whether the back of the surface emits too. The front is the side that the
        counter-clockwise winding faces.
    """

    name: str = ""
    albedo: Color = (0.8, 0.8, 0.8)
    emission: Color = (0.0, 0.0, 0.0)
    albedo_texture: Texture | None = None
    emission_texture: Texture | None = None
    alpha_cutoff: float | None = None
    alpha: float = 1.0
    two_sided_emission: bool = False
    single_sided: bool = False

    @property
    def emits(self) -> bool:
        """Whether any component of the emission factor is above zero."""
        return max(self.emission) > 0.0
