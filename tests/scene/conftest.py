"""Fixtures that write small scene and model files."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene, SceneError

BOX = '[[object]]\nshape = "box"\nmin = [0, 0, 0]\nmax = [1, 2, 3]\n'


@pytest.fixture
def scene_of() -> Callable[[str], Scene]:
    """Return a function from TOML text (a box is added) to the scene."""
    return lambda text: read_description(f"{text}\n{BOX}", "scene.toml")


@pytest.fixture
def error_of() -> Callable[..., str]:
    """Return a function from a source to the one line that refuses it."""

    def error(source: str | Path, *, text: str | None = None) -> str:
        with pytest.raises(SceneError) as caught:
            if text is None:
                load_scene(source)
            else:
                read_description(text, str(source))
        message = str(caught.value)
        assert "\n" not in message
        assert len(message) < 400
        # A cause would be shown to a user as a traceback of somebody else's code.
        assert caught.value.__cause__ is None
        return message

    return error


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

    def save(self, path: Path) -> Path:
        path.write_bytes(self.bytes())
        return path


@pytest.fixture
def glb() -> GlbWriter:
    """An empty .glb with one node that shows mesh 0."""
    return GlbWriter()


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes files by name and returns the last one's path."""

    def save(files: Mapping[str, str | bytes]) -> Path:
        path = tmp_path
        for name, content in files.items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return save
