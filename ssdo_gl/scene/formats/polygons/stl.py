"""Parser of STL, text or binary, with the colours of binary files."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.formats.colors import linear_colors
from ssdo_gl.scene.formats.polygons.polygon_mesh import PolygonMesh, numbers

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER_BYTES = 84


def parse_stl(data: bytes) -> list[PolygonMesh]:
    """Return the one mesh of a binary file, or the solids of a text.

    Raises
    ------
    ValueError
        What is wrong with it, in a few words.
    """
    data = data.removeprefix(b"\xef\xbb\xbf")
    count = int.from_bytes(data[80:_HEADER_BYTES], "little")
    exact = len(data) == _HEADER_BYTES + _FACET.itemsize * count
    # Binary files may begin with "solid" too, and texts with blanks.
    text = re.match(rb"\s*(?:solid|facet)\b", data, re.IGNORECASE)
    words = re.search(rb"\bvertex\b", data, re.IGNORECASE)
    if text and not (exact and count) and (words or len(data) < _HEADER_BYTES):
        return _solids(data)
    return [_binary(data, count)]


def _binary(data: bytes, count: int) -> PolygonMesh:
    held = max(len(data) - _HEADER_BYTES, 0) // _FACET.itemsize
    # Some writers leave the count 0 or wrong: what is there counts, as in other viewers.
    if not held:
        raise ValueError("it holds no facet")
    facets = np.frombuffer(data, _FACET, min(count or held, held), _HEADER_BYTES)
    mesh = _mesh(facets["corners"].reshape(-1, 3).astype(np.float64))
    mesh.face_colors = _colors(data[:80], facets["attribute"])
    if count != held:
        drawn = f"{len(facets)} are drawn"
        mesh.notes.append(f"the file says it has {count} facets and holds {held}: {drawn}")
    return mesh


def _mesh(positions: FloatArray, name: str = "") -> PolygonMesh:
    corners = np.arange(len(positions))
    return PolygonMesh(positions, corners, np.full(len(positions) // 3, 3), name=name)


def _colors(header: bytes, attribute: NDArray[np.uint16]) -> FloatArray | None:
    """Return the colour of each facet, or None if the file has none.

    Five bits for each channel. VisCAM and SolidView: blue lowest, bit 15 marks a
    colour. Materialise Magics, which writes ``COLOR=`` and four bytes for the whole
    into the header: red lowest, bit 15 marks facets without a colour of their own. Where
    no facet has a bit, as others write it, none has a colour of its own: it is no black.
    """
    marked = (attribute >> 15) == 1
    channels = np.stack([attribute >> shift & 31 for shift in (10, 5, 0)], axis=1) / 31.0
    place = header.find(b"COLOR=")
    if 0 <= place <= len(header) - 10:
        whole = np.frombuffer(header, np.uint8, 3, place + 6) / 255.0
        is_plain = marked | (not attribute.any())
        return linear_colors(np.where(is_plain[:, None], whole, channels[:, ::-1]))
    if not marked.any():
        return None
    colors = linear_colors(channels)
    colors[~marked, :3] = 0.8
    return colors


def _solids(data: bytes) -> list[PolygonMesh]:
    """Return the solids of a text; nothing but its vertices and names is looked at."""
    # In small letters, so that the search need not try both for every byte.
    small = data.lower()
    lines = [match for match in re.finditer(rb"solid\b[^\r\n]*", small) if _begins(small, match)]
    starts = [match.start() for match in lines] or [0]
    ends = [*starts[1:], len(small)]
    meshes = []
    for index, (start, end) in enumerate(zip(starts, ends, strict=True)):
        name = data[start + len("solid") : lines[index].end()] if lines else b""
        rows = re.findall(rb"\bvertex\s+(\S+\s+\S+\s+\S+)", small[start:end])
        positions = numbers(b" ".join(rows)).reshape(-1, 3)
        if len(positions) % 3:
            raise ValueError("a facet has not three vertices")
        if len(positions):
            meshes.append(_mesh(positions, name.decode("latin-1").strip()))
    if not meshes:
        raise ValueError("it holds no facet")
    return meshes


def _begins(text: bytes, match: re.Match[bytes]) -> bool:
    """Return whether nothing but blanks stands before a match on its line."""
    before = text[max(match.start() - 80, 0) : match.start()]
    return before.rstrip(b" \t")[-1:] in (b"", b"\r", b"\n")
