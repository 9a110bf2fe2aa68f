"""Vertex streams of one mesh on the device."""

from __future__ import annotations

from dataclasses import dataclass

import moderngl
import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.mesh import Mesh


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
        ``a_position_os`` ("mesh space": object space minus `center`) and
        ``a_normal_face_os`` always; ``a_normal_os``, ``a_uv``, ``a_color`` if present.
    indices : moderngl.Buffer or None
    """

    center: FloatArray
    half_extent: FloatArray
    buffers: dict[str, tuple[moderngl.Buffer, int]]
    indices: moderngl.Buffer | None

    def release(self) -> None:
        """Free the buffers."""
        for buffer, _ in self.buffers.values():
            buffer.release()
        if self.indices is not None:
            self.indices.release()


def vertex_streams(gl: moderngl.Context, mesh: Mesh) -> VertexStreams:
    """Upload `mesh`; every triangle gets its own exact face normal."""
    low, high = mesh.bounds()
    center = 0.5 * (low + high)
    corners = mesh.triangles.reshape(-1)
    streams = {
        "a_position_os": mesh.positions[corners] - center,
        "a_normal_face_os": np.repeat(mesh.face_normals(), 3, axis=0),
    }
    if mesh.normals is not None:
        streams["a_normal_os"] = mesh.normals[corners]
    if mesh.uvs is not None:
        streams["a_uv"] = mesh.uvs[corners]
    if mesh.colors is not None:
        streams["a_color"] = mesh.colors[corners]
    buffers = {
        name: (gl.buffer(values.astype(np.float32).tobytes()), values.shape[1])
        for name, values in streams.items()
    }
    return VertexStreams(center, 0.5 * (high - low), buffers, None)
