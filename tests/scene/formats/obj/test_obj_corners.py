"""Corners of OBJ faces, in every form, against the sentence that defines them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ssdo_gl.scene.formats import read_model

# On this curve no three points are collinear.
POINTS = [(i, i * i, i**3) for i in range(6)]
UVS = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.25)]
NORMALS = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]

corner = st.tuples(
    st.sampled_from([None, 0, 1, 2]),
    st.sampled_from([None, 0, 1, 2]),
    st.booleans(),
)
face = st.tuples(
    st.lists(st.integers(0, 5), min_size=3, max_size=3, unique=True),
    st.tuples(corner, corner, corner),
)


def text_of(index: int | None, count: int, backwards: bool) -> str:
    if index is None:
        return ""
    return str(index - count if backwards else index + 1)


def corner_text(vertex: int, form: tuple[int | None, int | None, bool]) -> str:
    uv, normal, backwards = form
    parts = [
        text_of(vertex, len(POINTS), backwards),
        text_of(uv, len(UVS), backwards),
        text_of(normal, len(NORMALS), backwards),
    ]
    return "/".join(parts).rstrip("/")


@given(faces=st.lists(face, min_size=1, max_size=8))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_each_corner_gets_what_it_names(faces: list, tmp_path: Path) -> None:
    lines = [f"v {x} {y} {z}" for x, y, z in POINTS]
    lines += [f"vt {u} {v}" for u, v in UVS] + [f"vn {x} {y} {z}" for x, y, z in NORMALS]
    for vertices, forms in faces:
        words = [corner_text(*pair) for pair in zip(vertices, forms, strict=True)]
        lines.append("f " + " ".join(words))
    path = tmp_path / "a.obj"
    path.write_text("\n".join(lines) + "\n")
    (mesh,) = read_model(path, "a").meshes
    assert len(mesh.triangles) == len(faces)
    given_uvs = [form[0] for _, forms in faces for form in forms if form[0] is not None]
    given_normals = [form[1] for _, forms in faces for form in forms if form[1] is not None]
    assert (mesh.uvs is not None) == bool(given_uvs)
    assert (mesh.normals is not None) == bool(given_normals)
    flat_normals = mesh.face_normals()
    for number, (vertices, forms) in enumerate(faces):
        row = mesh.triangles[number]
        assert mesh.positions[row].tolist() == [list(POINTS[vertex]) for vertex in vertices]
        if mesh.uvs is not None:
            shown = [UVS[form[0]] if form[0] is not None else (0.0, 0.0) for form in forms]
            assert mesh.uvs[row].tolist() == [[u, 1.0 - v] for u, v in shown]
        if mesh.normals is not None:
            flat = any(form[1] is None for form in forms)
            expected = [flat_normals[number] if flat else NORMALS[form[1]] for form in forms]
            assert mesh.normals[row] == pytest.approx(np.array(expected), abs=1e-12)
