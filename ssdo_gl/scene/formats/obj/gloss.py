"""What .mtl materials say of gloss, in the terms of metal and roughness."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.formats.obj.maps import Map, read_map
from ssdo_gl.scene.material import Color

# Exporters write Ks 0.5 for a plain dielectric, which reflects 4 % at normal incidence.
_FULL_KS = 0.08
# A surface that scatters less than this share of what it reflects is a metal.
_METAL_RATIO = 0.1
# Slope of a height map that goes from black to white within one texel, at -bm 1.
_BUMP_SLOPE = 2.0
_NORMAL_MAPS = ("norm", "map_kn", "map_bump", "bump")


def roughness_of(exponent: float) -> float:
    """Return the roughness whose GGX lobe is as wide as Blinn and Phong's of an `Ns`.

    B. Walter et al., "Microfacet Models for Refraction" (2007): alpha^2 = 2 / (Ns + 2).
    """
    return math.sqrt(math.sqrt(2.0 / (max(exponent, 0.0) + 2.0)))


def gloss_fields(
    numbers: Mapping[str, float], albedo: Color, specular: Color | None, maps: Mapping[str, Map]
) -> dict[str, Any]:
    """Return fields of a Material, none for one that is diffuse only.

    Parameters
    ----------
    numbers : mapping
        Of ``ns``, ``pr``, ``pm`` and ``illum``, those that the material has.
    specular : Color or None
        ``Ks``.
    maps : mapping
        All images of the material.
    """
    has_specular_map = "specular_color" in maps
    is_physical = "pr" in numbers or "pm" in numbers
    if numbers.get("illum", 2.0) < 2.0 and not is_physical:
        specular, has_specular_map = None, False
    if has_specular_map and specular is None:
        specular = (1.0, 1.0, 1.0)
    reflects = specular is not None and max(specular) > 0.0
    if not reflects and not is_physical:
        return {}
    roughness = numbers.get("pr", roughness_of(numbers.get("ns", 0.0)))
    fields: dict[str, Any] = {
        "roughness": min(max(roughness, 0.0), 1.0),
        "metallic": min(max(numbers.get("pm", 0.0), 0.0), 1.0),
        "specular": 1.0,
    }
    if specular is not None and reflects and not is_physical:
        is_plain = not maps.keys() & {"albedo", "specular_color"}
        if is_plain and max(albedo) < _METAL_RATIO * max(specular):
            color = tuple(min(c, 1.0) for c in specular)
            return fields | {"metallic": 1.0, "albedo": color}
        # The reflectance of an index of 1.5, 4 %, is what the colour multiplies.
        return fields | {"specular_color": tuple(c * _FULL_KS / 0.04 for c in specular)}
    return fields


def gloss_maps(
    block: Mapping[str, str], found: Callable[[str], Path], model: Model, where: str
) -> dict[str, Map]:
    """Return the images of gloss and of bumps by the name that Material has for them."""

    def image(key: str) -> Map | None:
        return read_map(block.get(key), found, model, where)

    maps: dict[str, Map | None] = {
        "specular_color": image("map_ks"),
        "metallic_roughness": _metallic_roughness(image("map_pr"), image("map_pm")),
    }
    key = next((key for key in _NORMAL_MAPS if key in block), None)
    if key is not None:
        bumps = image(key)
        maps["normal"] = None if bumps is None else _normals(bumps, key in _NORMAL_MAPS[:2])
    return {name: entry for name, entry in maps.items() if entry is not None}


def _metallic_roughness(rough: Map | None, metal: Map | None) -> Map | None:
    """Return roughness in green and metal in blue, where the first of them lies."""
    base = rough or metal
    if base is None:
        return None
    height, width = base.texture.pixels.shape[:2]
    pixels = np.full((height, width, 4), 255, dtype=np.uint8)
    for channel, entry in ((1, rough), (2, metal)):
        if entry is not None:
            grey = Image.fromarray(_grey(entry.texture.pixels)).resize((width, height))
            pixels[..., channel] = np.asarray(grey)
    return replace(base, texture=replace(base.texture, pixels=pixels, is_data=True))


def _normals(bumps: Map, are_normals: bool) -> Map:
    """Return an image of normals; heights become some.

    Exporters write images of normals where heights are meant, so unless they are said to
    be normals the picture decides.
    """
    pixels = bumps.texture.pixels
    if not are_normals and not _shows_normals(pixels):
        heights = _grey(pixels).astype(np.float64) / 255.0
        slope = _BUMP_SLOPE * bumps.bump
        # Central differences; the image repeats, and rows count downward.
        across = 0.5 * (np.roll(heights, -1, axis=1) - np.roll(heights, 1, axis=1))
        down = 0.5 * (np.roll(heights, -1, axis=0) - np.roll(heights, 1, axis=0))
        normal = np.stack([-slope * across, slope * down, np.ones_like(heights)], axis=-1)
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        pixels = np.full_like(pixels, 255)
        pixels[..., :3] = np.rint(127.5 * (normal + 1.0))
    return replace(bumps, texture=replace(bumps.texture, pixels=pixels, is_data=True))


def _shows_normals(pixels: NDArray[Any]) -> bool:
    """Return whether an image is of unit vectors that mostly point out of it."""
    mean = pixels[..., :3].reshape(-1, 3).mean(axis=0)
    return bool(np.all(np.abs(mean[:2] - 128.0) < 48.0) and mean[2] > max(mean[:2]) + 32.0)


def _grey(pixels: NDArray[Any]) -> NDArray[np.uint8]:
    return np.asarray(Image.fromarray(np.asarray(pixels, np.uint8)).convert("RGB").convert("L"))
