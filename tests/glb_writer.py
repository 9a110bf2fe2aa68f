"""Writes small .glb files for tests, accessor by accessor."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene

# How texture coordinates outside of 0..1 are taken.
REPEAT, MIRROR, CLAMP = 10497, 33648, 33071


class GlbWriter:
    """Builds the JSON and the binary chunk of a .glb, accessor by accessor."""

    def __init__(self) -> None:
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "accessors": [],
            "bufferViews": [],
        }
        self.binary = b""

    def view(self, data: bytes) -> int:
        self.binary += b"\0" * (-len(self.binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)}
        self.json["bufferViews"].append(view)
        self.binary += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, array: NDArray[Any], kind: str, **more: Any) -> int:
        codes = {"<f4": 5126, "<u4": 5125, "<u2": 5123, "|u1": 5121, "<i2": 5122, "|i1": 5120}
        self.json["accessors"].append(
            {
                "bufferView": self.view(array.tobytes()),
                "componentType": codes[array.dtype.str],
                "count": len(array),
                "type": kind,
                **more,
            }
        )
        return len(self.json["accessors"]) - 1

    def triangle(self, **attributes: int) -> dict[str, Any]:
        """Return a primitive: one triangle in the plane z = 0."""
        positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype="<f4")
        index = self.accessor(positions, "VEC3")
        return {"attributes": {"POSITION": index, **attributes}}

    def bytes(self) -> bytes:
        document = {**self.json, "buffers": [{"byteLength": len(self.binary)}]}
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        binary = self.binary + b"\0" * (-len(self.binary) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(binary), 0x004E4942) + binary
        return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks

    def text(self) -> str:
        """Return the document as a .gltf whose buffer is inline."""
        uri = "data:;base64," + base64.b64encode(self.binary).decode()
        return json.dumps({**self.json, "buffers": [{"byteLength": len(self.binary), "uri": uri}]})

    def save(self, path: Path) -> Path:
        path.write_bytes(self.bytes())
        return path


def load(glb: GlbWriter, folder: Path) -> Scene:
    """Return the scene of the file, without the ground that a model is given."""
    return load_scene(glb.save(folder / "a.glb"), ground="off")


def save_with_cameras(path: Path, names: Sequence[str], lens: str = "") -> Path:
    """Write a triangle seen by cameras 4, 5, 6 ... units away; the second moves 8 along x a second.

    `names` are those of their nodes, `lens` that of the camera they share.
    """
    glb = GlbWriter()
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["cameras"] = [
        {"type": "perspective", "name": lens, "perspective": {"yfov": 0.5, "znear": 1}}
    ]
    glb.json["nodes"] = [
        {"mesh": 0},
        *({"camera": 0, "name": n, "translation": [0, 0, 4 + i]} for i, n in enumerate(names)),
    ]
    glb.json["scenes"] = [{"nodes": list(range(len(names) + 1))}]
    times = glb.accessor(np.array([0, 1], dtype="<f4"), "SCALAR")
    places = glb.accessor(np.array([[0, 0, 5], [8, 0, 5]], dtype="<f4"), "VEC3")
    channel = {"sampler": 0, "target": {"node": 2, "path": "translation"}}
    glb.json["animations"] = [
        {"samplers": [{"input": times, "output": places}], "channels": [channel]}
    ]
    return glb.save(path)
