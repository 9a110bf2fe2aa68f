"""Meshes of tests, and what is measured of them, written apart from those of the package."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ssdo_gl.scene.geometry.mesh import Mesh
from ssdo_gl.scene.material import Texture
from ssdo_gl.scene.scene import Scene


def quad(corner: ArrayLike, edge_u: ArrayLike, edge_v: ArrayLike, **more: object) -> Mesh:
    """Return two triangles whose front is edge_u x edge_v."""
    corner, edge_u, edge_v = (np.asarray(v, np.float64) for v in (corner, edge_u, edge_v))
    positions = np.array([corner, corner + edge_u, corner + edge_u + edge_v, corner + edge_v])
    return Mesh(positions, np.array([[0, 1, 2], [0, 2, 3]]), **more)  # type: ignore[arg-type]


def box(low: ArrayLike, high: ArrayLike, **more: object) -> Mesh:
    """Return a closed axis-aligned box, 12 triangles, facing outwards."""
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    corners = np.array([[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)])
    sides = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    triangles = [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]
    return Mesh(corners, np.array(triangles), closed=True, **more)  # type: ignore[arg-type]


def soup(count: int, seed: int = 0, size: float = 0.1) -> Mesh:
    """Return unconnected random triangles."""
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-1.0, 1.0, (count, 1, 3)) + rng.normal(0.0, size, (count, 3, 3))
    return Mesh(positions.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))


def area(mesh: Mesh) -> float:
    """Return the area of all triangles."""
    a, b, c = (mesh.positions[mesh.triangles[:, i]] for i in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


def showing(scene: Scene, pixels: np.ndarray) -> Scene:
    """Return `scene`, whose emissive quads show an image of what they emit."""
    shown = Texture(pixels)
    glows = {item.mesh for item in scene.objects if scene.materials[item.material].emits}
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    meshes = [replace(m, uvs=corners) if i in glows else m for i, m in enumerate(scene.meshes)]
    materials = [replace(m, emission_texture=shown) if m.emits else m for m in scene.materials]
    return replace(scene, meshes=tuple(meshes), materials=tuple(materials))
