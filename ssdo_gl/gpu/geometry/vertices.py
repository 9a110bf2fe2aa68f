"""Vertex streams of one mesh on the device."""

from __future__ import annotations

from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.geometry import Mesh, spans


@dataclass(eq=False)
class VertexStreams:
    """One buffer for each attribute, so that a depth-only pass reads positions only.

    Attributes
    ----------
    center : ndarray, shape (3,)
        Object-space point that positions are stored relative to.
    half_extent : ndarray, shape (3,)
        Half the size of the object-space bounds around `center`.
    buffers : dict of name to (buffer, components), float32
        ``a_position_os`` (relative to `center`) and ``a_normal_face_os`` always;
        ``a_normal_os``, ``a_tangent_os``, ``a_uv``, ``a_second_uv``, ``a_color`` if present.
    indices : moderngl.Buffer
        Three uint32 for each triangle.
    is_solid : bool
        Whether the mesh is closed and its front faces look outwards.
    """

    center: FloatArray
    half_extent: FloatArray
    buffers: dict[str, tuple[moderngl.Buffer, int]]
    indices: moderngl.Buffer
    is_solid: bool

    @property
    def triangle_count(self) -> int:
        """How many the mesh has."""
        return self.indices.size // 12

    def release(self) -> None:
        """Free the buffers."""
        for buffer, _ in self.buffers.values():
            buffer.release()
        self.indices.release()


def vertex_streams(gl: moderngl.Context, mesh: Mesh) -> VertexStreams:
    """Upload `mesh`; every triangle gets its own exact face normal."""
    low, high = mesh.bounds()
    center = 0.5 * (low + high)
    source, triangles = with_own_last_vertices(mesh.triangles, len(mesh.positions))
    indices = gl.buffer(triangles.astype(np.uint32))
    face_normals = np.zeros((len(source), 3), dtype=np.float32)
    for span in spans(len(triangles)):
        face_normals[triangles[span, 2]] = mesh.face_normals(span)
    del triangles
    buffers = {"a_normal_face_os": (gl.buffer(face_normals), 3)}
    del face_normals
    carried = {
        "a_position_os": mesh.positions,
        "a_normal_os": mesh.normals,
        "a_tangent_os": mesh.tangents,
        "a_uv": mesh.uvs,
        "a_second_uv": mesh.second_uvs,
        "a_color": mesh.colors,
    }
    for name, values in carried.items():
        if values is not None:
            origin = center if name == "a_position_os" else 0.0
            stream = np.empty((len(source), values.shape[1]), dtype=np.float32)
            for span in spans(len(source)):
                stream[span] = np.take(values, source[span], axis=0) - origin
            buffers[name] = gl.buffer(stream), values.shape[1]
    return VertexStreams(center, 0.5 * (high - low), buffers, indices, mesh.is_solid)


def with_own_last_vertices(
    triangles: NDArray[np.int64], vertex_count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return indices in which no two triangles end in the same vertex.

    OpenGL takes ``flat`` values from a triangle's last vertex. If that vertex is no
    other triangle's last, it can hold the triangle's normal, while vertices are still
    shared: about one for each triangle is shaded instead of three.

    Parameters
    ----------
    triangles : ndarray, shape (T, 3)

    Returns
    -------
    source : ndarray, shape (V,)
        The vertex that each vertex is a copy of; the first `vertex_count` are themselves.
    triangles : ndarray, shape (T, 3)
        The same triangles, each turned (winding kept) and in part made of copies.
    """
    last = np.full(len(triangles), -1, dtype=np.int8)
    owner = np.full(vertex_count, -1)
    for corner in range(3):
        waiting = np.flatnonzero(last < 0)
        wanted = triangles[waiting, corner]
        is_free = owner[wanted] < 0
        waiting, wanted = waiting[is_free], wanted[is_free]
        # Written backwards: of all that want the same vertex, the first gets it.
        owner[wanted[::-1]] = waiting[::-1]
        last[waiting[owner[wanted] == waiting]] = corner
    left = np.flatnonzero(last < 0)
    last[left] = 2
    turned = np.empty_like(triangles)
    for corner in range(3):
        rows = np.flatnonzero(last == corner)
        turned[rows] = np.roll(triangles[rows], 2 - corner, axis=1)
    source = np.concatenate([np.arange(vertex_count), turned[left, 2]])
    turned[left, 2] = vertex_count + np.arange(len(left))
    return source, turned
