"""Wavefront files as exporters write them: each fault once seen, with its right value."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from image_bytes import png

from ssdo_gl.color import linear_from_srgb
from ssdo_gl.scene.formats import Model, read_model

Files = dict[str, str | bytes]
Write = Callable[[Files], Path]
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
RED, GREEN, BLUE = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
CHEVRON = ["-1 -1 0", "0 -0.3 0", "1 -1 0", "0 1 0"]


@pytest.fixture
def read(write: Write) -> Callable[..., Model]:
    """Return a function from an .obj text, and files beside it, to the model."""
    return lambda text, beside=None: read_model(write({**(beside or {}), "a.obj": text}), "a")


def albedos(model: Model) -> list[tuple[float, float, float]]:
    return [model.materials[item.material].albedo for item in model.objects]


def two(first: str, second: str, library: str = "m.mtl") -> str:
    text = f"mtllib {library}\n{SQUARE}"
    return text + f"usemtl {first}\nf 1 2 3\nusemtl {second}\nf 1 3 4\n"


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("Material #25", "Material #26"),
        ("#1", "#2"),
        ("a  b", "a b"),
        ("caf\u00e9", "caf\u00ea"),
        ("\u4e00", "\u4e8c"),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "latin-1", "gbk"])
def test_names_stay_apart(first: str, second: str, encoding: str, read) -> None:
    try:
        text = two(first, second).encode(encoding)
        library = f"newmtl {first}\nKd 1 0 0\nnewmtl {second}\nKd 0 1 0\n".encode(encoding)
    except UnicodeEncodeError:
        pytest.skip("not in this encoding")
    assert albedos(read(text, {"m.mtl": library})) == [RED, GREEN]


def test_the_same_bytes_are_the_same_name_in_files_of_mixed_encoding(read) -> None:
    text = b"# caf\xe9\n" + two("\u00e9", "\u00ea").encode("utf-8")
    library = "newmtl \u00e9\nKd 1 0 0\nnewmtl \u00ea\nKd 0 1 0\n".encode()
    assert albedos(read(text, {"m.mtl": library})) == [RED, GREEN]


def test_comments_behind_names(read) -> None:
    library = "newmtl red # the warm one\nKd 1 0 0 # really\nnewmtl green\nKd 0 1 0\n"
    text = two("red", "green # grass", "m.mtl # the library")
    assert albedos(read(text, {"m.mtl": library})) == [RED, GREEN]


@pytest.mark.parametrize(
    ("statement", "names"),
    [
        ("a.mtl b.mtl", ["a.mtl", "b.mtl"]),
        ("my a.mtl  my b.MTL", ["my a.mtl", "my b.MTL"]),
        ("a.mtl\nmtllib b.mtl", ["a.mtl", "b.mtl"]),
        ('"a.mtl"\nmtllib sub\\b.mtl', ["a.mtl", "sub/b.mtl"]),
    ],
)
def test_several_libraries(statement: str, names: list[str], read) -> None:
    beside = dict(zip(names, ["newmtl r\nKd 1 0 0\n", "newmtl g\nKd 0 1 0\n"], strict=True))
    assert albedos(read(two("r", "g", statement), beside)) == [RED, GREEN]


def test_one_library_whose_name_looks_like_two(read) -> None:
    beside = {"a.mtl": "", "b.mtl": "", "a.mtl b.mtl": "newmtl r\nKd 1 0 0\n"}
    assert albedos(read(two("r", "r", "a.mtl b.mtl"), beside)) == [RED]


def test_each_missing_library_is_named(read) -> None:
    notes = read(two("r", "g", "a.mtl b.mtl")).notes
    assert [name for name in ("'a.mtl'", "'b.mtl'") if not any(name in n for n in notes)] == []


def test_an_unreadable_library_is_told(read, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = Path.read_bytes

    def refuse(path: Path) -> bytes:
        if path.suffix == ".mtl":
            raise PermissionError(13, "Permission denied")
        return whole(path)

    monkeypatch.setattr(Path, "read_bytes", refuse)
    model = read(two("r", "r"), {"m.mtl": "newmtl r\nKd 1 0 0\n"})
    assert albedos(model) == [(0.8, 0.8, 0.8)]
    assert any("materials not read" in n and "Permission denied" in n for n in model.notes)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_line_ends_and_byte_order_marks(end: str, mark: bytes, read) -> None:
    text, library = two("r", "g"), "newmtl r\nKd 1 0 0\nnewmtl g\nKd 0 1 0\n"
    model = read(
        mark + (SQUARE + text).replace("\n", end).encode(),
        {"m.mtl": mark + library.replace("\n", end).encode()},
    )
    assert albedos(model) == [RED, GREEN]


def test_one_face_without_coordinates_leaves_the_others_theirs(read) -> None:
    text = SQUARE + "vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 1 3 4\n"
    mesh = read(text).meshes[0]
    assert mesh.uvs[mesh.triangles].tolist() == [[[0, 1], [1, 1], [1, 0]], [[0, 1]] * 3]


@pytest.mark.parametrize("corner", ["{0}//{0}", "{0}/{0}", "{0}/{0}/{0}", "{0}/-9/-9", "{0}//0"])
def test_dangling_normals_and_coordinates_are_told(corner: str, read) -> None:
    text = SQUARE + "f " + " ".join(corner.format(i) for i in (1, 2, 3)) + "\n"
    model = read(text)
    assert model.meshes[0].normals is None
    assert model.meshes[0].uvs is None
    assert any("do not exist" in note for note in model.notes)


def test_some_vertices_with_colours(read) -> None:
    text = "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\nusemtl b\nf 3 4 5\n"
    model = read(text)
    assert model.meshes[0].colors.tolist() == [[1, 0, 0, 1], [1, 0, 0, 1], [1, 1, 1, 1]]
    assert model.meshes[1].colors is None
    assert albedos(model) == [(1.0, 1.0, 1.0), (0.8, 0.8, 0.8)]


def test_colours_to_255(read) -> None:
    text = "".join(f"v {point} 255 128 0\n" for point in ("0 0 0", "1 0 0", "0 1 0")) + "f 1 2 3\n"
    half = float(linear_from_srgb(np.array(128 / 255)))
    assert read(text).meshes[0].colors[0] == pytest.approx([1.0, half, 0.0, 1.0])


def test_lines_and_points_are_counted(read, write: Write, error_of: Callable[..., str]) -> None:
    model = read(SQUARE + "f 1 2\nf 1\nf 1 2 3\nl 1 2 3\np 1\n")
    assert len(model.meshes[0].triangles) == 1
    assert "not drawn: 3 lines" in model.notes
    assert "1 points drawn as small bodies" in model.notes
    assert "only 1 line" in error_of(write({"a.obj": SQUARE + "f 1 2\n"}))


@pytest.mark.parametrize("step", [1, -1])
def test_a_chevron_keeps_its_area_in_every_format(step: int, write: Write) -> None:
    points = CHEVRON[::step]
    rows = "\n".join(points) + "\n"
    files = {
        "a.obj": "".join(f"v {point}\n" for point in points) + "f 1 2 3 4\n",
        "a.ply": "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        f"{rows}4 0 1 2 3\n",
        "a.off": f"OFF\n4 1 0\n{rows}4 0 1 2 3\n",
    }
    folder = write(files).parent
    for name in files:
        mesh = read_model(folder / name, name).meshes[0]
        a, b, c = (mesh.positions[mesh.triangles[:, i]] for i in range(3))
        areas = 0.5 * np.cross(b - a, c - a)[:, 2] * step
        assert np.all(areas > 0.0)
        assert areas.sum() == pytest.approx(1.3)


def material(read, statements: str, beside: Files | None = None) -> tuple:
    library = {"m.mtl": f"newmtl r\n{statements}\n", **(beside or {})}
    model = read(two("r", "r"), library)
    return model.materials[0], model.notes


def test_alpha_of_a_colour_image_cuts_out(read) -> None:
    def leaf(alpha: list[int]) -> bytes:
        pixels = np.full((1, 2, 4), 255, dtype=np.uint8)
        pixels[0, :, 3] = alpha
        return png(pixels)

    for alpha, cutoff in (([0, 255], 0.5), ([255, 255], None), ([0, 0], None), ([200, 255], None)):
        found, _ = material(read, "map_Kd l.png", {"l.png": leaf(alpha)})
        assert found.alpha_cutoff == cutoff
        assert found.albedo_texture.pixels[0, :, 3].tolist() == alpha


@pytest.mark.parametrize(
    ("statement", "albedo"),
    [
        ("Kd xyz 0.4124564 0.2126729 0.0193339", RED),
        ("Kd 0.25", (0.25, 0.25, 0.25)),
        ("Kd spectral blue.rfl 1", (0.8, 0.8, 0.8)),
    ],
)
def test_other_forms_of_colours(statement: str, albedo: tuple[float, float, float], read) -> None:
    found, notes = material(read, statement)
    assert found.albedo == pytest.approx(albedo, abs=1e-5)
    assert any("spectral Kd is not read" in note for note in notes) == ("spectral" in statement)


@pytest.mark.parametrize("content", [b"", b"not an image", b"%!PS-Adobe-3.0 EPSF-3.0\n"])
def test_a_bad_texture_is_told_and_the_model_drawn(content: bytes, read) -> None:
    found, notes = material(read, "Kd 1 0 0\nmap_Kd t.png", {"t.png": content})
    assert found.albedo == RED
    assert found.albedo_texture is None
    assert any("texture not used" in note and "t.png" in note for note in notes)


def test_an_image_with_a_number_sign_in_its_name(read) -> None:
    image = png(np.full((1, 1, 3), 7, dtype=np.uint8))
    for name in ("wood #2.png", "wood.png # brown"):
        file = name if "#2" in name else "wood.png"
        found, _ = material(read, f"map_Kd {name}", {file: image})
        assert found.albedo_texture.pixels[0, 0, 0] == 7


def test_emission_beyond_single_precision_is_refused(
    write: Write, error_of: Callable[..., str]
) -> None:
    files: Files = {"m.mtl": "newmtl r\nKe 1e39 0 0\n", "a.obj": two("r", "r")}
    assert "'Ke 1e39 0 0': expected three finite numbers" in error_of(write(files))
