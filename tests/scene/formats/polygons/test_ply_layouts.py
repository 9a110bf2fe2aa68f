"""Any layout that a PLY header can describe gives back what was written."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ssdo_gl.scene.formats.polygons.ply import parse_ply

TYPES = {
    "char": "b", "uchar": "B", "uint8": "B", "short": "h", "uint16": "H", "int": "i", "uint32": "I",
    "float": "f", "float64": "d",
}  # fmt: skip
COUNTS = ("uchar", "uint16", "int", "uint32")
INDICES = ("uchar", "short", "uint16", "int", "uint32")
VERTICES = 9

positions = st.lists(st.tuples(*[st.integers(-100, 100)] * 3), min_size=VERTICES, max_size=VERTICES)
polygons = st.lists(
    st.lists(st.integers(0, VERTICES - 1), min_size=0, max_size=7), min_size=1, max_size=12
)


@dataclass(frozen=True)
class Extra:
    """A property that is not looked at: a number or a list."""

    kind: str
    is_list: bool


extras = st.lists(st.builds(Extra, st.sampled_from(sorted(TYPES)), st.booleans()), max_size=3)


class Writer:
    """Writes numbers as text or as bytes of either order."""

    def __init__(self, form: str) -> None:
        self.form = form
        self.body = b""

    def number(self, kind: str, value: float) -> None:
        if self.form == "ascii":
            self.body += f"{value:g} ".encode()
        else:
            order = "<" if "little" in self.form else ">"
            self.body += struct.pack(order + TYPES[kind], value)

    def row(self, properties: list[tuple[str, str, str, object]]) -> None:
        for _, count_kind, kind, value in properties:
            if count_kind:
                assert isinstance(value, list)
                self.number(count_kind, len(value))
                for item in value:
                    self.number(kind, item)
            else:
                assert isinstance(value, (int, float))
                self.number(kind, value)
        self.body += b"\n" if self.form == "ascii" else b""


def header(name: str, count: int, properties: list[tuple[str, str, str, object]]) -> str:
    lines = [f"element {name} {count}"]
    for title, count_kind, kind, _ in properties:
        lines.append(f"property {f'list {count_kind} ' if count_kind else ''}{kind} {title}")
    return "\n".join(lines) + "\n"


@given(st.data(), positions, polygons, extras, extras, st.booleans())
def test_vertices_and_faces_come_back(
    data: st.DataObject,
    points: list[tuple[int, int, int]],
    faces: list[list[int]],
    beside_points: list[Extra],
    beside_faces: list[Extra],
    faces_first: bool,
) -> None:
    form = data.draw(st.sampled_from(["ascii", "binary_little_endian", "binary_big_endian"]))
    order = data.draw(st.permutations(range(3 + len(beside_points))))
    kind = data.draw(st.sampled_from(["char", "short", "int", "float", "float64"]))
    count_kind, index_kind = data.draw(st.sampled_from(COUNTS)), data.draw(st.sampled_from(INDICES))
    place = data.draw(st.integers(0, len(beside_faces)))
    lengths = data.draw(st.lists(st.integers(0, 3), min_size=1, max_size=5))

    def more(items: list[Extra], row: int) -> list[tuple[str, str, str, object]]:
        length = lengths[row % len(lengths)]
        return [
            (f"extra{i}", "uchar" if item.is_list else "", item.kind,
             [7] * length if item.is_list else 7)
            for i, item in enumerate(items)
        ]  # fmt: skip

    def vertex(row: int) -> list[tuple[str, str, str, object]]:
        own = [(axis, "", kind, points[row][i]) for i, axis in enumerate("xyz")]
        both = [*own, *more(beside_points, row)]
        return [both[i] for i in order]

    def face(row: int) -> list[tuple[str, str, str, object]]:
        result = more(beside_faces, row)
        result.insert(place, ("vertex_indices", count_kind, index_kind, faces[row]))
        return result

    elements = [("vertex", len(points), vertex), ("face", len(faces), face)]
    writer = Writer(form)
    text = f"ply\nformat {form} 1.0\n"
    for name, count, row in elements[:: -1 if faces_first else 1]:
        text += header(name, count, row(0))
        for number in range(count):
            writer.row(row(number))
    (mesh,) = parse_ply(f"{text}end_header\n".encode() + writer.body)
    assert mesh.positions.tolist() == [list(map(float, point)) for point in points]
    assert mesh.counts.tolist() == [len(item) for item in faces]
    assert mesh.corners.tolist() == [index for item in faces for index in item]
    assert np.issubdtype(mesh.corners.dtype, np.integer)
