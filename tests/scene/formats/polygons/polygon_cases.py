"""Polygon files as exporters write them, each with its area and colours."""

from __future__ import annotations

import struct
from dataclasses import dataclass

Bytes = tuple[int, int, int]
# A pyramid: a square base of area 1 and four sides, apex over the middle at height 1.
PYRAMID = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)]
FACES = [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
AREA = 1.0 + 4.0 * 0.5 * 1.25**0.5
SQUARE = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
ORANGE, BLUE = (255, 128, 0), (0, 0, 255)


@dataclass(frozen=True)
class Case:
    """A file, its right area, and the sRGB bytes of its vertices (none: no colours)."""

    suffix: str
    content: bytes
    area: float
    colors: frozenset[Bytes] = frozenset()


def header(form: str, vertices: int, faces: str, properties: str = "", extra: str = "") -> str:
    return (
        f"ply\nformat {form} 1.0\n{extra}element vertex {vertices}\nproperty float x\n"
        f"property float y\nproperty float z\n{properties}{faces}end_header\n"
    )


LIST = "property list uchar int vertex_indices\n"


def faces(count: int, more: str = "", kind: str = LIST) -> str:
    return f"element face {count}\n{kind}{more}"


def triangle(rows: str, properties: str, face: str = "3 0 1 2", more: str = "") -> bytes:
    points = ["0 0 0", "1 0 0", "0 1 0"]
    body = "".join(f"{point} {rows}\n" for point in points)
    return (header("ascii", 3, faces(1, more), properties) + body + face + "\n").encode()


def colored(kind: str, values: str, names: str = "red green blue") -> bytes:
    return triangle(values, "".join(f"property {kind} {name}\n" for name in names.split()))


def binary(order: str, form: str, newline: bytes = b"\n", tail: bytes = b"") -> bytes:
    body = b"".join(struct.pack(f"{order}3f", *point) for point in PYRAMID)
    for face in FACES:
        body += struct.pack(f"{order}B{len(face)}i", len(face), *face)
    return header(form, 5, faces(5)).encode().replace(b"\n", newline) + body + tail


def beginning(first: bytes) -> bytes:
    """Return the pyramid, its first coordinate one of almost 0 that begins like a line."""
    data = binary("<", "binary_little_endian")
    at = data.index(b"end_header\n") + len(b"end_header\n")
    return data[:at] + first + b"\0\0\0" + data[at + 4 :]


def text_pyramid(between: str = "") -> str:
    points = "".join("{} {} {}\n".format(*point) for point in PYRAMID)
    rows = "".join(" ".join(map(str, (len(face), *face))) + "\n" for face in FACES)
    return header("ascii", 5, faces(5)) + points + between + rows


def with_texcoords() -> bytes:
    points = "".join("{} {} {}\n".format(*point) for point in PYRAMID)
    rows = "".join(
        " ".join(map(str, (len(f), *f, 2 * len(f), *[0.5] * (2 * len(f))))) + "\n" for f in FACES
    )
    more = "property list uchar float texcoord\n"
    return (header("ascii", 5, faces(5, more)) + points + rows).encode()


def binary_with_texcoords() -> bytes:
    body = b"".join(struct.pack("<3f", *point) for point in PYRAMID)
    for face in FACES:
        n = len(face)
        body += struct.pack(f"<B{n}iB{2 * n}fB", n, *face, 2 * n, *[0.5] * (2 * n), 7)
    more = "property list uchar float texcoord\nproperty uchar flags\n"
    return header("binary_little_endian", 5, faces(5, more)).encode() + body


STRIPS = "element tristrips 1\nproperty list int int vertex_indices\n"
STRIP_POINTS = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 0 0\n3 0 0\n2 1 0\n"
EDGES = "element edge 2\nproperty int vertex1\nproperty int vertex2\n"
FACE_RGB = "property uchar red\nproperty uchar green\nproperty uchar blue\n"
MATERIALS = "element material 2\n" + "".join(
    f"property uchar diffuse_{name}\n" for name in ("red", "green", "blue")
)
TWO_FACES = "3 0 1 2 255 128 0\n3 0 2 3 0 0 255\n"


def stl(attributes: list[int], head: bytes = b"", count: int = 2, tail: bytes = b"") -> bytes:
    data = head.ljust(80, b"\0") + struct.pack("<I", count)
    corners = [(0, 0, 0, 1, 0, 0, 1, 1, 0), (0, 0, 0, 1, 1, 0, 0, 1, 0)]
    for attribute, nine in zip(attributes, corners, strict=True):
        data += struct.pack("<12fH", 0, 0, 1, *nine, attribute)
    return data + tail


def text_stl(name: bytes, end: bytes = b"endsolid\n", normal: bytes = b"0 0 1") -> bytes:
    data = b"solid " + name + b"\n"
    for nine in ("000100110", "000110010"):
        data += b"facet normal " + normal + b"\nouter loop\n"
        for i in (0, 3, 6):
            data += b"vertex " + " ".join(nine[i : i + 3]).encode() + b"\n"
        data += b"endloop\nendfacet\n"
    return data + end


def off(keyword: str, vertices: str, *rows: str) -> bytes:
    return (f"{keyword}\n4 {len(rows)} 0\n{vertices}" + "".join(f"{r}\n" for r in rows)).encode()


ONE = frozenset({ORANGE})
BOTH = frozenset({ORANGE, BLUE})
MAGICS = b"COLOR=\xff\x80\x00\xff,MATERIAL="
FIVE_BIT_BLUE = 31 << 10  # Materialise: red lowest
CASES = {
    # PLY: the body
    "binary triangles and quads": Case(".ply", binary("<", "binary_little_endian"), AREA),
    "binary big endian": Case(".ply", binary(">", "binary_big_endian"), AREA),
    "binary, header with CR LF": Case(".ply", binary("<", "binary_little_endian", b"\r\n"), AREA),
    "binary, header with CR": Case(".ply", binary("<", "binary_little_endian", b"\r"), AREA),
    "binary, trailing bytes": Case(
        ".ply", binary("<", "binary_little_endian", tail=b"12345"), AREA
    ),
    "binary, first byte LF": Case(".ply", beginning(b"\n"), AREA),
    "binary, first byte CR": Case(".ply", beginning(b"\r"), AREA),
    "text": Case(".ply", text_pyramid().encode(), AREA),
    "blank line after vertices": Case(".ply", text_pyramid("\n \n").encode(), AREA),
    "CR line ends": Case(".ply", text_pyramid().replace("\n", "\r").encode(), AREA),
    "CR LF line ends": Case(".ply", text_pyramid().replace("\n", "\r\n").encode(), AREA),
    "byte order mark": Case(".ply", b"\xef\xbb\xbf" + text_pyramid().encode(), AREA),
    "a row over several lines": Case(
        ".ply", text_pyramid().replace("4 0 3 2 1", "4 0\n3 2\n1").encode(), AREA
    ),
    "second list property": Case(".ply", with_texcoords(), AREA),
    "binary second list property": Case(".ply", binary_with_texcoords(), AREA),
    "tristrips": Case(
        ".ply", (header("ascii", 7, STRIPS) + STRIP_POINTS + "8 0 1 2 3 -1 4 5 6\n").encode(), 1.5
    ),
    "binary tristrips": Case(
        ".ply",
        header("binary_big_endian", 4, STRIPS).encode()
        + struct.pack(">12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0)
        + struct.pack(">6i", 5, 0, 1, 2, 3, -1),
        1.0,
    ),
    "tristrips beside no faces": Case(
        ".ply",
        (
            header("ascii", 4, faces(0, "property list uchar float texcoord\n") + STRIPS)
            + SQUARE
            + "4 0 1 3 2\n"
        ).encode(),
        1.0,
    ),
    "elements before vertices and after faces": Case(
        ".ply",
        (
            header("ascii", 4, faces(1) + EDGES, extra="element camera 1\nproperty float view\n")
            + f"5.5\n{SQUARE}4 0 1 2 3\n0 1\n1 2\n"
        ).encode(),
        1.0,
    ),
    "faces before vertices": Case(
        ".ply",
        (
            "ply\nformat ascii 1.0\nelement face 1\n" + LIST + "element vertex 4\nproperty int x\n"
            "property short y\nproperty double z\nend_header\n4 0 1 2 3\n" + SQUARE
        ).encode(),
        1.0,
    ),
    "other integer types": Case(
        ".ply",
        (header("ascii", 4, faces(1, kind="property list int32 uint16 vertex_index\n")) + SQUARE
         + "4 0 1 2 3\n").encode(),
        1.0,
    ),
    "latin-1 comment": Case(
        ".ply", text_pyramid().replace("element v", "comment caf\xe9\nelement v").encode("latin-1"),
        AREA,
    ),
    "NaN as C on Windows prints it": Case(
        ".ply", triangle("-1.#IND", "property float quality\n"), 0.5
    ),
    "two properties of one name": Case(
        ".ply",
        triangle("", "", "3 0 1 2 1 5", "property list uchar int vertex_indices\n"),
        0.5,
    ),
    "a list and a number of one name": Case(
        ".ply", triangle("", "", "3 0 1 2 5", "property int vertex_indices\n"), 0.5
    ),
    # PLY: colours
    "bytes": Case(".ply", colored("uchar", "255 128 0"), 0.5, ONE),
    "integers": Case(".ply", colored("int", "255 128 0"), 0.5, ONE),
    "two bytes": Case(".ply", colored("ushort", "65535 32896 0"), 0.5, ONE),
    "floats to 1": Case(".ply", colored("float", "1 0.50196 0"), 0.5, ONE),
    "floats to 255": Case(".ply", colored("float", "255 128 0"), 0.5, ONE),
    "short names": Case(".ply", colored("uchar", "255 128 0", "r g b"), 0.5, ONE),
    "diffuse names": Case(
        ".ply", colored("uchar", "255 128 0", "diffuse_red diffuse_green diffuse_blue"), 0.5, ONE
    ),
    "splats": Case(
        ".ply", colored("float", "1.77246 0.00695 -1.77246", "f_dc_0 f_dc_1 f_dc_2"), 0.5, ONE
    ),
    "capital names": Case(".ply", colored("uchar", "255 128 0", "Red Green Blue"), 0.5, ONE),
    "unusable colours": Case(
        ".ply", colored("float", "nan -5 inf"), 0.5, frozenset({(0, 0, 0)})
    ),
    "face colours": Case(
        ".ply",
        (header("ascii", 4, faces(2, FACE_RGB)) + SQUARE + TWO_FACES).encode(),
        1.0,
        BOTH,
    ),
    "face colours of quads": Case(
        ".ply",
        (header("ascii", 4, faces(1, FACE_RGB)) + SQUARE + "4 0 1 2 3 255 128 0\n").encode(),
        1.0,
        ONE,
    ),
    "colours of materials": Case(
        ".ply",
        (
            header("ascii", 4, faces(2, "property int material_index\n") + MATERIALS)
            + f"{SQUARE}3 0 1 2 1\n3 0 2 3 0\n0 0 255\n255 128 0\n"
        ).encode(),
        1.0,
        BOTH,
    ),
    # OFF
    "OFF": Case(".off", off("OFF", SQUARE, "4 0 1 2 3"), 1.0),
    "no keyword": Case(".off", off("OFF", SQUARE, "4 0 1 2 3")[4:], 1.0),
    "counts after the keyword": Case(
        ".off", b"OFF 4 1 4\n" + SQUARE.encode() + b"4 0 1 2 3\n", 1.0
    ),
    "no count of edges": Case(".off", b"OFF\n4 1\n" + SQUARE.encode() + b"4 0 1 2 3\n", 1.0),
    "comments and blank lines": Case(
        ".off", b"OFF # caf\xe9\n\n# x\n4 1 0\n" + SQUARE.encode() + b"\n4 0 1 2 3 # last\n", 1.0
    ),
    "OFF with CR": Case(".off", off("OFF", SQUARE, "4 0 1 2 3").replace(b"\n", b"\r"), 1.0),
    "OFF faces over several lines": Case(
        ".off", off("OFF", SQUARE, "3 0\n1\n2", "3\n0 2\n3 "), 1.0
    ),
    "OFF vertices on one line": Case(
        ".off", off("OFF", SQUARE.replace("\n", " ") + "\n", "4 0 1 2 3"), 1.0
    ),
    "OFF counts on three lines": Case(
        ".off", b"OFF\n4\n2\n5\n" + SQUARE.encode() + b"3 0 1 2\n3 0 2 3\n", 1.0
    ),
    "OFF on one line": Case(
        ".off", off("OFF", SQUARE, "3 0 1 2", "3 0 2 3").replace(b"\n", b" "), 1.0
    ),
    "COFF": Case(
        ".off", off("COFF", SQUARE.replace("\n", " 255 128 0 255\n"), "4 0 1 2 3"), 1.0, ONE
    ),
    "COFF of three floats": Case(
        ".off", off("COFF", SQUARE.replace("\n", " 1.0 0.50196 0.0\n"), "4 0 1 2 3"), 1.0, ONE
    ),
    "colours without a C": Case(
        ".off", off("OFF", SQUARE.replace("\n", " 255 128 0\n"), "4 0 1 2 3"), 1.0, ONE
    ),
    "NOFF": Case(".off", off("NOFF", SQUARE.replace("\n", " 0 0 1\n"), "4 0 1 2 3"), 1.0),
    "STCNOFF": Case(
        ".off",
        off("STCNOFF", SQUARE.replace("\n", " 0 0 1 255 128 0 255 0.5 0.5\n"), "4 0 1 2 3"),
        1.0,
        ONE,
    ),
    "4OFF": Case(".off", off("4OFF", SQUARE.replace("\n", " 0.5\n"), "4 0 1 2 3"), 4.0),
    "OFF face colours": Case(
        ".off", off("OFF", SQUARE, "3 0 1 2 255 128 0", "3 0 2 3 0 0 255 255"), 1.0, BOTH
    ),
    "OFF face colours of floats": Case(
        ".off", off("OFF", SQUARE, "4 0 1 2 3 1.0 0.50196 0.0 1.0"), 1.0, ONE
    ),
    "OFF colour map entries": Case(".off", off("OFF", SQUARE, "3 0 1 2 5", "3 0 2 3 1"), 1.0),
    "OFF edges as faces": Case(".off", off("OFF", SQUARE, "4 0 1 2 3", "2 0 1", "1 3"), 1.0),
    # STL
    "STL": Case(".stl", stl([0, 0]), 1.0),
    "binary that begins with solid": Case(".stl", stl([0, 0], b"solid facet"), 1.0),
    "STL trailing bytes": Case(".stl", stl([0, 0], tail=b"\xff" * 33), 1.0),
    "STL without a count": Case(".stl", stl([0, 0], count=0), 1.0),
    "STL with too large a count": Case(".stl", stl([0, 0], count=2**32 - 1), 1.0),
    "VisCAM colours": Case(
        ".stl", stl([1 << 15 | 31, 1 << 15 | 31 << 10 | 16 << 5]), 1.0,
        frozenset({BLUE, (255, 132, 0)}),
    ),
    "Materialise colour of all": Case(".stl", stl([0, 0], MAGICS), 1.0, ONE),
    "Materialise colours": Case(".stl", stl([1 << 15, FIVE_BIT_BLUE], MAGICS), 1.0, BOTH),
    "text STL": Case(".stl", text_stl(b"part"), 1.0),
    "latin-1 name": Case(".stl", text_stl(b"caf\xe9"), 1.0),
    "missing endsolid": Case(".stl", text_stl(b"part", b""), 1.0),
    "bytes after endsolid": Case(".stl", text_stl(b"part", b"endsolid\n\0\xff\xfe"), 1.0),
    "unusable normal": Case(".stl", text_stl(b"a", normal=b"0 0 x"), 1.0),
    "STL in capitals with CR": Case(".stl", text_stl(b"A").upper().replace(b"\n", b"\r"), 1.0),
    "several solids": Case(".stl", text_stl(b"a") + text_stl(b"b"), 2.0),
    "no solid line": Case(".stl", text_stl(b"").partition(b"\n")[2], 1.0),
}  # fmt: skip
