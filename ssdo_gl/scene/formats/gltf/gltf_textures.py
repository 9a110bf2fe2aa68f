"""Textures of glTF materials: images, samplers, and where on them a point lies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.files import check_size, doubled
from ssdo_gl.scene.formats.gltf.document import Document, GltfError, Json, number, numbers
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.material import Texture, Wrap
from ssdo_gl.scene.scene_error import SceneError

_WRAPS = {33071: "clamp", 33648: "mirror", 10497: "repeat"}
_NEAREST = 9728
# Extensions of textures that name an image in another format, the best first.
_SOURCES = ("KHR_texture_basisu", "EXT_texture_webp", "MSFT_texture_dds")
# Textures whose values are numbers as they stand, not colours.
_DATA = ("metallic_roughness", "specular", "normal", "occlusion")


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
    def of(cls, reference: Json) -> Coordinates:
        """Return those of a texture reference."""
        transform = reference.get("extensions", {}).get("KHR_texture_transform")
        uv_set = int(reference.get("texCoord", 0))
        if transform is None:
            return cls(uv_set)
        where = "KHR_texture_transform"
        angle = number(transform, "rotation", 0.0, where)
        scale = numbers(transform, "scale", (1.0, 1.0), where)
        offset = numbers(transform, "offset", (0.0, 0.0), where)
        cosine, sine = np.cos(angle), np.sin(angle)
        # Scale, then rotate, then move; v points down, so the turn is clockwise in uv.
        rotation = np.array([[cosine, sine], [-sine, cosine]])
        matrix = np.concatenate([rotation * scale, offset[:, None]], axis=1)
        return cls(int(transform.get("texCoord", uv_set)), matrix)

    def doubled(self, doubles: tuple[bool, bool]) -> Coordinates:
        """Return those of an image that holds two of its kind along some axes."""
        if not any(doubles):
            return self
        halves = np.where(doubles, 0.5, 1.0)[:, None]
        return Coordinates(self.uv_set, halves * self._affine)

    def transformed(self, uvs: FloatArray) -> FloatArray:
        """Return texture coordinates (V, 2) as the image is to be looked up."""
        if self.matrix is None:
            return uvs
        return np.asarray(uvs @ self.matrix[:, :2].T + self.matrix[:, 2])

    @property
    def _affine(self) -> FloatArray:
        return np.eye(2, 3) if self.matrix is None else self.matrix

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Coordinates):
            return NotImplemented
        return self.uv_set == other.uv_set and np.array_equal(self._affine, other._affine)


@dataclass(frozen=True)
class Placed:
    """The textures of a material.

    Attributes
    ----------
    textures : mapping
        By the name that `Material.textures` has for them; without those not usable.
    first, second : Coordinates
        `second` is None where all of them use the same.
    on_second : frozenset of str
        Names of those that use the second.
    """

    textures: Mapping[str, Texture]
    first: Coordinates = Coordinates()
    second: Coordinates | None = None
    on_second: frozenset[str] = frozenset()


class TextureReader:
    """Reads each image of a document once."""

    def __init__(self, document: Document, model: Model) -> None:
        self.document, self.model = document, model
        self._images: dict[tuple[object, ...], Texture] = {}

    def placed(self, references: Mapping[str, Json | None], material: str) -> Placed:
        """Return the textures that a material refers to.

        A mesh has two sets of coordinates to look images up with. Where a material has
        more, the rest are looked up with the first, and a note says so.
        """
        wanted = {name: entry for name, entry in references.items() if entry is not None}
        groups: list[tuple[Coordinates, list[str]]] = []
        for name, reference in wanted.items():
            own = Coordinates.of(reference)
            members = next((names for known, names in groups if known == own), None)
            if members is None and len(groups) == 2:
                self.model.note(
                    f"material {material!r}: a third set of texture coordinates is not drawn "
                    f"({name.replace('_', ' ')})"
                )
                members = groups[0][1]
            if members is None:
                groups.append((own, [name]))
            else:
                members.append(name)
        textures: dict[str, Texture] = {}
        found: list[Coordinates] = []
        for own, names in groups:
            mirrored = [self._mirrored_axes(wanted[name]) for name in names]
            # An image and its mirror image take two units of coordinates: so do all that
            # share these.
            doubles = any(u for u, _ in mirrored), any(v for _, v in mirrored)
            found.append(own.doubled(doubles))
            for name in names:
                texture = self._texture(wanted[name], doubles, name in _DATA)
                if texture is not None:
                    textures[name] = texture
        if len(groups) < 2:
            return Placed(textures, found[0] if found else Coordinates())
        return Placed(textures, found[0], found[1], frozenset(groups[1][1]))

    def _texture(
        self, reference: Json, doubles: tuple[bool, bool], is_data: bool
    ) -> Texture | None:
        """Return the texture, or None with a note if it cannot be used.

        Models are passed on without their textures, and often show what matters.
        """
        first: str | None = None
        for source in self._sources(reference):
            try:
                return self._image(source, self._sampler(reference), doubles, is_data)
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

    def _mirrored_axes(self, reference: Json) -> tuple[bool, bool]:
        """Return whether the texture is mirrored along u and v."""
        try:
            u, v = _wraps(self._sampler(reference))
        except (GltfError, KeyError, TypeError, AttributeError):
            return False, False  # noted where the texture is read
        return u == "mirror", v == "mirror"

    def _image(
        self, source: int, sampler: Json, doubles: tuple[bool, bool], is_data: bool
    ) -> Texture:
        wraps, nearest = _wraps(sampler), sampler.get("magFilter") == _NEAREST
        key = (source, wraps, doubles, nearest, is_data)
        if key not in self._images:
            where = self.document.path.name
            name = str(self.document.entry("images", source).get("name") or f"image {source}")
            if (source,) not in self._images:
                data = self.document.image(source)
                self._images[(source,)] = self.model.texture(data, where, name)
            texture = self._images[(source,)]
            pixels = texture.pixels
            sizes = pixels.shape[1] << doubles[0], pixels.shape[0] << doubles[1]
            check_size(sizes, f"{name} with its mirror image", where)
            for axis, double in ((1, doubles[0]), (0, doubles[1])):
                if double:
                    pixels = doubled(pixels.astype(np.uint8), axis, wraps[1 - axis])
            u, v = ("repeat" if wrap == "mirror" else wrap for wrap in wraps)
            self._images[key] = replace(
                texture,
                pixels=pixels,
                wrap=(cast(Wrap, u), cast(Wrap, v)),
                nearest=nearest,
                is_data=is_data,
            )
        return self._images[key]


def _wraps(sampler: Json) -> tuple[str, str]:
    u, v = (_WRAPS.get(sampler.get(key, 0), "repeat") for key in ("wrapS", "wrapT"))
    return u, v
