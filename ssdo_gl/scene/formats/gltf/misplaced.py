"""Finds what stands in a document where glTF wants something else."""

from __future__ import annotations

from collections.abc import Iterator

from ssdo_gl.scene.formats.gltf.document import Json, shown

# Lists of objects: of the document, and within its objects, where nodes are numbers.
_LISTS = {
    *("accessors", "animations", "buffers", "bufferViews", "cameras", "images", "materials"),
    *("meshes", "nodes", "samplers", "scenes", "skins", "textures"),
}
_INNER_LISTS = {"channels", "lights", "primitives", "samplers", "targets"}
_OBJECTS = {
    *("attributes", "extensions", "orthographic", "pbrMetallicRoughness", "perspective"),
    *("sparse", "spot"),
}


def misplaced(document: Json) -> str | None:
    """Return what is no object where one belongs, and where; None if there is no such thing."""
    return next(_misplaced(document, "", _LISTS), None)


def _misplaced(table: Json, where: str, lists: set[str] = _INNER_LISTS) -> Iterator[str]:
    for key, value in table.items():
        place = f"{where}{key}"
        if key in lists and not isinstance(value, list):
            yield f"{place} is {shown(value)}: expected a list of objects"
        elif key in lists:
            for index, entry in enumerate(value):
                yield from _entry(entry, f"{place} {index}")
        elif key in _OBJECTS or key.endswith("Texture"):
            yield from _entry(value, place)
            if key == "extensions" and isinstance(value, dict):
                for name, extension in value.items():
                    yield from _entry(extension, f"{place}: {name}")
        elif isinstance(value, dict) and key != "extras":
            yield from _misplaced(value, f"{place}: ")


def _entry(entry: object, place: str) -> Iterator[str]:
    if isinstance(entry, dict):
        yield from _misplaced(entry, f"{place}: ")
    else:
        yield f"{place} is {shown(entry)}: expected an object, {{...}}"
