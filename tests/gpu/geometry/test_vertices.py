"""Sharing vertices while each triangle keeps a last one of its own."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from passes.pass_harness import box, sphere

from ssdo_gl.gpu.geometry.vertices import with_own_last_vertices


def check(triangles, vertex_count):
    source, turned = with_own_last_vertices(triangles, vertex_count)
    assert len(np.unique(turned[:, 2])) == len(triangles), "a last vertex is shared"
    np.testing.assert_array_equal(source[:vertex_count], np.arange(vertex_count))
    for old, new in zip(triangles.tolist(), source[turned].tolist(), strict=True):
        assert new in (old, old[1:] + old[:1], old[2:] + old[:2]), "the winding changed"
    return source


@settings(max_examples=100, deadline=None)
@given(st.lists(st.permutations(range(7)).map(lambda p: p[:3]), min_size=1, max_size=40))
def test_any_mesh(triples):
    check(np.array(triples), 7)


@pytest.mark.parametrize("mesh", [box((0, 0, 0), (1, 1, 1)), sphere(rows=20)])
def test_closed_meshes_need_about_a_vertex_for_each_triangle(mesh):
    source = check(mesh.triangles, len(mesh.positions))
    assert len(source) < 1.05 * len(mesh.triangles) + 2


def test_vertices_that_no_triangle_uses_do_no_harm():
    source = check(np.array([[5, 6, 7]]), 10)
    assert len(source) == 10
