"""Files with bad content, from the file to the image: cleaned, drawn, and said so."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hard_cases.invariants import sane
from hard_cases.methods import METHODS, label, render

from ssdo_gl.scene.load import load_scene

# A floor and a standing quad, and whatever a scanner or an exporter may add to them.
FLOOR = "-1 0 1\n1 0 1\n1 0 -1\n-1 0 -1\n-0.5 0 -0.5\n0.5 0 -0.5\n0.5 1 -0.5\n-0.5 1 -0.5\n"
PLY = """ply
format ascii 1.0
element vertex 12
property float x
property float y
property float z
{more}element face 8
property list uchar int vertex_indices
end_header
{vertices}3 0 1 2
3 0 2 3
3 4 5 6
3 4 6 7
3 8 1 2
3 9 1 10
3 0 0 1
3 0 1 11
"""
TOML = """
[camera]
position = [1.5, 1.5, 2.5]
target = [0, 0.3, 0]
[environment]
kind = "{kind}"
{sky}
[render]
radius = 0.5
[[light]]
kind = "point"
position = [0.5, 1.5, 1]
intensity = [1, 1, 1]
[[object]]
shape = "mesh"
path = "model{suffix}"
"""
BAD = "nan 0 0\ninf 0 -1\n0 -inf 0\n1e-30 0 1\n"


def with_normals(vertices, normals):
    rows = zip(vertices.strip().split("\n"), normals, strict=True)
    return "".join(f"{row} {normal}\n" for row, normal in rows)


def ply():
    return ".ply", PLY.format(more="", vertices=FLOOR + BAD)


def ply_with_bad_normals():
    more = "property float nx\nproperty float ny\nproperty float nz\n"
    normals = ["0 0 0", "nan nan nan", "0 1 0", "inf 0 0", "0 0 1e-30", "0 0 1e30"]
    vertices = with_normals(FLOOR + BAD, normals + ["0 0 1"] * 6)
    return ".ply", PLY.format(more=more, vertices=vertices)


def obj():
    text = "".join(f"v {row}\n" for row in (FLOOR + BAD).strip().split("\n"))
    text += "vn 0 0 0\nvn nan 0 0\nvn 0 1 0\n"
    text += "f 1//1 2//2 3//3 4//3\nf 5 6 7 8\nf 9 2 3\nf 1 1 2\nf 1 2 12\nf 10 11 1\n"
    return ".obj", text


def stl():
    corners = [tuple(map(float, row.split())) for row in (FLOOR + BAD).strip().split("\n")]
    faces = [(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7), (8, 1, 2), (0, 0, 1), (9, 10, 1)]
    body = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(x for i in face for x in corners[i]), 0) for face in faces
    )
    return ".stl", bytes(80) + struct.pack("<I", len(faces)) + body


MODELS = {
    "NaN, Inf and coinciding vertices (.ply)": ply,
    "zero, NaN and Inf normals (.ply)": ply_with_bad_normals,
    "bad vertices and normals (.obj)": obj,
    "bad vertices, zero facet normals (.stl)": stl,
}


def write_scene(folder, model, kind="constant", sky="radiance = [0.4, 0.5, 0.6]"):
    suffix, content = model()
    data = content if isinstance(content, bytes) else content.encode()
    (folder / f"model{suffix}").write_bytes(data)
    file = folder / "scene.toml"
    file.write_text(TOML.format(kind=kind, sky=sky, suffix=suffix), encoding="utf-8")
    return file


@pytest.mark.parametrize("method", METHODS, ids=label)
@pytest.mark.parametrize("case", MODELS)
def test_bad_geometry_is_dropped_and_the_rest_is_drawn(
    device, shaders, record, tmp_path, method, case
):
    scene = load_scene(write_scene(tmp_path, MODELS[case]))
    assert any("dropped" in note for note in scene.notes), "the user must be told"
    images = render(device, shaders, scene, method, size=(32, 24))
    record(f"file: {case}", label(method), sane(images), 0, "insane values")
    # The floor and the quad fill at least a quarter of the picture.
    assert np.mean(images["depth"] > 0.0) > 0.25
    assert images["beauty"][..., :3].max() > 0.0


def write_exr(path, image):
    import OpenEXR

    channels = {name: np.ascontiguousarray(image[..., i]) for i, name in enumerate("RGB")}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, channels) as file:
        file.write(str(path))


def write_hdr(path, rgbe):
    height, width = rgbe.shape[:2]
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()
    path.write_bytes(head + rgbe.astype(np.uint8).tobytes())


def exr_sky(folder, *values):
    image = np.full((8, 16, 3), 0.5, np.float32)
    for i, value in enumerate(values):
        image[2 + i, 3 + 4 * i] = value
    write_exr(folder / "sky.exr", image)
    return 'path = "sky.exr"'


def hdr_sky(folder):
    """Return a sky with the largest number the format has: 255 / 256 * 2^127."""
    rgbe = np.full((8, 16, 4), 128, np.uint8)
    rgbe[2, 3] = 255
    write_hdr(folder / "sky.hdr", rgbe)
    return 'path = "sky.hdr"'


SKIES = {
    "sky with Inf texels (.exr)": lambda folder: exr_sky(folder, np.inf, np.inf),
    "sky with NaN and negative texels (.exr)": lambda folder: exr_sky(folder, np.nan, -3.0),
    "sky with texels of 1e30 (.exr)": lambda folder: exr_sky(folder, 0.999e30),
    "sky with texels of 1.7e38 (.hdr)": hdr_sky,
}


@pytest.mark.parametrize("method", METHODS, ids=label)
@pytest.mark.parametrize("case", SKIES)
def test_a_bad_sky_is_mended(device, shaders, record, tmp_path, method, case):
    scene = load_scene(write_scene(tmp_path, ply, "map", SKIES[case](tmp_path)))
    if "1e30" not in case:
        assert any("texels" in note for note in scene.notes), "the user must be told"
    images = render(device, shaders, scene, method, size=(32, 24))
    record(f"file: {case}", label(method), sane(images), 0, "insane values")
    assert images["beauty"][..., :3].max() > 0.0
