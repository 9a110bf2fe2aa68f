"""The pieces that a scene is made of: boxes around them, and which of them fill theirs."""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.geometry import Mesh
from ssdo_gl.scene.scene import Scene

BoolArray = NDArray[np.bool_]

# Distances below this fraction of a mesh's size are rounding: transforms in float64 leave
# 1e-16 per operation, coordinates themselves 1e-16.
ROUNDING = 1e-12
# Meshes that are looked at, each a quarter of a millisecond; of the rest nothing is said.
MOST_MESHES = 32
# Larger meshes fill no box: exporters write six faces in 8 to 36 vertices.
MOST_BOX_TRIANGLES = 1000


@dataclass(frozen=True, eq=False)
class MeshForm:
    """What a mesh is like, in its own space.

    Attributes
    ----------
    center, half_extent : ndarray, shape (3,)
        Of its bounds.
    is_box : bool
        It is a solid that fills its bounds. Nothing is said of other solids: a proof that
        they are convex had no use in models made by others.
    """

    center: FloatArray
    half_extent: FloatArray
    is_box: bool = False


_forms: weakref.WeakKeyDictionary[Mesh, MeshForm] = weakref.WeakKeyDictionary()


def form_of(mesh: Mesh) -> MeshForm:
    """Return what `mesh` is like; found out once for each mesh."""
    if mesh not in _forms:
        _forms[mesh] = _form_of(mesh)
    return _forms[mesh]


def _form_of(mesh: Mesh) -> MeshForm:
    low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
    center, half = 0.5 * (low + high), 0.5 * (high - low)
    tolerance = ROUNDING * float(np.linalg.norm(half) + np.abs(center).max())
    return MeshForm(center, half, mesh.closed and _fills_box(mesh, low, high, tolerance))


def _fills_box(mesh: Mesh, low: FloatArray, high: FloatArray, tolerance: float) -> bool:
    """Return whether a closed mesh is its bounding box, faces outward.

    All triangles lie in faces of the box, and what they enclose has its volume: so none is
    missing, none turned inside out, and nothing covered twice.
    """
    if len(mesh.triangles) > MOST_BOX_TRIANGLES:
        return False
    corners = mesh.positions[mesh.triangles]
    at_low, at_high = (np.all(np.abs(corners - side) <= tolerance, axis=1) for side in (low, high))
    if not np.all(np.any(at_low | at_high, axis=1)):
        return False
    a, b, c = (corners[:, i] - low for i in range(3))
    volume = float(np.sum(a * np.cross(b, c)) / 6.0)
    extent = float(np.prod(high - low))
    # Rounding, times the triangles that are summed.
    return abs(volume - extent) <= 1e-9 * extent


@dataclass(frozen=True, eq=False)
class Bodies:
    """All instances of all objects, N of them, as boxes in world space.

    Attributes
    ----------
    center : ndarray, shape (N, 3)
    half_edges : ndarray, shape (N, 3, 3)
        Rows are half the edges of the box around the body: a parallelepiped.
    is_box : ndarray, shape (N,), bool
        Whether it is a solid that fills that box.
    is_glossy : ndarray, shape (N,), bool
        Whether it reflects more than diffuse light.
    emits : ndarray, shape (N,), bool
        Whether it shows light of its own.
    mesh_forms : tuple of MeshForm
        Of each body.
    world_from_object : ndarray, shape (N, 4, 4)
    """

    center: FloatArray
    half_edges: FloatArray
    is_box: BoolArray
    is_glossy: BoolArray
    emits: BoolArray
    mesh_forms: tuple[MeshForm, ...]
    world_from_object: FloatArray

    def __len__(self) -> int:
        return len(self.center)

    def reach_along(self, axes: FloatArray) -> FloatArray:
        """Return half the extent (N, K) of the boxes along K axes (K, 3)."""
        return np.asarray(np.abs(self.half_edges @ axes.T).sum(axis=1))

    def holds(self, body: int, point_ws: FloatArray) -> bool:
        """Return whether a point lies in the solid box `body`, or too close to tell."""
        form, matrix = self.mesh_forms[body], self.world_from_object[body]
        try:
            local = np.linalg.solve(matrix[:3, :3], point_ws - matrix[:3, 3])
        except np.linalg.LinAlgError:
            return True
        # A billionth of the size: far above rounding, far below what a picture shows.
        margin = 1e-9 * float(np.linalg.norm(form.half_extent))
        return bool(np.all(np.abs(local - form.center) <= form.half_extent + margin))


def _forms_of(meshes: Sequence[Mesh]) -> dict[int, MeshForm]:
    """Return the form of each mesh by its id: of as many as a scene has the time for."""
    each = {id(mesh): mesh for mesh in meshes}
    forms = {number: form_of(each[number]) for number in list(each)[:MOST_MESHES]}
    rest = [number for number in each if number not in forms]
    if rest:
        counts = [len(each[number].positions) for number in rest]
        starts = np.cumsum([0, *counts[:-1]])
        positions = np.concatenate([each[number].positions for number in rest])
        low = np.minimum.reduceat(positions, starts, axis=0)
        high = np.maximum.reduceat(positions, starts, axis=0)
        for number, center, half in zip(rest, 0.5 * (low + high), 0.5 * (high - low), strict=True):
            forms[number] = MeshForm(center, half)
    return forms


def bodies_of(scene: Scene) -> Bodies:
    """Return the bodies of `scene` as it stands."""
    known = _forms_of([scene.meshes[item.mesh] for item in scene.objects])
    forms = [known[id(scene.meshes[item.mesh])] for item in scene.objects]
    counts = [len(item.world_from_object) for item in scene.objects]
    if not any(counts):
        none = np.empty(0, dtype=np.bool_)
        places = np.empty((0, 3)), np.empty((0, 3, 3))
        return Bodies(*places, none, none, none, (), np.empty((0, 4, 4)))
    matrices = np.concatenate([item.world_from_object for item in scene.objects])
    center = np.repeat([form.center for form in forms], counts, axis=0)
    half = np.repeat([form.half_extent for form in forms], counts, axis=0)
    materials = [scene.materials[item.material] for item in scene.objects]
    # A solid with holes cut out of it shows its inside.
    boxes = [f.is_box and not m.has_holes for f, m in zip(forms, materials, strict=True)]
    return Bodies(
        center=np.einsum("nij,nj->ni", matrices[:, :3, :3], center) + matrices[:, :3, 3],
        # Column k of the matrix times the box's half extent along k, as rows.
        half_edges=matrices[:, :3, :3].transpose(0, 2, 1) * half[:, :, None],
        is_box=np.repeat(boxes, counts),
        is_glossy=np.repeat([material.is_glossy for material in materials], counts),
        emits=np.repeat([material.emits or material.is_unlit for material in materials], counts),
        mesh_forms=tuple(form for form, n in zip(forms, counts, strict=True) for _ in range(n)),
        world_from_object=matrices,
    )
