"""What may stand in a glTF document: extensions, and how much of each is drawn; lists; objects."""

from __future__ import annotations

from collections.abc import Iterator

from ssdo_gl.scene.formats.gltf.document import Document, GltfError, Json
from ssdo_gl.settings.fields import shown

EXACT, APPROXIMATE, NOT_DRAWN = "exact", "approximate", "not drawn"
# What is not listed is unknown: skipped, unless the file requires it.
EXTENSIONS = {
    "EXT_mesh_gpu_instancing": EXACT,
    "EXT_meshopt_compression": EXACT,
    "EXT_texture_webp": EXACT,
    "KHR_animation_pointer": NOT_DRAWN,
    "KHR_draco_mesh_compression": EXACT,
    "KHR_lights_punctual": APPROXIMATE,
    "KHR_materials_anisotropy": NOT_DRAWN,
    "KHR_materials_clearcoat": NOT_DRAWN,
    "KHR_materials_diffuse_transmission": NOT_DRAWN,
    "KHR_materials_dispersion": NOT_DRAWN,
    "KHR_materials_emissive_strength": EXACT,
    "KHR_materials_ior": EXACT,
    "KHR_materials_iridescence": NOT_DRAWN,
    "KHR_materials_pbrSpecularGlossiness": APPROXIMATE,
    "KHR_materials_sheen": NOT_DRAWN,
    "KHR_materials_specular": EXACT,
    "KHR_materials_transmission": APPROXIMATE,
    "KHR_materials_unlit": EXACT,
    "KHR_materials_variants": APPROXIMATE,
    "KHR_materials_volume": NOT_DRAWN,
    "KHR_mesh_quantization": EXACT,
    "KHR_meshopt_compression": EXACT,
    "KHR_node_visibility": EXACT,
    "KHR_texture_basisu": EXACT,
    "KHR_texture_transform": EXACT,
    "MSFT_texture_dds": EXACT,
}


def check_extensions(document: Document) -> None:
    """Refuse a file that requires what changes its geometry in ways not read here."""
    for name in document.json.get("extensionsRequired", []):
        if name not in EXTENSIONS and not str(name).startswith("KHR_materials_"):
            raise GltfError(f"requires the extension {shown(name)}, which is not supported")


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
