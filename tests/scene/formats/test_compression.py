"""Compressed meshes and textures: decoded exactly, bounded, and never without a word."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_writer import GlbWriter, load
from ktx2_writer import ktx2
from numpy.typing import NDArray
from PIL import Image

from ssdo_gl.scene import decoders
from ssdo_gl.scene.decoders import client
from ssdo_gl.scene.files.images import read_texture
from ssdo_gl.scene.formats.gltf import document
from ssdo_gl.scene.material import Texture
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.25]], dtype="<f4")
TRIANGLES = np.array([[0, 1, 2], [1, 3, 2]], dtype="<u4")


def drawn(scene: Scene) -> list[Any]:
    (mesh,) = scene.meshes
    return corners_of(mesh.positions[mesh.triangles])


def corners_of(triangles: NDArray[Any]) -> list[Any]:
    """Return triangles in an order that does not depend on where each begins."""
    return sorted(sorted(triangle) for triangle in triangles.round(6).tolist())


@pytest.fixture(autouse=True)
def no_process_left() -> Any:
    yield
    decoders.release()


@pytest.fixture
def without(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if the extra were not installed."""
    monkeypatch.setattr(client, "find_spec", lambda name: None)


# --- Draco


def draco(glb: GlbWriter, data: bytes, *, count: int = 4, fallback: bool = False) -> None:
    ids = {"POSITION": 1, "COLOR_0": 0}
    glb.json["accessors"] = [
        {"componentType": 5126, "count": count, "type": "VEC3"},
        {"componentType": 5121, "count": count, "type": "VEC4", "normalized": True},
        {"componentType": 5125, "count": 6, "type": "SCALAR"},
    ]
    if fallback:
        glb.json["accessors"][0]["bufferView"] = glb.view(CORNERS.tobytes())
        glb.json["accessors"][1]["bufferView"] = glb.view(bytes(16))
        glb.json["accessors"][2]["bufferView"] = glb.view(TRIANGLES.tobytes())
    packed = {"bufferView": glb.view(data), "attributes": ids}
    glb.json["meshes"] = [
        {
            "primitives": [
                {
                    "attributes": {"POSITION": 0, "COLOR_0": 1},
                    "indices": 2,
                    "extensions": {"KHR_draco_mesh_compression": packed},
                }
            ]
        }
    ]
    glb.json["extensionsRequired"] = ["KHR_draco_mesh_compression"]


def draco_bytes() -> bytes:
    library = pytest.importorskip("DracoPy")
    colors = np.array([[255, 0, 51, 255]] * 4, dtype=np.uint8)
    encoded: bytes = library.encode(
        CORNERS, TRIANGLES, quantization_bits=14, colors=colors, preserve_order=True
    )
    return encoded


def test_draco_meshes_are_read(glb: GlbWriter, tmp_path: Path) -> None:
    draco(glb, draco_bytes())
    scene = load(glb, tmp_path)
    found = np.array(drawn(scene))
    assert found == pytest.approx(np.array(corners_of(CORNERS[TRIANGLES])), abs=1e-4)
    colors = scene.meshes[0].colors
    assert colors is not None
    assert colors[0].tolist() == [1.0, 0.0, 0.2, 1.0]


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda data: data[:40], "not valid Draco compression"),
        (lambda data: b"DRACO" + bytes(200), "not valid Draco compression"),
        (lambda data: b"", "not valid Draco compression"),
    ],
)
def test_damaged_draco_is_one_line(damage: Any, message: str, glb: Any, tmp_path: Path) -> None:
    draco(glb, damage(draco_bytes()))
    with pytest.raises(SceneError, match=message):
        load(glb, tmp_path)


def test_draco_must_hold_what_its_accessors_say(glb: GlbWriter, tmp_path: Path) -> None:
    draco(glb, draco_bytes(), count=5)
    with pytest.raises(SceneError, match="accessor 0: 5 elements of 3 numbers, but its mesh"):
        load(glb, tmp_path)


@pytest.mark.usefixtures("without")
def test_without_its_library_draco_needs_data_of_its_own(glb: GlbWriter, tmp_path: Path) -> None:
    draco(glb, b"DRACO", fallback=True)
    assert drawn(load(glb, tmp_path)) == corners_of(CORNERS[TRIANGLES])


@pytest.mark.usefixtures("without")
def test_a_missing_library_is_named_with_its_cure(glb: GlbWriter, tmp_path: Path) -> None:
    draco(glb, b"DRACO")
    cure = r"needs the package DracoPy: pip install 'ssdo_gl\[compression\]'"
    with pytest.raises(SceneError, match=cure):
        load(glb, tmp_path)


# --- meshopt


def meshopt(
    glb: GlbWriter, array: NDArray[Any], kind: str, filter_name: str = "NONE", **more: Any
) -> int:
    """Return a buffer view of a compressed array."""
    library = pytest.importorskip("meshopt")
    data = library.encode_gltf_buffer(array, kind)
    size = array.itemsize * (1 if kind == "TRIANGLES" else array.shape[1])
    count = array.size if kind == "TRIANGLES" else len(array)
    view = glb.view(data)
    packed = {**glb.json["bufferViews"][view], "count": count, "byteStride": size, "mode": kind}
    packed |= {"filter": filter_name, **more}
    glb.json["bufferViews"][view] = {
        "buffer": 1,
        "byteLength": count * size,
        "extensions": {"EXT_meshopt_compression": packed},
    }
    return view


def meshopt_triangles(glb: GlbWriter, **more: Any) -> None:
    glb.json["accessors"] = [
        {
            "bufferView": meshopt(glb, CORNERS, "ATTRIBUTES", **more),
            "componentType": 5126,
            "count": 4,
            "type": "VEC3",
        },
        {
            "bufferView": meshopt(glb, TRIANGLES, "TRIANGLES"),
            "componentType": 5125,
            "count": 6,
            "type": "SCALAR",
        },
    ]
    glb.json["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]
    glb.json["extensionsRequired"] = ["EXT_meshopt_compression"]


def test_meshopt_buffers_are_read(glb: GlbWriter, tmp_path: Path) -> None:
    meshopt_triangles(glb)
    assert drawn(load(glb, tmp_path)) == corners_of(CORNERS[TRIANGLES])


def test_meshopt_filters_are_undone(glb: GlbWriter, tmp_path: Path) -> None:
    library = pytest.importorskip("meshopt")
    meshopt_triangles(glb)
    normals = np.array([[0.6, 0.0, 0.8, 0.0]] * 4, dtype="<f4")
    rows = library.encode_filter_oct(normals, 4, 8)
    view = meshopt(glb, rows, "ATTRIBUTES", "OCTAHEDRAL")
    glb.json["accessors"].append(
        {
            "bufferView": view,
            "componentType": 5120,
            "normalized": True,
            "count": 4,
            "type": "VEC3",
        }
    )
    glb.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 2
    found = load(glb, tmp_path).meshes[0].normals
    assert found is not None
    assert found[0] == pytest.approx([0.6, 0.0, 0.8], abs=0.01)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"count": 1 << 30}, "elements of 12 bytes: at most"),
        ({"count": 100}, "not valid meshopt compression"),
        ({"byteStride": 10}, "not valid meshopt compression"),
        ({"byteLength": 1 << 20}, "reaches beyond its buffer"),
        ({"mode": "LINES"}, "not valid meshopt compression"),
        ({"byteOffset": 4}, "not valid meshopt compression"),
    ],
)
def test_damaged_meshopt_is_one_line(more: Any, message: str, glb: Any, tmp_path: Path) -> None:
    meshopt_triangles(glb, **more)
    with pytest.raises(SceneError, match=message):
        load(glb, tmp_path)


def test_unpacked_bytes_are_counted(
    glb: GlbWriter, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    meshopt_triangles(glb)
    monkeypatch.setattr(document, "MAX_UNPACKED", 60)
    with pytest.raises(SceneError, match="6 elements of 4 bytes: at most 60 bytes in all"):
        load(glb, tmp_path)


# --- the process that decodes


def test_what_ends_the_decoder_is_one_line_and_another_starts(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    worker = tmp_path / "worker.py"
    text = client.WORKER.read_text(encoding="utf-8")
    fault = '    import os\n    os.abort() if data == b"x" else None\n    return [np.zeros(3)]\n'
    worker.write_text(text.replace("    import DracoPy\n", fault), encoding="utf-8")
    monkeypatch.setattr(client, "WORKER", worker)
    monkeypatch.setattr(client, "find_spec", lambda name: True)
    with pytest.raises(decoders.DecoderError, match="ended the decoder"):
        decoders.decoded_draco(b"x", {})
    assert decoders.decoded_draco(b"y", {})[0].tolist() == [0.0, 0.0, 0.0]


@pytest.mark.skipif(sys.platform != "linux", reason="other systems set no limit")
def test_a_decoder_has_so_much_memory(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    worker = tmp_path / "worker.py"
    text = client.WORKER.read_text(encoding="utf-8")
    worker.write_text(text.replace("    import DracoPy\n", "    np.empty(1 << 32, np.uint8)\n"))
    monkeypatch.setattr(client, "WORKER", worker)
    monkeypatch.setattr(client, "find_spec", lambda name: True)
    with pytest.raises(decoders.DecoderError, match="needs too much memory"):
        decoders.decoded_draco(b"", {})


def test_a_decoder_that_does_not_end_is_ended(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    worker = tmp_path / "worker.py"
    worker.write_text("while True:\n    pass\n", encoding="utf-8")
    monkeypatch.setattr(client, "WORKER", worker)
    monkeypatch.setattr(client, "find_spec", lambda name: True)
    monkeypatch.setattr(client, "MOST_SECONDS", 0.2)
    with pytest.raises(decoders.DecoderError, match=r"took more than 0\.2 s"):
        decoders.decoded_draco(b"x", {})


def test_too_large_an_answer_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    data = draco_bytes()
    monkeypatch.setattr(client, "MOST_BYTES", 20)
    decoders.release()
    with pytest.raises(decoders.DecoderError, match="too large"):
        decoders.decoded_draco(data, {})


# --- textures

COLOR = (200, 40, 10, 128)


def ktx2_texture(data: bytes) -> Texture:
    pytest.importorskip("opengl_basisu")
    return read_texture(data, "a.glb", "wood")


@pytest.mark.parametrize("size", [(8, 4), (5, 7)])
def test_basis_textures_are_read(size: tuple[int, int]) -> None:
    pixels = ktx2_texture(ktx2(COLOR, size)).pixels
    assert pixels.shape == (size[1], size[0], 4)
    assert np.all(pixels == COLOR)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (ktx2(COLOR, (8, 8))[:90], "truncated KTX2"),
        (ktx2(COLOR, (8, 8))[:200], "not a readable image"),
        (ktx2(COLOR, (8, 8), vulkan_format=146), "Vulkan format 146: expected Basis Universal"),
        (ktx2(COLOR, (8, 8), header_size=(40000, 4)), "40000 x 4 pixels"),
        (ktx2(COLOR, (8, 8), header_size=(16384, 16384)), "at most 67108864 in all"),
        (ktx2(COLOR, (8, 8), unpacked=1 << 40), "a level is too long"),
        (ktx2(COLOR, (8, 8), header_size=(64, 64)), "not a readable image"),
    ],
)
def test_damaged_basis_is_one_line(data: bytes, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        ktx2_texture(data)


def encoded(kind: str) -> bytes:
    stream = io.BytesIO()
    options = {"lossless": True} if kind == "WEBP" else {}
    Image.new("RGBA", (4, 4), COLOR).save(stream, kind, **options)
    return stream.getvalue()


KINDS = {
    "KHR_texture_basisu": ktx2(COLOR, (4, 4)),
    "EXT_texture_webp": encoded("WEBP"),
    "MSFT_texture_dds": encoded("DDS"),
}


def textured(glb: GlbWriter, extension: str, *, fallback: bool) -> None:
    datas = [KINDS[extension], encoded("PNG")]
    glb.json["images"] = [{"bufferView": glb.view(data)} for data in datas]
    texture: dict[str, Any] = {"extensions": {extension: {"source": 0}}}
    glb.json["textures"] = [texture | ({"source": 1} if fallback else {})]
    if not fallback:
        glb.json["extensionsRequired"] = [extension]
    base = {"baseColorTexture": {"index": 0}}
    glb.json["materials"] = [{"pbrMetallicRoughness": base}]
    glb.json["meshes"] = [{"primitives": [{**glb.triangle(), "material": 0}]}]


@pytest.mark.parametrize("extension", KINDS)
def test_textures_of_every_extension(extension: str, glb: GlbWriter, tmp_path: Path) -> None:
    pytest.importorskip("opengl_basisu")
    textured(glb, extension, fallback=False)
    texture = load(glb, tmp_path).materials[0].albedo_texture
    assert texture is not None
    assert np.all(texture.pixels == COLOR)


@pytest.mark.usefixtures("without")
def test_without_its_library_a_texture_is_a_note(glb: GlbWriter, tmp_path: Path) -> None:
    textured(glb, "KHR_texture_basisu", fallback=False)
    scene = load(glb, tmp_path)
    assert scene.materials[0].albedo_texture is None
    (note,) = [note for note in scene.notes if "texture not used" in note]
    assert "needs the package opengl_basisu: pip install 'ssdo_gl[compression]'" in note


@pytest.mark.usefixtures("without")
def test_the_plain_image_beside_it_does_as_well(glb: GlbWriter, tmp_path: Path) -> None:
    textured(glb, "KHR_texture_basisu", fallback=True)
    scene = load(glb, tmp_path)
    assert scene.materials[0].albedo_texture is not None
    assert not any("texture not used" in note for note in scene.notes)
