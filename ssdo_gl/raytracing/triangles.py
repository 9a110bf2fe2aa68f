"""All triangles of a scene, instances included, in one normalised frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.scene.mesh import Mesh, SceneObject, are_mirrored, placed
from ssdo_gl.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class SceneTriangles:
    """T triangles in the normalised frame (``_ns``): centred, half-diagonal 1.

    Whatever the scene's scale and place, every coordinate is within [-1, 1], so that
    float32 serves all scenes alike and no epsilon depends on the scene's units.

    Attributes
    ----------
    positions : ndarray, shape (T, 3, 3), float32
        Corners, counter-clockwise seen from the front, normalised frame.
    normals : ndarray, shape (T, 3, 3), float64
        Unit shading normals at the corners, world space (the axes of the frame).
    uvs : ndarray, shape (T, 3, 2), float64
        Texture coordinates; 0 where the mesh has none.
    colors : ndarray, shape (T, 3, 4), float64
        Vertex colours; 1 where the mesh has none.
    material, light : ndarray, shape (T,), int64
        Index into Scene.materials; into Scene.lights, or -1 if no light's body.
    smooth, single_sided, solid : ndarray, shape (T,), bool
        Whether the mesh brought normals; whether rays from behind pass; whether the mesh
        encloses what is behind the triangle.
    centre : ndarray, shape (3,), float64
        World-space origin of the frame.
    half_diagonal : float
        Length of the frame's unit, scene units, > 0.
    second_uvs : ndarray, shape (T, 3, 2), float64, or None
        Of the images of `Material.second_uvs`; None: all are `uvs`.
    tangents : ndarray, shape (T, 3, 4), float64, or None
        As `Mesh.tangents` in world space; 0 where the mesh has none.
    """

    positions: NDArray[np.float32]
    normals: FloatArray
    uvs: FloatArray
    colors: FloatArray
    material: IntArray
    light: IntArray
    smooth: NDArray[np.bool_]
    single_sided: NDArray[np.bool_]
    solid: NDArray[np.bool_]
    centre: FloatArray
    half_diagonal: float
    second_uvs: FloatArray | None = None
    tangents: FloatArray | None = None

    @property
    def count(self) -> int:
        """Number of triangles."""
        return len(self.positions)


def normalised_frame(scene: Scene) -> tuple[FloatArray, float]:
    """Return centre (3,) and half-diagonal of the scene's bounds, world space, float64."""
    low, high = scene.bounds()
    # A scene that is a single point has no triangle with area; any unit will do.
    return 0.5 * (low + high), float(0.5 * np.linalg.norm(high - low)) or 1.0


def scene_triangles(scene: Scene) -> SceneTriangles:
    """Flatten all instances of `scene`; triangles without area in float32 are dropped."""
    centre, half_diagonal = normalised_frame(scene)
    more = (
        any(mesh.second_uvs is not None for mesh in scene.meshes),
        any(mesh.has_tangents for mesh in scene.meshes),
    )
    parts = [
        _instances(scene, item, centre, half_diagonal, more)
        for item in scene.objects
        if len(item.world_from_object)
    ]
    positions, normals, tangents, uvs, colors, second, *rest = (
        np.concatenate([part[i] for part in parts]) for i in range(11)
    )
    material, light, smooth, single_sided, solid = rest
    positions_ns = positions.astype(np.float32)
    keep = _have_area(positions_ns)
    return SceneTriangles(
        positions_ns[keep],
        np.where(smooth[keep, None, None], normals[keep], _face_normals(positions_ns[keep])),
        uvs[keep],
        colors[keep],
        material[keep],
        light[keep],
        smooth[keep],
        single_sided[keep],
        solid[keep],
        centre,
        half_diagonal,
        second[keep] if more[0] else None,
        tangents[keep] if more[1] else None,
    )


def _face_normals(positions: NDArray[np.float32]) -> FloatArray:
    """Return unit normals (T, 1, 3) of triangles with area."""
    corners = positions.astype(np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))[:, None]


def _have_area(positions: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Tell which triangles (T, 3, 3) are finite and have three distinct, non-collinear corners."""
    corners = positions.astype(np.float64)
    edge_1, edge_2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    # Products of float32 differences are exact in float64 to 1e-16, so a needle keeps
    # its area and only truly collinear corners give zero.
    doubled = np.linalg.norm(np.cross(edge_1, edge_2), axis=1)
    longest = np.maximum(np.linalg.norm(edge_1, axis=1), np.linalg.norm(edge_2, axis=1))
    finite = np.isfinite(corners).all(axis=(1, 2))
    return np.asarray(finite & (doubled > np.finfo(np.float64).eps * longest**2))


def _instances(
    scene: Scene,
    item: SceneObject,
    centre: FloatArray,
    half_diagonal: float,
    more: tuple[bool, bool],
) -> tuple[NDArray[Any], ...]:
    """Return the eleven per-triangle arrays of all instances of one object.

    `more` says whether the sixth holds second texture coordinates, and the third tangents:
    else these have no columns.
    """
    mesh, matrices = scene.meshes[item.mesh], item.world_from_object
    corners, *carried = _per_corner(mesh, more)
    relative = matrices.copy()
    relative[:, :3, 3] -= centre
    moved = placed(corners, relative) / half_diagonal
    # The cofactor matrix carries normals under any affine map, and unlike the
    # inverse transpose exists for flat (singular) ones; its sign follows mirroring.
    linear = matrices[:, :3, :3]
    cofactor = np.stack(
        [np.cross(linear[:, (i + 1) % 3], linear[:, (i + 2) % 3]) for i in range(3)], axis=1
    )
    mirrored = are_mirrored(matrices)
    cofactor[mirrored] *= -1.0
    normals, tangents, *carried = (
        np.broadcast_to(array, (len(matrices), *array.shape)).copy() for array in carried
    )
    unit = _moved(normals, cofactor.transpose(0, 2, 1))
    if more[1]:
        tangents[..., :3] = _moved(tangents[..., :3], linear.transpose(0, 2, 1))
        tangents[mirrored, ..., 3] *= -1.0
    # Mirroring turns the winding over; the front stays the side that the
    # counter-clockwise winding of the mesh faced.
    for array in (moved, unit, tangents, *carried):
        array[mirrored] = array[mirrored][:, :, ::-1]
    total = len(matrices) * len(corners)
    return (
        *(array.reshape(total, *array.shape[2:]) for array in (moved, unit, tangents, *carried)),
        np.full(total, item.material),
        np.full(total, -1 if item.light is None else item.light),
        np.full(total, mesh.normals is not None),
        np.full(total, scene.materials[item.material].single_sided and not mesh.is_solid),
        np.full(total, mesh.is_solid),
    )


def _moved(vectors: FloatArray, matrices: FloatArray) -> FloatArray:
    """Return directions (N, ..., 3) times matrices (N, 3, 3), of unit length or 0."""
    moved = (vectors.reshape(len(matrices), -1, 3) @ matrices).reshape(vectors.shape)
    length = np.linalg.norm(moved, axis=-1, keepdims=True)
    return np.asarray(np.divide(moved, length, out=np.zeros_like(moved), where=length > 0.0))


def _per_corner(mesh: Mesh, more: tuple[bool, bool]) -> tuple[FloatArray, ...]:
    """Return all that corners have, (T, 3, n), in the order that `_instances` returns."""
    triangles = mesh.triangles
    count = len(triangles)
    # Flat ones get their face normals once all are in place.
    normals = np.zeros((count, 3, 3)) if mesh.normals is None else mesh.normals[triangles]
    uvs = np.zeros((count, 3, 2)) if mesh.uvs is None else mesh.uvs[triangles]
    second = uvs if mesh.second_uvs is None else mesh.second_uvs[triangles]
    second = second if more[0] else second[..., :0]
    tangents = np.zeros((count, 3, 4 if more[1] else 0))
    if more[1] and mesh.tangents is not None and mesh.normals is not None:
        tangents = mesh.tangents[triangles]
    colors = np.ones((count, 3, 4)) if mesh.colors is None else mesh.colors[triangles]
    return mesh.positions[triangles], normals, tangents, uvs, colors, second
