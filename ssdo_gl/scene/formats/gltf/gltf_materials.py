"""Materials of glTF: metallic-roughness, and which of its extensions are drawn."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from ssdo_gl.math3d import vector
from ssdo_gl.scene.files import MAX_RADIANCE
from ssdo_gl.scene.formats.gltf.document import Document, Json, number, numbers
from ssdo_gl.scene.formats.gltf.gltf_textures import Coordinates, Placed, TextureReader
from ssdo_gl.scene.formats.gltf.ranges import Ranges
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.material import Color, Material, Texture
from ssdo_gl.scene.numbers import LARGEST_NUMBER

# Extensions that are drawn as the material beneath them, in words.
_LEFT_OUT = {
    "KHR_materials_diffuse_transmission": "diffuse transmission",
    "KHR_materials_volume": "volumes",
    "KHR_materials_clearcoat": "clear coats",
    "KHR_materials_sheen": "sheen",
    "KHR_materials_iridescence": "iridescence",
    "KHR_materials_anisotropy": "anisotropy",
    "KHR_materials_dispersion": "dispersion",
}
_TRANSMISSION = "KHR_materials_transmission"
# Share of what lies behind clear glass that shows through: the rest is its reflection.
_MOST_SEEN_THROUGH = 0.85
_GLOSSINESS = "KHR_materials_pbrSpecularGlossiness"
_WHITE = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class UsedMaterial:
    """A material of the model, and how its texture coordinates are made.

    Attributes
    ----------
    index : int
        Into Model.materials.
    second_uvs : Coordinates or None
        Of the images of `Material.second_uvs`, if any.
    """

    index: int
    uvs: Coordinates
    second_uvs: Coordinates | None


class MaterialReader:
    """Reads each material of a document once."""

    def __init__(self, document: Document, model: Model, ranges: Ranges) -> None:
        self.document, self.model, self.ranges = document, model, ranges
        self.textures = TextureReader(document, model)
        self._known: dict[int | None, UsedMaterial] = {}

    def read(self, index: int | None) -> UsedMaterial:
        """Return the material with this index; None is the format's default."""
        if index not in self._known:
            entry = {} if index is None else self.document.entry("materials", index)
            self._known[index] = self._read(entry)
        return self._known[index]

    def _read(self, entry: Json) -> UsedMaterial:
        name = str(entry.get("name", ""))
        where = f"material {name!r}"
        extensions, ranges = entry.get("extensions", {}), self.ranges
        emission = _emission(entry, extensions, where, ranges)
        if _GLOSSINESS in extensions:
            fields, images = _specular_glossiness(extensions[_GLOSSINESS], where, ranges)
        else:
            fields, images = _metallic_roughness(entry, extensions, where, ranges)
        images |= {
            "emission": entry.get("emissiveTexture") if any(emission) else None,
            "normal": entry.get("normalTexture"),
            "occlusion": entry.get("occlusionTexture"),
        }
        placed = self.textures.placed(images, name)
        if _GLOSSINESS in extensions and "specular_color" in placed.textures:
            placed = _with_roughness(placed, 1.0 - fields["roughness"])
            fields["roughness"] = 1.0
        for extension in extensions:
            if extension in _LEFT_OUT:
                self.model.asks_for(_LEFT_OUT[extension], name)
        mode = ranges.word(entry, "alphaMode", ("OPAQUE", "MASK", "BLEND"), where)
        through = ranges.number(extensions.get(_TRANSMISSION, {}), "transmissionFactor", 0.0, where)
        through = 0.0 if mode == "MASK" else through
        if through > 0.0:
            self.model.asks_for("refraction (transmission is blended)", name)
            # Of an opaque material alpha does not count.
            alpha = fields["alpha"] if mode == "BLEND" else 1.0
            fields["alpha"] = alpha * (1.0 - _MOST_SEEN_THROUGH * through)
        fields |= {f"{image}_texture": texture for image, texture in placed.textures.items()}
        is_two_sided = bool(entry.get("doubleSided", False))
        normal, occlusion = images["normal"] or {}, images["occlusion"] or {}
        material = Material(
            name=name,
            emission=emission,
            normal_scale=number(normal, "scale", 1.0, where),
            occlusion_strength=ranges.number(occlusion, "strength", 1.0, where),
            is_unlit="KHR_materials_unlit" in extensions,
            blends=mode == "BLEND" or through > 0.0,
            second_uvs=placed.on_second,
            alpha_cutoff=_cutoff(entry, where) if mode == "MASK" else None,
            two_sided_emission=is_two_sided and any(emission),
            single_sided=not is_two_sided,
            **fields,
        )
        self.model.materials.append(material)
        return UsedMaterial(len(self.model.materials) - 1, placed.first, placed.second)


def _metallic_roughness(
    entry: Json, extensions: Json, where: str, ranges: Ranges
) -> tuple[dict[str, Any], dict[str, Json | None]]:
    """Return fields of the material, and references of its textures."""
    base = entry.get("pbrMetallicRoughness", {})
    specular = extensions.get("KHR_materials_specular", {})
    color = ranges.numbers(specular, "specularColorFactor", _WHITE, where, high=np.inf)
    fields = _base_color(base, "baseColorFactor", where, ranges)
    # Without a material of its own a primitive is formally metal; nobody means it.
    if entry:
        fields |= {
            "metallic": ranges.number(base, "metallicFactor", 1.0, where),
            "roughness": ranges.number(base, "roughnessFactor", 1.0, where),
            "specular": ranges.number(specular, "specularFactor", 1.0, where),
            "specular_color": vector(color),
            "ior": _index_of_refraction(extensions, where, ranges),
        }
    return fields, {
        "albedo": base.get("baseColorTexture"),
        "metallic_roughness": base.get("metallicRoughnessTexture"),
        "specular": specular.get("specularTexture"),
        "specular_color": specular.get("specularColorTexture"),
    }


def _specular_glossiness(
    base: Json, where: str, ranges: Ranges
) -> tuple[dict[str, Any], dict[str, Json | None]]:
    """Return the same of the older workflow.

    An infinite index of refraction makes the specular colour the reflectance itself, as
    Khronos' own conversion does.
    """
    color = ranges.numbers(base, "specularFactor", _WHITE, where)
    fields = _base_color(base, "diffuseFactor", where, ranges) | {
        "roughness": 1.0 - ranges.number(base, "glossinessFactor", 1.0, where),
        "specular": 1.0,
        "specular_color": vector(color),
        "ior": 0.0,
    }
    images = base.get("diffuseTexture"), base.get("specularGlossinessTexture")
    return fields, {"albedo": images[0], "specular_color": images[1]}


def _with_roughness(placed: Placed, glossiness: float) -> Placed:
    """Return the textures with the alpha of the specular colour as roughness."""
    image = placed.textures["specular_color"]
    pixels = np.full_like(image.pixels, 255)
    rough = np.rint(255.0 - glossiness * image.pixels[..., 3].astype(np.float64))
    pixels[..., 1] = np.clip(rough, 0.0, 255.0)
    texture: Texture = dataclasses.replace(image, pixels=pixels, is_data=True)
    moved = {"metallic_roughness"} if "specular_color" in placed.on_second else set()
    return dataclasses.replace(
        placed,
        textures={**placed.textures, "metallic_roughness": texture},
        on_second=placed.on_second | moved,
    )


def _base_color(base: Json, key: str, where: str, ranges: Ranges) -> dict[str, Any]:
    factor = ranges.numbers(base, key, (1.0, 1.0, 1.0, 1.0), where)
    return {"albedo": vector(factor[:3]), "alpha": float(factor[3])}


def _index_of_refraction(extensions: Json, where: str, ranges: Ranges) -> float:
    """Return 0 or a number from 1 on.

    The inverse reflects as much at normal incidence, which is what other viewers make of
    numbers below 1.
    """
    ior = number(extensions.get("KHR_materials_ior", {}), "ior", 1.5, where)
    if ior == 0.0 or ior >= 1.0:
        return ior
    taken = 1.0 / ior if ior > 0.0 else 1.5
    ranges.replaced(f"ior {ior:g} as {taken:.3g}", where)
    return min(taken, LARGEST_NUMBER)


def _emission(entry: Json, extensions: Json, where: str, ranges: Ranges) -> Color:
    factor = numbers(entry, "emissiveFactor", (0.0, 0.0, 0.0), where)
    strength = extensions.get("KHR_materials_emissive_strength", {})
    factor = factor * number(strength, "emissiveStrength", 1.0, where)
    name = "emissiveFactor times emissiveStrength"
    return vector(ranges.nearest(factor, 0.0, MAX_RADIANCE, name, where))


def _cutoff(entry: Json, where: str) -> float:
    """Return the opacity from which something is drawn; above 1 nothing is."""
    return float(np.clip(number(entry, "alphaCutoff", 0.5, where), 0.0, 1.0))
