"""Materials and the images they refer to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import product
from numbers import Real
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.color import linear_from_srgb
from ssdo_gl.scene.numbers import hold_numbers, light_numbers
from ssdo_gl.settings.fields import SettingError, shown
from ssdo_gl.settings.settings import MAX_SIZE_PX
from ssdo_gl.wording import chosen_fields, described

Color = tuple[float, float, float]
Wrap = Literal["repeat", "clamp"]
_WRAPS = tuple(product(get_args(Wrap), repeat=2))


@dataclass(frozen=True, eq=False)
class Texture:
    """An image used by a material.

    Attributes
    ----------
    pixels : ndarray, shape (height, width, 4), uint8 or float32
        Row 0 at the top. uint8 colour is sRGB-encoded, alpha linear; floats are
        scene-linear, and kept as float32. NaN and infinity become 0.
    wrap : pair of "repeat" or "clamp"
        What lies beyond 0..1 along u and v. Mirrored images are stored with their mirror
        image, as `ssdo_gl.scene.files.images.doubled` makes them.
    nearest : bool
        Whether magnified texels stay squares of one colour.
    is_data : bool
        Whether uint8 values are numbers as they stand, not sRGB colour.
    """

    pixels: NDArray[np.uint8] | NDArray[np.float32]
    name: str = ""
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")
    nearest: bool = False
    is_data: bool = False

    def __post_init__(self) -> None:
        pixels = self.pixels
        if not isinstance(pixels, np.ndarray):
            raise SettingError(f"pixels = {shown(pixels)}: expected an array (height, width, 4)")
        got = f"pixels: got {pixels.dtype} of shape {pixels.shape}"
        if (
            pixels.shape[2:] != (4,)
            or not 1 <= min(pixels.shape) <= max(pixels.shape) <= MAX_SIZE_PX
        ):
            raise SettingError(f"{got}: expected (height, width, 4), each side 1 to {MAX_SIZE_PX}")
        if pixels.dtype != np.uint8:
            if pixels.dtype.kind != "f":
                raise SettingError(f"{got}: expected uint8 or floats")
            with np.errstate(over="ignore"):
                pixels = pixels.astype(np.float32)
            pixels[~np.isfinite(pixels)] = 0.0
            object.__setattr__(self, "pixels", pixels)
        if self.wrap not in _WRAPS:
            raise SettingError(f"wrap = {shown(self.wrap)}: expected a pair of 'repeat' or 'clamp'")

    @cached_property
    def means(self) -> tuple[float, ...]:
        """Mean of each channel over all pixels, [0, 1] for uint8; it is asked for every plan."""
        full = 255.0 if self.pixels.dtype == np.uint8 else 1.0
        return tuple(float(self.pixels[:, :, i].mean()) / full for i in range(4))

    def __repr__(self) -> str:
        height, width = self.pixels.shape[:2]
        return described(self, repr(self.name) if self.name else "", f"{width}x{height}")


@dataclass(frozen=True, eq=False)
class Material:
    """A surface as glTF 2.0 describes it, two-sided unless it says otherwise.

    Without `specular` and `metallic` it is Lambertian, BRDF = albedo / pi. With them it is
    the metallic-roughness BRDF of appendix B of glTF 2.0, with ``KHR_materials_ior`` and
    ``KHR_materials_specular``.

    Attributes
    ----------
    albedo : Color
        Base colour, scene-linear Rec.709, [0, 1]; multiplies texture and vertex colour.
    metallic : float
        Share of metal, whose base colour is its reflectance at normal incidence, [0, 1].
    roughness : float
        Perceptual, [0, 1]: the width of the GGX distribution is its square.
    specular : float
        Strength of a dielectric's reflection, [0, 1]; 0: none.
    specular_color : Color
        Multiplies a dielectric's reflectance at normal incidence.
    ior : float
        Index of refraction of dielectrics, >= 1; 1.5 reflects 4 % at normal incidence. 0 stands
        for infinity, which reflects all.
    metallic_roughness_texture : Texture or None
        Multiplies roughness by its green and metallic by its blue channel.
    specular_texture, specular_color_texture : Texture or None
        Multiply `specular` by alpha and `specular_color` by rgb.
    normal_texture : Texture or None
        Tangent-space normals for shading; its x and y are scaled by `normal_scale`.
    occlusion_texture : Texture or None
        Red: baked visibility of the environment, of which `occlusion_strength` counts.
    is_unlit : bool
        Shows its base colour whatever the light; reflects none.
    blends : bool
        Alpha is coverage: what lies behind shows through.
    has_clear_vertices : bool
        Vertices that it is drawn on have an alpha below 1; a scene file or model sets it.
    second_uvs : frozenset of str
        Names of the textures, ``normal`` for `normal_texture`, that take the mesh's second
        coordinates where it has any.
    emission : Color
        Radiance, W sr^-1 m^-2, >= 0; multiplies the emission texture.
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
    metallic: float = 0.0
    roughness: float = 1.0
    specular: float = 0.0
    specular_color: Color = (1.0, 1.0, 1.0)
    ior: float = 1.5
    metallic_roughness_texture: Texture | None = None
    specular_texture: Texture | None = None
    specular_color_texture: Texture | None = None
    normal_texture: Texture | None = None
    normal_scale: float = 1.0
    occlusion_texture: Texture | None = None
    occlusion_strength: float = 1.0
    is_unlit: bool = False
    blends: bool = False
    has_clear_vertices: bool = False
    second_uvs: frozenset[str] = frozenset()
    alpha_cutoff: float | None = None
    alpha: float = 1.0
    two_sided_emission: bool = False
    single_sided: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):  # a colour, most often
            raise SettingError(f"name = {shown(self.name)}: expected text; colours have names")
        for name in ("albedo", "emission", "specular_color"):
            object.__setattr__(self, name, light_numbers(name, getattr(self, name)))
        # Beyond 1, light that bounces would grow without end.
        if max(self.albedo) > 1.0:
            raise SettingError(f"albedo = {self.albedo}: expected numbers from 0 to 1")
        for name in ("metallic", "roughness", "specular", "alpha", "occlusion_strength"):
            share = getattr(self, name)
            if not (isinstance(share, Real) and 0.0 <= float(share) <= 1.0):
                raise SettingError(f"{name} = {shown(share)}: expected a number from 0 to 1")
            hold_numbers(self, name)
        hold_numbers(self, "normal_scale", "ior")
        if not (self.ior == 0.0 or self.ior >= 1.0):
            raise SettingError(f"ior = {self.ior}: expected 0, or a number from 1 on")
        if self.alpha_cutoff is not None:
            hold_numbers(self, "alpha_cutoff")
        for name in ("is_unlit", "blends", "two_sided_emission", "single_sided"):
            if not isinstance(getattr(self, name), (bool, np.bool_)):
                raise SettingError(f"{name} = {shown(getattr(self, name))}: expected a bool")
        for name, texture in self.textures.items():
            if not isinstance(texture, Texture):
                raise SettingError(f"{name}_texture = {shown(texture)}: expected a Texture")

    def __repr__(self) -> str:
        return chosen_fields(self)

    @property
    def emits(self) -> bool:
        """Whether any component of the emission factor is above zero."""
        return max(self.emission) > 0.0

    @property
    def textures(self) -> dict[str, Texture]:
        """Its images by name, ``albedo`` for `albedo_texture`."""
        named = {
            field.name.removesuffix("_texture"): getattr(self, field.name)
            for field in fields(self)
            if field.name.endswith("_texture")
        }
        return {name: texture for name, texture in named.items() if texture is not None}

    @cached_property
    def is_translucent(self) -> bool:
        """Whether any of it may let what lies behind show through."""
        if not self.blends:
            return False
        image = self.albedo_texture
        opaque = image is None or float(image.pixels[..., 3].min()) >= (
            255.0 if image.pixels.dtype == np.uint8 else 1.0
        )
        return self.alpha < 1.0 or self.has_clear_vertices or not opaque

    @property
    def has_holes(self) -> bool:
        """Whether not all of it is drawn: parts are cut out, or let others show through."""
        return self.alpha_cutoff is not None or self.is_translucent

    @property
    def side_code(self) -> float:
        """0 if the front alone emits, 1 if both sides do, 2 if it is unlit; for shaders."""
        return 2.0 if self.is_unlit else float(self.two_sided_emission)

    @property
    def is_glossy(self) -> bool:
        """Whether it reflects more than diffuse light."""
        if self.is_unlit:
            return False
        return self.metallic > 0.0 or (self.specular > 0.0 and max(self.dielectric_color) > 0.0)

    @property
    def is_metal(self) -> bool:
        """Whether any of it is metal."""
        return self.metallic > 0.0 and not self.is_unlit

    @property
    def mean_albedo(self) -> float:
        """Base colour, by the mean of its channels and about that of its texture."""
        texture = self.albedo_texture
        means = np.ones(3) if texture is None else np.array(texture.means[:3])
        if texture is not None and texture.pixels.dtype == np.uint8:
            means = linear_from_srgb(means)
        return float(np.mean(self.albedo * means))

    @property
    def mean_metallic(self) -> float:
        """Share of metal over the whole of its texture."""
        return self.metallic * self._mean_of_texture(2) if self.metallic else 0.0

    @property
    def mean_roughness(self) -> float:
        """Roughness, by the mean of its texture."""
        return self.roughness * self._mean_of_texture(1)

    def _mean_of_texture(self, channel: int) -> float:
        texture = self.metallic_roughness_texture
        return 1.0 if texture is None else texture.means[channel]

    @property
    def dielectric_color(self) -> Color:
        """Reflectance of its dielectric part at normal incidence, at full strength.

        Beyond 1 only where an image multiplies it: shaders end it at 1 then, as glTF does.
        """
        fresnel = ((self.ior - 1.0) / (self.ior + 1.0)) ** 2
        most = 1.0 if self.specular_color_texture is None else math.inf
        r, g, b = (min(fresnel * c, most) for c in self.specular_color)
        return r, g, b


# What no shape, no shadow and no table of images depends on.
_SHADING = ("albedo", "emission", "metallic", "roughness", "specular", "specular_color", "ior")


def have_same_shape(a: Sequence[Material], b: Sequence[Material]) -> bool:
    """Return whether two lists of materials differ in how they shade what they cover, at most."""
    names = [field.name for field in fields(Material) if field.name not in _SHADING]
    return len(a) == len(b) and all(
        one is other or all(getattr(one, name) == getattr(other, name) for name in names)
        for one, other in zip(a, b, strict=True)
    )
