"""Parser of OFF, the Object File Format of Geomview, with its prefixes."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.formats.colors import linear_colors
from ssdo_gl.scene.formats.polygons.polygon_mesh import PolygonMesh
from ssdo_gl.wording import comma_hint


@dataclass(frozen=True)
class _Layout:
    """What a vertex holds, in this order."""

    numbers: int = 3
    homogeneous: bool = False
    normal: bool = False
    color: bool = False
    uv: bool = False

    @property
    def before_color(self) -> int:
        """How many numbers stand before the colour."""
        return self.numbers + 3 * self.normal


def parse_off(data: bytes) -> list[PolygonMesh]:
    """Return the one mesh of the file.

    Raises
    ------
    ValueError
        What is wrong with it, in a few words.
    """
    binary = re.match(rb"\s*([A-Za-z4]*OFF)[ \t]+BINARY[ \t]*\r?\n", data, re.IGNORECASE)
    if binary is not None:
        layout, _ = _header([[binary[1].decode("ascii")], ["3"]])
        return [_binary(data[binary.end() :], layout)]
    text = data.removeprefix(b"\xef\xbb\xbf").decode("latin-1")
    lines = [words for line in text.splitlines() if (words := line.split("#", 1)[0].split())]
    if not lines:
        raise ValueError("it is empty")
    layout, at = _header(lines)
    counts: list[int] = []
    # The third, of edges, may be missing: what then follows is a vertex, of several numbers.
    while len(counts) < 2 or (len(counts) == 2 and at < len(lines) and len(lines[at]) == 1):
        if at >= len(lines):
            raise ValueError("it does not say how many vertices and faces it holds")
        words, lines[at] = lines[at], lines[at][3 - len(counts) :]
        counts += [_integer(word) for word in words[: 3 - len(counts)]]
        at += not lines[at]
    vertex_count, face_count = counts[:2]
    if vertex_count + face_count > len(data):
        raise ValueError(f"it ends before its {vertex_count} vertices do")
    rows, at = _vertex_rows(lines, at, vertex_count, layout)
    mesh = _vertices(rows, layout)
    _add_faces(mesh, lines, at, face_count)
    return [mesh]


def _header(lines: list[list[str]]) -> tuple[_Layout, int]:
    """Return the layout, and the line on which the counts stand; cuts the keyword off."""
    # The count may follow at once.
    match = re.fullmatch(r"(ST)?(C?)(N?)(4?)(n?)OFF(\d*)", lines[0][0], re.IGNORECASE)
    if match is None:
        if not lines[0][0].isdigit():
            raise ValueError("it begins with neither OFF nor a count of vertices")
        return _Layout(), 0
    lines[0] = [match[6], *lines[0][1:]] if match[6] else lines[0][1:]
    at = 0 if lines[0] else 1
    numbers = 3
    if match[5]:
        if at >= len(lines):
            raise ValueError("it does not say how many vertices and faces it holds")
        numbers = _integer(lines[at].pop(0))
        at += not lines[at]
        if numbers != 3:
            raise ValueError(f"its space has {numbers} dimensions, not 3")
    four = bool(match[4])
    return _Layout(numbers + four, four, bool(match[3]), bool(match[2]), bool(match[1])), at


def _binary(data: bytes, layout: _Layout) -> PolygonMesh:
    """Return the mesh of a binary body: in Geomview's byte order, or in that of most machines."""
    width = layout.before_color + 4 * layout.color + 2 * layout.uv
    for order in (">", "<"):
        head = np.frombuffer(data[:12], f"{order}i4").astype(np.int64)
        if len(head) == 3 and head.min() >= 0:
            faces_at = 12 + 4 * width * int(head[0])
            if faces_at + 4 * int(head[1]) <= len(data):
                break
    else:
        raise ValueError("it ends before its vertices and faces do")
    rows = np.frombuffer(data[12:faces_at], f"{order}f4").astype(np.float64).reshape(-1, width)
    words = np.frombuffer(data[faces_at : len(data) - len(data) % 4], f"{order}i4").tolist()
    mesh = _vertices(rows, layout)
    # Some programs leave out how many numbers of a colour follow.
    walks = [_walked(words, int(head[1]), has_colors) for has_colors in (True, False)]
    known = [walk for walk in walks if walk is not None]
    if not known:
        raise ValueError(f"it ends before its {head[1]} faces do")
    counts, corners, _ = max(known, key=lambda walk: walk[2] == len(words))
    mesh.counts, mesh.corners = np.array(counts, np.int64), np.array(corners, np.int64)
    return mesh


def _walked(
    words: list[int], face_count: int, has_colors: bool
) -> tuple[list[int], list[int], int] | None:
    """Return corners of each face, all corners and where the faces end; None if they do not."""
    counts: list[int] = []
    corners: list[int] = []
    at = 0
    for _ in range(face_count):
        if at >= len(words) or not 0 <= words[at] < len(words) - at:
            return None
        counts.append(words[at])
        corners += words[at + 1 : at + 1 + words[at]]
        at += 1 + words[at]
        if has_colors:
            if at >= len(words) or not 0 <= words[at] <= 4:
                return None
            at += 1 + words[at]
    return (counts, corners, at) if at <= len(words) else None


def _integer(word: str) -> int:
    if not re.fullmatch(r"\d{1,15}", word):
        raise ValueError(f"{word[:40]!r} stands where a count or index is expected")
    return int(word)


def _vertex_rows(
    lines: list[list[str]], at: int, count: int, layout: _Layout
) -> tuple[FloatArray, int]:
    """Return the numbers of each vertex, and the line on which the faces begin."""
    rows = lines[at : at + count]
    least = layout.before_color + 3 * layout.color + 2 * layout.uv
    try:
        if len(rows) == count and len({len(row) for row in rows}) == 1 and len(rows[0]) >= least:
            return np.array(rows, dtype=np.float64).reshape(count, -1), at + count
        # Not a line for each vertex: then the header alone says where each ends.
        width = layout.before_color + 4 * layout.color + 2 * layout.uv
        words: list[str] = []
        while len(words) < width * count:
            if at >= len(lines):
                raise ValueError(f"it ends before its {count} vertices do")
            words += lines[at]
            at += 1
        rest = words[width * count :]
        if rest:
            at -= 1
            lines[at] = rest
        return np.array(words[: width * count], dtype=np.float64).reshape(count, width), at
    except ValueError as error:
        if "convert" in str(error):
            hint = comma_hint(str(error))
            raise ValueError(f"a vertex holds something else than numbers{hint}") from None
        raise


def _vertices(rows: FloatArray, layout: _Layout) -> PolygonMesh:
    positions = rows[:, :3]
    if layout.homogeneous:
        with np.errstate(divide="ignore"):
            positions = positions / rows[:, 3:4]
    start = layout.before_color
    end = rows.shape[1] - 2 * layout.uv
    # Colours without a C in the header are common; nothing else has 3 or 4 numbers >= 0.
    encoded = rows[:, start:end]
    colored = encoded.shape[1] in (3, 4) and (layout.color or bool(np.all(encoded >= 0.0)))
    return PolygonMesh(
        positions,
        corners=np.zeros(0, dtype=np.int64),
        counts=np.zeros(0, dtype=np.int64),
        normals=rows[:, layout.numbers : start] if layout.normal else None,
        uvs=rows[:, end : end + 2] if layout.uv else None,
        colors=linear_colors(encoded, _kind(encoded)) if colored and len(rows) else None,
    )


def _kind(encoded: FloatArray) -> np.dtype[np.uint8] | None:
    """Return what colours are written as: whole numbers with any above 1 are bytes."""
    whole = bool(np.all(encoded == np.floor(encoded))) and encoded.max(initial=0.0) > 1.0
    return np.dtype(np.uint8) if whole else None


def _add_faces(mesh: PolygonMesh, lines: list[list[str]], at: int, count: int) -> None:
    corners: list[int] = []
    counts: list[int] = []
    colors: dict[int, list[str]] = {}
    for face in range(count):
        if at >= len(lines):
            raise ValueError(f"it ends before its {count} faces do")
        words = lines[at]
        size = _integer(words[0])
        at += 1
        while len(words) < size + 1:
            if at >= len(lines):
                raise ValueError(f"it ends before its {count} faces do")
            words = words + lines[at]
            at += 1
        corners += [_integer(word) for word in words[1 : size + 1]]
        counts.append(size)
        rest = words[size + 1 :]
        if len(rest) >= 4 and len(lines) - at < count - face - 1:
            # Too few lines for the other faces: they follow on this one.
            at -= 1
            lines[at] = rest
        # One number would be an entry of a colour map that the file does not hold.
        elif len(rest) in (3, 4):
            colors[face] = rest
    mesh.corners = np.array(corners, dtype=np.int64)
    mesh.counts = np.array(counts, dtype=np.int64)
    if colors and mesh.colors is None:
        mesh.face_colors = _face_colors(colors, count)


def _face_colors(colors: dict[int, list[str]], count: int) -> FloatArray:
    """Return (count, 4) linear colours; grey for faces without one."""
    result = np.tile([0.8, 0.8, 0.8, 1.0], (count, 1))
    try:
        encoded = np.array([(*row, "nan")[:4] for row in colors.values()], dtype=np.float64)
    except ValueError:
        raise ValueError("the colour of a face is no number") from None
    no_alpha = np.isnan(encoded[:, 3])
    bytes_used = not any("." in word for row in colors.values() for word in row)
    linear = linear_colors(encoded, np.dtype(np.uint8) if bytes_used else None)
    linear[no_alpha, 3] = 1.0
    result[list(colors)] = linear
    return result
