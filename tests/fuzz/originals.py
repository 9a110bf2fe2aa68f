"""Small valid files of every kind, which the fuzz damages.

Each kind is a list of originals; an original is a mapping from name to content, and the
file of the first name is the one that is opened.
"""

from __future__ import annotations

import base64
import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from ktx2_writer import ktx2
from PIL import Image

from ssdo_gl.scene.load import builtin_names

Original = dict[str, bytes]
SCENES = Path(__file__).parents[2] / "scenes"


def image(form: str, mode: str = "RGB") -> bytes:
    pixels = np.arange(8 * 4 * 4, dtype=np.uint8).reshape(8, 4, 4)
    stream = io.BytesIO()
    Image.fromarray(pixels, "RGBA").convert(mode).save(stream, form)
    return stream.getvalue()


def hdr(width: int = 8) -> bytes:
    rows = bytes(range(128, 128 + 4 * width)) * 4
    return f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X {width}\n".encode() + rows


def exr(folder: Path) -> bytes:
    import OpenEXR

    path = folder / "original.exr"
    pixels = np.linspace(0, 2, 4 * 8 * 3, dtype=np.float32).reshape(4, 8, 3)
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, {"RGB": pixels}).write(str(path))
    return path.read_bytes()


SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype="<f4")


def gltf_document(buffer: bytes, uri: str | None) -> dict[str, Any]:
    """Return a textured square with a child, a light, a camera and morph targets that move."""
    f32, u16, vec = 5126, 5123, "VEC3"
    accessors = [
        {"bufferView": 0, "componentType": f32, "count": 4, "type": vec,
         "min": [0, 0, 0], "max": [1, 1, 0]},
        {"bufferView": 1, "componentType": u16, "count": 6, "type": "SCALAR"},
        {"bufferView": 2, "componentType": f32, "count": 4, "type": "VEC2"},
        {"componentType": f32, "count": 4, "type": vec, "sparse": {
            "count": 1, "indices": {"bufferView": 1, "componentType": u16},
            "values": {"bufferView": 0}}},
        {"bufferView": 3, "componentType": f32, "count": 2, "type": "SCALAR"},
        {"componentType": 5121, "count": 4, "type": "VEC4"},
        {"componentType": f32, "count": 4, "type": "VEC4"},
        {"bufferView": 0, "componentType": f32, "count": 2, "type": vec},
        {"bufferView": 3, "componentType": f32, "count": 2, "type": "SCALAR"},
    ]  # fmt: skip
    material = {
        "name": "wood",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.5, 0.5, 1],
            "baseColorTexture": {"index": 0},
            "metallicRoughnessTexture": {"index": 0, "texCoord": 1},
            "roughnessFactor": 0.5,
        },
        "normalTexture": {"index": 0, "scale": 0.5, "extensions": {
            "KHR_texture_transform": {"offset": [0.5, 0], "scale": [2, 2], "rotation": 1}}},
        "occlusionTexture": {"index": 0, "strength": 0.5},
        "emissiveFactor": [0, 0.1, 0],
        "alphaMode": "MASK",
        "alphaCutoff": 0.4,
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 3},
            "KHR_materials_ior": {"ior": 1.4},
            "KHR_materials_specular": {"specularFactor": 0.5, "specularTexture": {"index": 0}},
        },
    }  # fmt: skip
    primitive = {
        "attributes": {"POSITION": 0, "NORMAL": 0, "TEXCOORD_0": 2, "TEXCOORD_1": 2, "COLOR_0": 0,
                       "JOINTS_0": 5, "WEIGHTS_0": 6, "TANGENT": 6},
        "indices": 1, "material": 0, "mode": 4, "targets": [{"POSITION": 3, "TANGENT": 3}],
    }  # fmt: skip
    instancing = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}
    return {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual"],
        "scene": 0,
        "scenes": [{"nodes": [0, 2, 3, 4]}],
        "nodes": [
            {"mesh": 0, "children": [1], "rotation": [0, 0, 0, 1], "weights": [0.5]},
            {"mesh": 0, "matrix": np.eye(4).reshape(-1).tolist(), "extensions": instancing},
            {"camera": 0, "translation": [0, 0, 3], "scale": [1, 1, 1]},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"mesh": 0, "skin": 0, "weights": [0.2]},
        ],
        "skins": [{"joints": [1, 0]}],
        "animations": [{
            "name": "wave",
            "channels": [
                {"sampler": 0, "target": {"node": 0, "path": "translation"}},
                {"sampler": 0, "target": {"node": 3, "path": "scale"}},
                {"sampler": 1, "target": {"node": 4, "path": "weights"}},
            ],
            "samplers": [{"input": 4, "output": 7},
                         {"input": 4, "output": 8, "interpolation": "STEP"}],
        }],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "meshes": [{"primitives": [primitive], "weights": [0.1]}],
        "materials": [material],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 10497, "wrapT": 33071, "magFilter": 9728}],
        "images": [{"uri": "wood.png"}, {"bufferView": 0, "mimeType": "image/png"}],
        "accessors": accessors,
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12},
            {"buffer": 0, "byteOffset": 0, "byteLength": 32, "byteStride": 8},
            {"buffer": 0, "byteOffset": 8, "byteLength": 8},
        ],
        "buffers": [{"byteLength": len(buffer), **({} if uri is None else {"uri": uri})}],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "spot", "intensity": 5, "color": [1, 1, 1], "range": 9,
             "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}}]}},
    }  # fmt: skip


def gltf() -> list[Original]:
    buffer = SQUARE.tobytes() + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    inline = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    wood = {"wood.png": image("PNG")}
    text = json.dumps(gltf_document(buffer, inline), indent=1).encode()
    apart = json.dumps(gltf_document(buffer, "square.bin"), indent=1).encode()
    body = json.dumps(gltf_document(buffer, None)).encode()
    body += b" " * (-len(body) % 4)
    chunks = struct.pack("<II", len(body), 0x4E4F534A) + body
    chunks += struct.pack("<II", len(buffer), 0x004E4942) + buffer
    glb = struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
    return [
        {"a.gltf": text, **wood},
        {"a.gltf": apart, "square.bin": buffer, **wood},
        {"a.glb": glb, **wood},
    ]


def compressed() -> list[Original]:
    """Return the square with a Draco mesh, with meshopt buffers, and with a KTX2 texture."""
    import DracoPy
    import meshopt

    triangles = np.array([[0, 1, 2], [0, 2, 3]], dtype="<u4")
    draco = DracoPy.encode(SQUARE, triangles, preserve_order=True)
    rows = meshopt.encode_gltf_buffer(SQUARE, "ATTRIBUTES")
    attribute = {"componentType": 5126, "count": 4, "type": "VEC3"}
    index = {"componentType": 5125, "count": 6, "type": "SCALAR"}
    primitive: dict[str, Any] = {"attributes": {"POSITION": 0, "TEXCOORD_0": 0}, "material": 0}
    packed = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
    first = {"meshes": [{"primitives": [{**primitive, "indices": 1, "extensions": packed}]}],
             "accessors": [attribute, index],
             "bufferViews": [{"buffer": 0, "byteLength": len(draco)}]}  # fmt: skip
    first["meshes"][0]["primitives"][0]["attributes"].pop("TEXCOORD_0")
    part = {"buffer": 0, "byteLength": len(rows), "count": 4, "byteStride": 12,
            "mode": "ATTRIBUTES", "filter": "NONE"}  # fmt: skip
    view = {"buffer": 1, "byteLength": 48, "extensions": {"EXT_meshopt_compression": part}}
    second = {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 6}]}],
              "accessors": [{**attribute, "bufferView": 0}], "bufferViews": [view]}  # fmt: skip
    originals = []
    for name, document, data in (("a.drc", first, draco), ("a.bin", second, rows)):
        whole = {
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "materials": [{}],
            "buffers": [{"byteLength": len(data), "uri": name}],
            **document,
        }
        originals.append({"a.gltf": json.dumps(whole, indent=1).encode(), name: data})
    texture = b'[materials.m]\nalbedo_texture = "t.ktx2"\n'
    ball = b'[[object]]\nshape = "sphere"\nradius = 1\nmaterial = "m"\n'
    return [*originals, {"a.toml": texture + ball, "t.ktx2": ktx2((200, 100, 50, 255), (16, 8))}]


def obj() -> list[Original]:
    text = (
        "# square\nmtllib a.mtl b.mtl\no one\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0 0.5 0.5 0.5\n"
        "v 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nvn 0 1 0\ng top\ns 1\nusemtl wood #2\n"
        "f 1/1/1 2/2/1 3/3/1\nf -4//-1 -2//-1 -1//-1\nusemtl lamp\nf 1 2 3 4\nf 4 \\\n 3 2 1\n"
        "f 1 2\nl 1 2 3\np 1\n"
    )
    first = (
        "newmtl wood #2\nKd 0.5 0.5 0.5\nKs 0.1 0.1 0.1\nd 0.5\nmap_Kd -s 2 2 1 -clamp on "
        "wood.png\nmap_d wood.png\nbump -bm 0.5 wood.png\n"
    )
    second = "newmtl lamp\nKd xyz 0.5 0.5 0.5\nKe 3 2 1\nmap_Ke wood.png\nTr 0.2\n"
    second += "Ns 20\nPr 0.5\nPm 0.5\nmap_Pr wood.png\nmap_Pm wood.png\nnorm -s 3 3 wood.png\n"

    wood = image("PNG", "RGBA")
    return [
        {"a.obj": text.encode(), "a.mtl": first.encode(), "b.mtl": second.encode(),
         "wood.png": wood},
    ]  # fmt: skip


def ply() -> list[Original]:
    head = (
        "ply\nformat {} 1.0\ncomment TextureFile wood.png\nelement vertex 4\nproperty float x\n"
        "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
        "property uchar blue\nproperty float s\nproperty float t\nelement face 2\n"
        "property list uchar int vertex_indices\nproperty list uchar float texcoord\n"
        "property int texnumber\nelement tristrips 1\nproperty list int int vertex_indices\n"
        "end_header\n"
    )
    originals = []
    for order, form in (("<", "binary_little_endian"), (">", "binary_big_endian")):
        body = b"".join(
            struct.pack(f"{order}3f3B2f", *point, 255, 128, 0, point[0], point[1])
            for point in SQUARE.tolist()
        )
        for face in ((0, 1, 2, 3), (0, 2, 3)):
            n = len(face)
            body += struct.pack(f"{order}B{n}iB{2 * n}fi", n, *face, 2 * n, *[0.5] * 2 * n, 0)
        body += struct.pack(f"{order}6i", 5, 0, 1, 2, -1, 3)
        originals.append({"a.ply": head.format(form).encode() + body})
    rows = "".join(f"{x} {y} {z} 255 128 0 {x} {y}\n" for x, y, z in SQUARE.tolist())
    rows += "4 0 1 2 3 8 0 0 1 0 1 1 0 1 0\n3 0 2 3 6 0 0 1 1 0 1 0\n5 0 1 2 -1 3\n"
    originals.append({"a.ply": (head.format("ascii") + rows).encode()})
    return [{**original, "wood.png": image("PNG")} for original in originals]


def stl() -> list[Original]:
    corners = SQUARE[[0, 1, 2, 0, 2, 3]].reshape(2, 9)
    head = b"COLOR=\xff\x80\x00\xff".ljust(80) + struct.pack("<I", 2)
    binary = head + b"".join(struct.pack("<12fH", 0, 0, 1, *nine, 1 << 15) for nine in corners)
    text = "solid a\n"
    for nine in corners.tolist():
        text += "facet normal 0 0 1\nouter loop\n"
        text += "".join("vertex {} {} {}\n".format(*nine[i : i + 3]) for i in (0, 3, 6))
        text += "endloop\nendfacet\n"
    return [{"a.stl": binary}, {"a.stl": (text + "endsolid a\n").encode()}]


def off() -> list[Original]:
    rows = "".join(f"{x} {y} {z} 0 0 1 255 128 0 255\n" for x, y, z in SQUARE.tolist())
    plain = "".join(f"{x} {y} {z}\n" for x, y, z in SQUARE.tolist())
    return [
        {"a.off": f"CNOFF\n4 2 0\n{rows}3 0 1 2\n4 0 1 2\n3\n".encode()},
        {"a.off": f"OFF 4 2 5 # counts\n{plain}3 0 1 2 255 0 0\n3 0 2 3 0.5 0.5 0.5 1\n".encode()},
    ]


def toml() -> list[Original]:
    model = (
        '[environment]\nkind = "map"\npath = "sky.hdr"\n[materials.m]\nalbedo_texture = "w.png"\n'
        '[[object]]\nshape = "mesh"\npath = "a.obj"\nmaterial = "m"\n'
        "transform = { translate = [0, 1, 0], rotate = [0, 90, 0], scale = 2 }\n"
        "repeat = { count = 3, step = [1, 0, 0] }\n"
    )
    beside = {"sky.hdr": hdr(), "w.png": image("PNG"), "a.obj": obj()[0]["a.obj"]}
    scenes = [(SCENES / f"{name}.toml").read_bytes() for name in builtin_names()]
    return [{"a.toml": model.encode(), **beside}, *({"a.toml": scene} for scene in scenes)]


def images(folder: Path) -> list[Original]:
    texture = (
        b'[materials.m]\nalbedo_texture = "t.png"\n'
        b'[[object]]\nshape = "sphere"\nradius = 1\nmaterial = "m"\n'
    )
    originals = [
        {"a.toml": texture, "t.png": image(form, mode)}
        for form, mode in (("PNG", "RGBA"), ("PNG", "P"), ("PNG", "L"), ("JPEG", "RGB"),
                           ("JPEG", "CMYK"), ("WEBP", "RGB"), ("BMP", "RGB"), ("TGA", "RGBA"),
                           ("GIF", "P"), ("TIFF", "RGB"))
    ]  # fmt: skip
    for name, content in (("s.hdr", hdr()), ("s.exr", exr(folder))):
        sky = f'[environment]\nkind = "map"\npath = "{name}"\n[[object]]\nshape = "sphere"\n'
        originals.append({"a.toml": f"{sky}radius = 1\n".encode(), name: content})
    return originals


def presets() -> list[Original]:
    text = (
        '[settings]\nmethod = "bounce"\nsamples = 16\nradius = 0.5\nresolution_scale = 0.5\n'
        "size = [640, 360]\nexposure = 1.5\n[settings.overrides.bounce]\nstrength = 2.0\n"
    )
    flat = 'method = "ssao"\nsize = [640, 360]\nseed = 3\nantialias = 4\n'
    return [{"a.toml": text.encode()}, {"a.toml": flat.encode()}]


def of_kind(kind: str, folder: Path) -> list[Original]:
    """Return the originals of a kind; `folder` is a place for files on the way."""
    if kind == "images":
        return images(folder)
    makers = {
        "gltf": gltf,
        "compressed": compressed,
        "obj": obj,
        "ply": ply,
        "stl": stl,
        "off": off,
        "toml": toml,
    }
    return presets() if kind == "presets" else makers[kind]()


KINDS = ("toml", "gltf", "compressed", "obj", "ply", "stl", "off", "images", "presets")
