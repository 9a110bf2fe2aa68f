"""Meshes of KHR_draco_mesh_compression."""

from __future__ import annotations

import numpy as np

from ssdo_gl.scene.decoders import DecoderError, MissingDecoderError, decoded_draco
from ssdo_gl.scene.formats.gltf.document import Document, GltfError, Json
from ssdo_gl.scene.formats.model import MAX_TRIANGLES

_NAME = "KHR_draco_mesh_compression"


def unpack(document: Document, primitive: Json) -> None:
    """Put what a compressed primitive holds in the place of its accessors.

    Where the library is missing, accessors that have data of their own keep it.
    """
    document.decoded.clear()
    packed = primitive.get("extensions", {}).get(_NAME)
    if packed is None:
        return
    attributes = primitive["attributes"]
    accessors = [attributes[name] for name in packed["attributes"]]
    if "indices" in primitive:
        accessors.append(primitive["indices"])
    has_own = all("bufferView" in document.entry("accessors", index) for index in accessors)
    if int(document.entry("accessors", accessors[-1])["count"]) > 3 * MAX_TRIANGLES:
        raise GltfError(f"accessor {accessors[-1]}: at most {MAX_TRIANGLES} triangles are read")
    data, start, length = document.view(packed["bufferView"])
    ids = {str(name): int(number) for name, number in packed["attributes"].items()}
    try:
        triangles, *arrays = decoded_draco(data[start : start + length], ids)
    except MissingDecoderError as error:
        if has_own:
            return
        raise GltfError(f"{_NAME} {error}") from None
    except DecoderError as error:
        raise GltfError(f"not valid Draco compression: {error}") from None
    for index, array in zip(accessors, arrays, strict=False):
        document.decoded[index] = array
    if "indices" in primitive:
        document.decoded[primitive["indices"]] = np.asarray(triangles).reshape(-1, 1)
