"""All triangles of a scene, instances included, in one normalised frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray, doubled_area_vectors, lengths_of_rows
from ssdo_gl.raytracing.packed import color_words, oct_words, tangent_words
from ssdo_gl.scene.geometry import (
    SPAN,
    Mesh,
    SceneObject,
    are_mirrored,
    joined_vertices,
    placed,
    spans,
)
from ssdo_gl.scene.scene import Scene

CornerValue = TypeVar("CornerValue", bound=np.generic)
# A word of `color_words`, all of whose channels are 1.
WHITE = np.uint32(0xFFFFFFFF)
# Of fewer it takes no time to find equal positions among all their corners.
MANY_TRIANGLES = 1 << 20


@dataclass(frozen=True, eq=False)
class SceneTriangles:
    """T triangles in the normalised frame (``_ns``): centred, half-diagonal 1.

    Whatever the scene's scale and place, every coordinate is within [-1, 1], so that
    float32 serves all scenes alike and no epsilon depends on the scene's units.

    Attributes
    ----------
    positions : ndarray, shape (T, 3, 3), float32
        Corners, counter-clockwise seen from the front, normalised frame.
    normals : ndarray, shape (T, 3), uint32
        Unit shading normals at the corners, world space (the axes of the frame), as
        `packed.oct_words`.
    uvs : ndarray, shape (T, 3, 2), float32
        Texture coordinates; 0 where the mesh has none, and in a scene without images.
    colors : ndarray, shape (T, 3, 2), uint32
        Vertex colours, as `packed.color_words`; 1 where the mesh has none.
    material, light : ndarray, shape (T,), int32
        Index into Scene.materials; into Scene.lights, or -1 if no light's body.
    smooth, single_sided, solid : ndarray, shape (T,), bool
        Whether the mesh brought normals; whether rays from behind pass; whether the mesh
        encloses what is behind the triangle.
    centre : ndarray, shape (3,), float64
        World-space origin of the frame.
    half_diagonal : float
        Length of the frame's unit, scene units, > 0.
    second_uvs : ndarray, shape (T, 3, 2), float32, or None
        Of the images of `Material.second_uvs`; None: all are `uvs`.
    tangents : ndarray, shape (T, 3, 2), uint32, or None
        As `Mesh.tangents` in world space, as `packed.tangent_words`; 0 where the mesh has none.
    vertices : ndarray, shape (T, 3), int64, or None
        Corners with one number are at one position. Of many triangles only, where it is
        costly to find out from the positions; corners of several objects then differ.
    """

    positions: NDArray[np.float32]
    normals: NDArray[np.uint32]
    uvs: NDArray[np.float32]
    colors: NDArray[np.uint32]
    material: NDArray[np.int32]
    light: NDArray[np.int32]
    smooth: NDArray[np.bool_]
    single_sided: NDArray[np.bool_]
    solid: NDArray[np.bool_]
    centre: FloatArray
    half_diagonal: float
    second_uvs: NDArray[np.float32] | None = None
    tangents: NDArray[np.uint32] | None = None
    vertices: IntArray | None = None

    @property
    def count(self) -> int:
        """Number of triangles, T."""
        return len(self.positions)

    def first(self, count: int) -> SceneTriangles:
        """Return the first `count` of the triangles."""
        arrays = {
            field.name: getattr(self, field.name)[:count]
            for field in fields(self)
            if field.name != "centre" and isinstance(getattr(self, field.name), np.ndarray)
        }
        return replace(self, **arrays)


def has_images(scene: Scene) -> bool:
    """Return whether any material has an image, without which none looks at coordinates."""
    return any(material.textures for material in scene.materials)


def normalised_frame(scene: Scene) -> tuple[FloatArray, float]:
    """Return centre (3,) and half-diagonal of the scene's bounds, world space, float64."""
    low, high = scene.bounds()
    # A scene that is a single point has no triangle with area; any unit will do.
    return 0.5 * (low + high), float(0.5 * np.linalg.norm(high - low)) or 1.0


def scene_triangles(scene: Scene) -> SceneTriangles:
    """Flatten all instances of `scene`; triangles without area in float32 are dropped."""
    centre, half_diagonal = normalised_frame(scene)
    has = _Attributes.of(scene)
    total = sum(
        len(scene.meshes[item.mesh].triangles) * len(item.world_from_object)
        for item in scene.objects
    )
    made = SceneTriangles(
        positions=np.empty((total, 3, 3), dtype=np.float32),
        normals=np.empty((total, 3), dtype=np.uint32),
        uvs=_rows((total, 3, 2), np.float32(0.0), has.uvs),
        colors=_rows((total, 3, 2), WHITE, has.colors),
        material=np.empty(total, dtype=np.int32),
        light=np.empty(total, dtype=np.int32),
        smooth=np.empty(total, dtype=bool),
        single_sided=np.empty(total, dtype=bool),
        solid=np.empty(total, dtype=bool),
        centre=centre,
        half_diagonal=half_diagonal,
        second_uvs=np.empty((total, 3, 2), dtype=np.float32) if has.second_uvs else None,
        tangents=np.empty((total, 3, 2), dtype=np.uint32) if has.tangents else None,
        vertices=np.empty((total, 3), dtype=np.int64) if total > MANY_TRIANGLES else None,
    )
    count = vertex_count = 0
    for item in scene.objects:
        mesh = scene.meshes[item.mesh]
        joined = None if made.vertices is None else joined_vertices(mesh.positions)
        for matrices in _groups(item.world_from_object, len(mesh.triangles)):
            for span in spans(len(mesh.triangles)):
                filled, keep = _fill(made, count, scene, item, matrices, span, has)
                if made.vertices is not None and joined is not None:
                    first = vertex_count + len(joined) * np.arange(len(matrices))
                    named = joined[mesh.triangles[span]] + first[:, None, None]
                    made.vertices[count : count + filled] = named.reshape(-1, 3)[keep]
                count += filled
            vertex_count += len(mesh.positions) * len(matrices)
    return made if count == total else made.first(count)


@dataclass(frozen=True)
class _Attributes:
    """Which of the things that corners may have any mesh of a scene has that are looked at."""

    uvs: bool
    colors: bool
    second_uvs: bool
    tangents: bool

    @classmethod
    def of(cls, scene: Scene) -> _Attributes:
        return cls(
            uvs=has_images(scene) and any(mesh.uvs is not None for mesh in scene.meshes),
            colors=any(mesh.colors is not None for mesh in scene.meshes),
            second_uvs=any(mesh.second_uvs is not None for mesh in scene.meshes),
            tangents=any(mesh.has_tangents for mesh in scene.meshes),
        )


def _rows(shape: tuple[int, ...], value: CornerValue, is_used: bool) -> NDArray[CornerValue]:
    """Return an array to be filled, or, where all is one value, one that takes no memory."""
    return np.empty(shape, value.dtype) if is_used else np.broadcast_to(value, shape)


def _groups(matrices: FloatArray, triangle_count: int) -> Iterator[FloatArray]:
    """Yield matrices (N, 4, 4) in order, so many that their triangles are a span."""
    for group in spans(len(matrices), max(SPAN // triangle_count, 1)):
        yield matrices[group]


def _fill(
    made: SceneTriangles,
    start: int,
    scene: Scene,
    item: SceneObject,
    matrices: FloatArray,
    span: slice,
    has: _Attributes,
) -> tuple[int, NDArray[np.bool_]]:
    """Write the triangles of a span of copies of an object from row `start` on.

    Returns how many, and which of them have area.
    """
    mesh = scene.meshes[item.mesh]
    relative = matrices.copy()
    relative[:, :3, 3] -= made.centre
    mirrored = are_mirrored(matrices)
    moved = placed(mesh.corners(span), relative) / made.half_diagonal
    positions = _turned(moved, mirrored).astype(np.float32)
    keep = _have_area(positions)
    count = int(np.count_nonzero(keep))
    rows = slice(start, start + count)
    positions = positions[keep]
    made.positions[rows] = positions
    if mesh.normals is None:
        made.normals[rows] = oct_words(_face_normals(positions))
    else:
        # The cofactor matrix carries normals under any affine map, and unlike the
        # inverse transpose exists for flat (singular) ones; its sign follows mirroring.
        linear = matrices[:, :3, :3]
        cofactor = np.stack(
            [np.cross(linear[:, (i + 1) % 3], linear[:, (i + 2) % 3]) for i in range(3)], axis=1
        )
        cofactor[mirrored] *= -1.0
        normals = _copies(mesh.normals, mesh, span, len(matrices))
        unit = _moved(normals, cofactor.transpose(0, 2, 1))
        made.normals[rows] = oct_words(_turned(unit, mirrored)[keep])
    colors = None if mesh.colors is None else color_words(mesh.colors)
    for target, values, otherwise in (
        (made.uvs if has.uvs else None, mesh.uvs, 0),
        (made.colors if has.colors else None, colors, WHITE),
        (made.second_uvs, mesh.uvs if mesh.second_uvs is None else mesh.second_uvs, 0),
    ):
        if target is not None and values is None:
            target[rows] = otherwise
        elif target is not None and values is not None:
            target[rows] = _turned(_copies(values, mesh, span, len(matrices)), mirrored)[keep]
    if made.tangents is not None:
        tangents = _placed_tangents(mesh, matrices, span, mirrored)[keep]
        made.tangents[rows] = tangent_words(tangents)
    made.material[rows] = item.material
    made.light[rows] = -1 if item.light is None else item.light
    made.smooth[rows] = mesh.normals is not None
    made.single_sided[rows] = scene.materials[item.material].single_sided and not mesh.is_solid
    made.solid[rows] = mesh.is_solid
    return count, keep


def _copies(
    values: NDArray[CornerValue], mesh: Mesh, span: slice, count: int
) -> NDArray[CornerValue]:
    """Return what the corners of triangles have, for each of `count` copies, (N, T, 3, n)."""
    corners = np.take(values, mesh.triangles[span], axis=0)
    return np.broadcast_to(corners, (count, *corners.shape))


def _turned(corners: NDArray[CornerValue], mirrored: NDArray[np.bool_]) -> NDArray[CornerValue]:
    """Return corners of copies, (N, T, 3, n), as rows; those of mirrored ones in reverse.

    Mirroring turns the winding over; the front stays the side that the counter-clockwise
    winding of the mesh faced.
    """
    if mirrored.any():
        corners = corners.copy()
        corners[mirrored] = corners[mirrored][:, :, ::-1]
    return corners.reshape(-1, *corners.shape[2:])


def _placed_tangents(
    mesh: Mesh, matrices: FloatArray, span: slice, mirrored: NDArray[np.bool_]
) -> FloatArray:
    if not mesh.has_tangents or mesh.tangents is None:
        return np.zeros((len(matrices) * len(mesh.triangles[span]), 3, 4))
    tangents = _copies(mesh.tangents, mesh, span, len(matrices)).copy()
    tangents[..., :3] = _moved(tangents[..., :3], matrices[:, :3, :3].transpose(0, 2, 1))
    tangents[mirrored, ..., 3] *= -1.0
    return _turned(tangents, mirrored)


def _face_normals(positions: NDArray[np.float32]) -> FloatArray:
    """Return unit normals (T, 1, 3) of triangles with area."""
    normal = doubled_area_vectors(positions.astype(np.float64))
    return np.asarray(normal / lengths_of_rows(normal)[:, None])[:, None]


def _have_area(positions: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Tell which triangles (T, 3, 3) are finite and have three distinct, non-collinear corners."""
    corners = positions.astype(np.float64)
    edge_1, edge_2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    # Products of float32 differences are exact in float64 to 1e-16, so a needle keeps
    # its area and only truly collinear corners give zero.
    doubled = lengths_of_rows(np.cross(edge_1, edge_2))
    longest = np.maximum(lengths_of_rows(edge_1), lengths_of_rows(edge_2))
    finite = np.isfinite(corners).all(axis=(1, 2))
    return np.asarray(finite & (doubled > np.finfo(np.float64).eps * longest**2))


def _moved(vectors: FloatArray, matrices: FloatArray) -> FloatArray:
    """Return directions (N, ..., 3) times matrices (N, 3, 3), of unit length or 0."""
    moved = (vectors.reshape(len(matrices), -1, 3) @ matrices).reshape(vectors.shape)
    length = lengths_of_rows(moved.reshape(-1, 3)).reshape(*moved.shape[:-1], 1)
    return np.asarray(np.divide(moved, length, out=np.zeros_like(moved), where=length > 0.0))
