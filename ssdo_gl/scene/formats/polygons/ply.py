"""Parser of PLY, the Stanford polygon format: text, and binary of either byte order."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.formats.colors import linear_colors
from ssdo_gl.scene.formats.polygons.polygon_mesh import PolygonMesh, numbers

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
    "int64": "i8", "uint64": "u8",
}  # fmt: skip
_UVS = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texture_s", "texture_t"))
_COLORS = (
    ("red", "green", "blue", "alpha"),
    ("r", "g", "b", "a"),
    ("diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"),
)
# Of Gaussian splats (Kerbl et al. 2023): the colour that is the same from all sides, as a factor
# of the constant spherical harmonic.
_SPLAT, _BAND_0 = ("f_dc_0", "f_dc_1", "f_dc_2"), 0.5 / np.sqrt(np.pi)
# Rows whose lists differ in length are gathered so many at a time.
_ROWS_AT_ONCE = 1 << 16


@dataclass(frozen=True)
class _Property:
    name: str
    kind: np.dtype[Any]
    count_kind: np.dtype[Any] | None  # of lists


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


@dataclass
class _Rows:
    """The rows of an element: numbers by property, and for lists lengths and values."""

    element: _Element
    columns: dict[str, NDArray[Any]] = field(default_factory=dict)
    lengths: dict[str, NDArray[np.int64]] = field(default_factory=dict)

    def numbers(self, *names: str) -> FloatArray | None:
        """Return the columns of these names side by side, or None if one is missing."""
        if any(name not in self.columns or name in self.lengths for name in names):
            return None
        return np.stack([self.columns[name].astype(np.float64) for name in names], axis=1)

    def colors(self) -> FloatArray | None:
        """Return linear colours under any of the names in use, shape (N, 4), or None."""
        for names in _COLORS:
            values = self.numbers(*names)
            values = self.numbers(*names[:3]) if values is None else values
            if values is not None:
                kinds = {p.name: p.kind for p in reversed(self.element.properties)}
                return linear_colors(values, kinds[names[0]])
        harmonics = self.numbers(*_SPLAT)
        return (
            None if harmonics is None else linear_colors(np.clip(0.5 + _BAND_0 * harmonics, 0, 1))
        )


def parse_ply(data: bytes) -> list[PolygonMesh]:
    """Return the one mesh of the file.

    Raises
    ------
    ValueError
        What is wrong with it, in a few words.
    """
    elements, comments, form, body = _header(data)
    if form == "ascii":
        # Text becomes doubles, so that one reader serves both.
        body = numbers(body).tobytes()
    order: Literal["<", ">"] = ">" if form == "binary_big_endian" else "<"
    tables: dict[str, _Rows] = {}
    at = 0
    for element in elements:
        table, at = _read_element(element, body, at, None if form == "ascii" else order)
        tables.setdefault(element.name, table)
    return [_mesh(tables, comments)]


def _header(data: bytes) -> tuple[list[_Element], list[str], str, bytes]:
    """Return elements, comments, the form of the body and the body."""
    start = re.match(rb"(?:\xef\xbb\xbf)?ply[ \t]*(\r\n|\n|\r)", data)
    if start is None:
        raise ValueError("it does not begin with a line 'ply'")
    # The first byte of a binary body may look like half of another line end.
    line_end = rb"\r?\n" if start[1] == b"\n" else re.escape(start[1])
    end = re.search(rb"(?:^|[\r\n])[ \t]*end_header[ \t]*(?:" + line_end + rb"|$)", data)
    if end is None:
        raise ValueError("the header has no end_header")
    elements: list[_Element] = []
    comments = []
    form = ""
    # Comments may be in any encoding.
    for line in data[start.end() : end.start()].decode("latin-1").splitlines():
        key, *words = line.split() or [""]
        if key == "format" and words:
            form = words[0].lower()
        elif key == "comment":
            comments.append(line.split(None, 1)[1] if words else "")
        elif key == "element" and len(words) >= 2 and words[1].isdigit():
            elements.append(_Element(words[0].lower(), int(words[1][:18])))
        elif key == "property" and elements:
            elements[-1].properties.append(_property(words, line))
        elif elements and key not in ("", "obj_info"):
            # Before the elements it is a comment whose first word was forgotten.
            raise ValueError(f"header line {line[:60]!r} is not understood")
    if form not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ValueError(f"format {form[:40]!r} is not one of PLY")
    return elements, comments, form, data[end.end() :]


def _property(words: list[str], line: str) -> _Property:
    is_list = words[:1] == ["list"]
    kinds = [_TYPES.get(word.lower()) for word in words[is_list:-1]]
    if len(kinds) != (2 if is_list else 1) or None in kinds:
        raise ValueError(f"header line {line[:60]!r} is not understood")
    dtypes = [np.dtype(kind) for kind in kinds]
    return _Property(words[-1].lower(), dtypes[-1], dtypes[0] if is_list else None)


def _read_element(
    element: _Element, body: bytes, at: int, order: Literal["<", ">"] | None
) -> tuple[_Rows, int]:
    """Return the rows of one element that begins at a byte, and where the next begins.

    Parameters
    ----------
    order : str or None
        Byte order; None: all numbers are doubles.
    """
    kinds = [
        (np.dtype(np.float64), None if p.count_kind is None else np.dtype(np.float64))
        if order is None
        else (p.kind.newbyteorder(order), p.count_kind and p.count_kind.newbyteorder(order))
        for p in element.properties
    ]
    least = sum((kind if count is None else count).itemsize for kind, count in kinds)
    if element.count * least > len(body) - at:
        raise ValueError(f"it ends before its {element.count} rows of {element.name!r} do")
    table = _Rows(element)
    if not element.count or not least:
        lengths = np.zeros((0, len(kinds)), dtype=np.int64)
        _collect(table, [(np.arange(0), np.zeros(0, _row_type(kinds, [0] * len(kinds))))], lengths)
        return table, at
    first = _lengths(body, at, kinds, element.name)[0]
    row_type = _row_type(kinds, first)
    if element.count * row_type.itemsize <= len(body) - at:
        rows = np.frombuffer(body, row_type, element.count, at)
        if all(np.all(rows[f"n{i}"] == n) for i, n in enumerate(first) if kinds[i][1]):
            _collect(
                table,
                [(np.arange(len(rows)), rows)],
                np.broadcast_to(first, (len(rows), len(first))),
            )
            return table, at + rows.nbytes
    starts = np.empty(element.count, dtype=np.int64)
    lengths = np.empty((element.count, len(kinds)), dtype=np.int64)
    for row in range(element.count):
        starts[row] = at
        lengths[row], at = _lengths(body, at, kinds, element.name)
    _collect(table, _gathered(body, starts, lengths, kinds), lengths)
    return table, at


_Kinds = list[tuple["np.dtype[Any]", "np.dtype[Any] | None"]]


def _row_type(kinds: _Kinds, lengths: list[int]) -> np.dtype[Any]:
    """Return the layout of a row whose lists have these lengths."""
    fields: list[Any] = []
    for index, ((kind, count_kind), length) in enumerate(zip(kinds, lengths, strict=True)):
        if count_kind is None:
            fields.append((f"v{index}", kind))
        else:
            fields += [(f"n{index}", count_kind), (f"v{index}", kind, (length,))]
    return np.dtype(fields)


def _lengths(body: bytes, at: int, kinds: _Kinds, name: str) -> tuple[list[int], int]:
    """Return the lengths of the lists in the row at a byte (1 for numbers), and its end."""
    lengths = []
    for kind, count_kind in kinds:
        length = 1
        if count_kind is not None:
            if at + count_kind.itemsize > len(body):
                raise ValueError(f"it ends within its rows of {name!r}")
            if count_kind.itemsize == 1:
                length = body[at]
            else:
                number = np.frombuffer(body, count_kind, 1, at)[0]
                # In text that lies about its columns, a coordinate stands there.
                if not 0 <= number <= len(body) or number % 1:
                    raise ValueError(f"a list of {name!r} has {number} entries")
                length = int(number)
            at += count_kind.itemsize
        lengths.append(length)
        at += length * kind.itemsize
        if at > len(body):
            raise ValueError(f"it ends within its rows of {name!r}")
    return lengths, at


def _gathered(
    body: bytes, starts: NDArray[np.int64], lengths: NDArray[np.int64], kinds: _Kinds
) -> list[tuple[NDArray[np.int64], NDArray[Any]]]:
    """Return rows by groups of one layout: their numbers and their contents."""
    raw = np.frombuffer(body, np.uint8)
    layouts, layout_of_row = np.unique(lengths, axis=0, return_inverse=True)
    groups = []
    for number, layout in enumerate(layouts):
        row_type = _row_type(kinds, layout.tolist())
        rows = np.flatnonzero(layout_of_row.reshape(-1) == number)
        for part in np.array_split(rows, len(rows) // _ROWS_AT_ONCE + 1):
            data = raw[starts[part][:, None] + np.arange(row_type.itemsize)]
            groups.append((part, data.reshape(-1).view(row_type)))
    return groups


def _collect(
    table: _Rows,
    groups: list[tuple[NDArray[np.int64], NDArray[Any]]],
    lengths: NDArray[np.int64],
) -> None:
    """Fill a table with the columns of its rows, lists one after the other."""
    for index, item in enumerate(table.element.properties):
        if item.name in table.columns:
            continue  # of two properties of one name the first counts
        column = groups[0][1][f"v{index}"].reshape(-1)
        if len(groups) > 1:  # else it holds all rows in their order
            ends = np.cumsum(lengths[:, index])
            column = np.empty(int(ends[-1]), dtype=column.dtype)
            for rows, contents in groups:
                if len(rows):
                    values = contents[f"v{index}"].reshape(len(rows), -1)
                    begin = (ends - lengths[:, index])[rows]
                    column[begin[:, None] + np.arange(values.shape[1])] = values
        # Text says the same as the binary file it stands for, rounded alike.
        kind = item.kind if item.kind.kind == "f" else column.dtype.newbyteorder("=")
        table.columns[item.name] = column.astype(kind)
        if item.count_kind is not None:
            table.lengths[item.name] = lengths[:, index]


def _mesh(tables: dict[str, _Rows], comments: list[str]) -> PolygonMesh:
    vertices = tables.get("vertex")
    positions = None if vertices is None else vertices.numbers("x", "y", "z")
    if vertices is None or positions is None:
        raise ValueError("it has no vertices with x, y and z")
    uvs = [found for names in _UVS if (found := vertices.numbers(*names)) is not None]
    mesh = PolygonMesh(
        positions,
        corners=np.zeros(0, dtype=np.int64),
        counts=np.zeros(0, dtype=np.int64),
        normals=vertices.numbers("nx", "ny", "nz"),
        uvs=uvs[0] if uvs else None,
        colors=vertices.colors(),
        textures=[
            comment.split(None, 1)[1].strip()
            for comment in comments
            if comment.lower().startswith("texturefile ") and comment[12:].strip()
        ],
    )
    if all(name in vertices.columns for name in _SPLAT):
        mesh.notes.append("Gaussian splats: shown as points, in the colour that all sides share")
    faces, strips = tables.get("face"), tables.get("tristrips")
    name = _index_list(faces)
    if faces is not None and faces.element.count and name:
        mesh.corners = _indices(faces.columns[name])
        mesh.counts = faces.lengths[name]
        mesh.face_colors = _face_colors(faces, tables.get("material"))
        mesh.corner_uvs = _corner_uvs(faces, mesh.counts)
        number = faces.numbers("texnumber")
        mesh.face_textures = None if number is None else _indices(number[:, 0])
    elif strips is not None and (name := _index_list(strips)):
        mesh.corners = _unrolled(_indices(strips.columns[name]), strips.lengths[name])
        mesh.counts = np.full(len(mesh.corners) // 3, 3)
    return mesh


def _face_colors(faces: _Rows, materials: _Rows | None) -> FloatArray | None:
    """Return the colour of each face, or that of its material, shape (F, 4), or None."""
    colors = faces.colors()
    number = faces.numbers("material_index")
    palette = None if materials is None else materials.colors()
    if colors is not None or number is None or palette is None or not len(palette):
        return colors
    return palette[np.clip(_indices(number[:, 0]), 0, len(palette) - 1)]


def _index_list(table: _Rows | None) -> str:
    """Return the name of the list that holds vertex numbers, or an empty string."""
    lists = list(table.lengths) if table is not None else []
    named = [n for n in lists if n in ("vertex_indices", "vertex_index")]
    return (named + lists + [""])[0]


def _indices(values: NDArray[Any]) -> NDArray[np.int64]:
    """Return vertex numbers as integers; fractions, NaN and what no file can hold become -2."""
    if values.dtype.kind != "f":
        return values.astype(np.int64)
    usable = (np.abs(values) < 2.0**53) & (np.trunc(values) == values)
    return np.where(usable, values, -2.0).astype(np.int64)


def _corner_uvs(faces: _Rows, counts: NDArray[np.int64]) -> FloatArray | None:
    """Return texture coordinates of each corner, zero for faces without them."""
    name = next((n for n in faces.lengths if n in ("texcoord", "texcoords")), "")
    if not name:
        return None
    lengths = faces.lengths[name]
    given = lengths == 2 * counts
    result = np.zeros((int(counts.sum()), 2))
    values = faces.columns[name][np.repeat(given, lengths)]
    result[np.repeat(given, counts)] = values.reshape(-1, 2)
    return result


def _unrolled(indices: NDArray[np.int64], lengths: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the corners of the triangles in strips, which -1 or the next row ends."""
    strip = np.insert(indices, np.cumsum(lengths), -1)
    place = np.arange(len(strip))
    begin = np.maximum.accumulate(np.where(strip == -1, place + 1, 0))
    first = place[:-2][(begin[2:] <= place[:-2])] if len(strip) > 2 else place[:0]
    triangles = np.stack([strip[first], strip[first + 1], strip[first + 2]], axis=1)
    odd = (first - begin[first]) % 2 == 1
    triangles[odd] = triangles[odd][:, [1, 0, 2]]
    return triangles.reshape(-1)
