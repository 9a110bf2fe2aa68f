"""Materials and textures of glTF, reduced to what a diffuse surface can show."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.formats.gltf.document import Document, GltfError, Json, number, numbers
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.images import MAX_RADIANCE, check_size, doubled
from ssdo_gl.scene.material import Color, Material, Texture, Wrap
from ssdo_gl.scene.scene import SceneError

_WRAPS = {33071: "clamp", 33648: "mirror", 10497: "repeat"}
_NEAREST = 9728
# Extensions of textures that name an image in another format, the best first.
_SOURCES = ("KHR_texture_basisu", "EXT_texture_webp", "MSFT_texture_dds")
# Extensions of materials that ask for more than diffuse reflection, in words.
_BEYOND_DIFFUSE = {
    "KHR_materials_transmission": "transmission",
    "KHR_materials_diffuse_transmission": "diffuse transmission",
    "KHR_materials_volume": "volumes",
    "KHR_materials_clearcoat": "clear coats",
    "KHR_materials_sheen": "sheen",
    "KHR_materials_specular": "specular reflection",
    "KHR_materials_iridescence": "iridescence",
    "KHR_materials_anisotropy": "anisotropy",
    "KHR_materials_dispersion": "dispersion",
    "KHR_materials_unlit": "unlit shading, drawn lit",
}


@dataclass(frozen=True)
class Coordinates:
    """How the texture coordinates of an image are made.

    Attributes
    ----------
    uv_set : int
        Which TEXCOORD_n to use.
    matrix : ndarray, shape (2, 3), or None
        KHR_texture_transform.
    """

    uv_set: int = 0
    matrix: FloatArray | None = None

    @classmethod
    def of(cls, reference: Json, doubles: tuple[bool, bool]) -> Coordinates:
        """Return those of a texture reference, whose image may hold its mirror image too."""
        uv_set, matrix = _placement_matrix(reference)
        if any(doubles):
            # An image and its mirror image take two units of texture coordinates.
            halves = np.where(doubles, 0.5, 1.0)[:, None]
            matrix = halves * (np.eye(2, 3) if matrix is None else matrix)
        return cls(uv_set, matrix)

    def transformed(self, uvs: FloatArray) -> FloatArray:
        """Return texture coordinates (V, 2) as the image is to be looked up."""
        if self.matrix is None:
            return uvs
        return np.asarray(uvs @ self.matrix[:, :2].T + self.matrix[:, 2])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Coordinates):
            return NotImplemented
        mine, others = (np.eye(2, 3) if c.matrix is None else c.matrix for c in (self, other))
        return self.uv_set == other.uv_set and np.array_equal(mine, others)


@dataclass(frozen=True)
class UsedMaterial:
    """A material of the model, and how its texture coordinates are made.

    Attributes
    ----------
    index : int
        Into Model.materials.
    uvs : Coordinates
    emission_uvs : Coordinates or None
        Of the emission's image, where they differ.
    """

    index: int
    uvs: Coordinates = Coordinates()
    emission_uvs: Coordinates | None = None


class MaterialReader:
    """Reads each material and each image of a document once."""

    def __init__(self, document: Document, model: Model) -> None:
        self.document, self.model = document, model
        self._known: dict[int | None, UsedMaterial] = {}
        self._images: dict[tuple[object, ...], Texture] = {}

    def read(self, index: int | None) -> UsedMaterial:
        """Return the material with this index; None is the format's default."""
        if index not in self._known:
            entry = {} if index is None else self.document.entry("materials", index)
            self._known[index] = self._read(entry)
        return self._known[index]

    def _read(self, entry: Json) -> UsedMaterial:
        name = str(entry.get("name", ""))
        extensions = entry.get("extensions", {})
        base = entry.get("pbrMetallicRoughness", {})
        factor_key, texture_key = "baseColorFactor", "baseColorTexture"
        if "KHR_materials_pbrSpecularGlossiness" in extensions:
            base = extensions["KHR_materials_pbrSpecularGlossiness"]
            factor_key, texture_key = "diffuseFactor", "diffuseTexture"
            self.model.asks_for("specular reflection", name)
        factor = numbers(base, factor_key, (1.0, 1.0, 1.0, 1.0), f"material {name!r}")
        if not np.all((factor >= 0.0) & (factor <= 1.0)):
            raise GltfError(f"material {name!r}: {factor_key} must be four numbers from 0 to 1")
        self._list_the_rest(name, entry, factor_key == "baseColorFactor")
        reference = base.get(texture_key)
        glow = entry.get("emissiveTexture")
        emission = self._emission(name, entry, extensions)
        glow = glow if any(emission) else None
        doubles, glow_doubles = self._mirrored_axes(reference), self._mirrored_axes(glow)
        material = Material(
            name=name,
            albedo=_triple(factor[:3]),
            emission=emission,
            albedo_texture=self._texture(reference, doubles),
            emission_texture=self._texture(glow, glow_doubles),
            alpha_cutoff=self._cutoff(name, entry),
            alpha=float(factor[3]),
            two_sided_emission=bool(entry.get("doubleSided", False)) and any(emission),
            single_sided=not entry.get("doubleSided", False),
        )
        self.model.materials.append(material)
        index = len(self.model.materials) - 1
        if reference is None or glow is None:
            used = (glow or {}, glow_doubles) if reference is None else (reference, doubles)
            return UsedMaterial(index, Coordinates.of(*used))
        uvs, emission_uvs = Coordinates.of(reference, doubles), Coordinates.of(glow, glow_doubles)
        return UsedMaterial(index, uvs, None if emission_uvs == uvs else emission_uvs)

    def _emission(self, name: str, entry: Json, extensions: Json) -> Color:
        where = f"material {name!r}"
        factor = numbers(entry, "emissiveFactor", (0.0, 0.0, 0.0), where)
        strength = extensions.get("KHR_materials_emissive_strength", {})
        factor = factor * number(strength, "emissiveStrength", 1.0, where)
        if not np.all((factor >= 0.0) & (factor <= MAX_RADIANCE)):
            raise GltfError(
                f"{where}: emissiveFactor times emissiveStrength must be three numbers "
                f"from 0 to {MAX_RADIANCE:g}"
            )
        return _triple(factor)

    def _cutoff(self, name: str, entry: Json) -> float | None:
        mode = entry.get("alphaMode", "OPAQUE")
        if mode == "MASK":
            return float(np.clip(number(entry, "alphaCutoff", 0.5, f"material {name!r}"), 0.0, 1.0))
        if mode == "BLEND":
            self.model.asks_for("alpha blending, drawn opaque", name)
        return None

    def _list_the_rest(self, name: str, entry: Json, metallic_workflow: bool) -> None:
        """List what the material asks for beyond diffuse reflection."""
        base = entry.get("pbrMetallicRoughness", {})
        # Without a material of its own a primitive is formally metal; nobody means it.
        if (
            entry
            and metallic_workflow
            and number(base, "metallicFactor", 1.0, f"material {name!r}") > 0.0
        ):
            self.model.asks_for("metal", name)
        if "normalTexture" in entry:
            self.model.asks_for("normal maps", name)
        if "occlusionTexture" in entry:
            self.model.asks_for("baked occlusion", name)
        for extension in entry.get("extensions", {}):
            if extension in _BEYOND_DIFFUSE:
                self.model.asks_for(_BEYOND_DIFFUSE[extension], name)

    def _texture(self, reference: Json | None, doubles: tuple[bool, bool]) -> Texture | None:
        """Return the texture, or None with a note if it cannot be used.

        Models are passed on without their textures, and often show what matters.
        """
        if reference is None:
            return None
        first: str | None = None
        for source in self._sources(reference):
            try:
                sampler = self._sampler(reference)
                nearest = sampler.get("magFilter") == _NEAREST
                return self._image(source, _wraps(sampler), doubles, nearest)
            except (SceneError, GltfError) as error:
                first = first or str(error)
            except (KeyError, TypeError, AttributeError):
                first = first or "its entry is not valid glTF"
        self.model.note(
            f"texture not used: {first or 'it names no image of a format that is read'}"
        )
        return None

    def _sources(self, reference: Json) -> list[Any]:
        """Return the images that a texture may be read from, the best first."""
        try:
            texture = self.document.entry("textures", reference["index"])
            extensions = texture.get("extensions", {})
            holders = [extensions.get(name, {}) for name in _SOURCES] + [texture]
            return [holder["source"] for holder in holders if "source" in holder]
        except (GltfError, KeyError, TypeError, AttributeError):
            return [None]  # refused where it is read

    def _sampler(self, reference: Json) -> Json:
        """Return the sampler of a texture reference, empty for the default."""
        texture = self.document.entry("textures", reference["index"])
        return self.document.entry("samplers", texture["sampler"]) if "sampler" in texture else {}

    def _mirrored_axes(self, reference: Json | None) -> tuple[bool, bool]:
        """Return whether the texture is mirrored along u and v."""
        try:
            u, v = _wraps(self._sampler(reference)) if reference else ("repeat", "repeat")
        except (GltfError, KeyError, TypeError, AttributeError):
            return False, False  # noted where the texture is read
        return u == "mirror", v == "mirror"

    def _image(
        self, source: int, wraps: tuple[str, str], doubles: tuple[bool, bool], nearest: bool
    ) -> Texture:
        key = (source, wraps, doubles, nearest)
        if key not in self._images:
            name = str(self.document.entry("images", source).get("name") or f"image {source}")
            data = self.document.image(source)
            texture = self.model.texture(data, self.document.path.name, name)
            pixels = texture.pixels
            sizes = pixels.shape[1] << doubles[0], pixels.shape[0] << doubles[1]
            check_size(sizes, f"{name} with its mirror image", self.document.path.name)
            for axis, double in ((1, doubles[0]), (0, doubles[1])):
                if double:
                    pixels = doubled(pixels.astype(np.uint8), axis, wraps[1 - axis])
            u, v = ("clamp" if wrap == "clamp" else "repeat" for wrap in wraps)
            self._images[key] = replace(
                texture, pixels=pixels, wrap=(cast(Wrap, u), cast(Wrap, v)), nearest=nearest
            )
        return self._images[key]


def _wraps(sampler: Json) -> tuple[str, str]:
    u, v = (_WRAPS.get(sampler.get(key, 0), "repeat") for key in ("wrapS", "wrapT"))
    return u, v


def _placement_matrix(reference: Json) -> tuple[int, FloatArray | None]:
    """Return the coordinate set and the (2, 3) matrix of KHR_texture_transform."""
    transform = reference.get("extensions", {}).get("KHR_texture_transform")
    uv_set = int(reference.get("texCoord", 0))
    if transform is None:
        return uv_set, None
    uv_set = int(transform.get("texCoord", uv_set))
    where = "KHR_texture_transform"
    angle = number(transform, "rotation", 0.0, where)
    scale = numbers(transform, "scale", (1.0, 1.0), where)
    offset = numbers(transform, "offset", (0.0, 0.0), where)
    cosine, sine = np.cos(angle), np.sin(angle)
    # Scale, then rotate, then move; v points down, so the turn is clockwise in uv.
    rotation = np.array([[cosine, sine], [-sine, cosine]])
    return uv_set, np.concatenate([rotation * scale, offset[:, None]], axis=1)


def _triple(array: FloatArray) -> Color:
    r, g, b = (float(value) for value in array)
    return r, g, b
