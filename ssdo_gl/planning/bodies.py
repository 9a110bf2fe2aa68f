"""The pieces that a scene is made of: boxes around them, and which of them fill theirs."""

from __future__ import annotations

import functools
import math
import weakref
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.scene.geometry import Mesh
from ssdo_gl.scene.scene import Scene

BoolArray = NDArray[np.bool_]

# Heights above a plane below this fraction of a mesh's size are rounding: transforms in
# float64 leave 1e-16 per operation, coordinates themselves 1e-16.
ROUNDING = 1e-12
# Meshes that are looked at, each a quarter of a millisecond; of the rest nothing is said.
MOST_MESHES = 32
# Larger meshes fill no box: exporters write six faces in 8 to 36 vertices.
MOST_BOX_TRIANGLES = 1000
# Nearly every mesh that is not flat shows it in this many vertices, spread over it.
FIRST_LOOK_VERTICES = 256
# Of a flat mesh with more vertices than this, the corners of its box stand for them.
MOST_OUTLINE_POINTS = 64

# What can be said of a mesh: nothing, that it is a solid that fills its bounding box (a
# proof of convexity for other solids had no use in models made by others), or that all of
# it lies in one plane.
ANY, SOLID_BOX, FLAT = 0, 1, 2
# Cosine of what stored normals of a flat surface may lean by: rounding of 8 bits, 0.4 degrees.
UPRIGHT = math.cos(math.radians(0.5))


@dataclass(frozen=True, eq=False)
class MeshForm:
    """What a mesh is like, in its own space.

    Attributes
    ----------
    center, half_extent : ndarray, shape (3,)
        Of its bounds.
    form : int
        `ANY`, `SOLID_BOX` or `FLAT`.
    normal : ndarray, shape (3,)
        Of a flat mesh, unit length; else zero.
    outline : ndarray, shape (K, 3)
        Of a flat mesh: points whose convex hull holds it; else empty.
    """

    center: FloatArray
    half_extent: FloatArray
    form: int
    normal: FloatArray = field(default_factory=lambda: np.zeros(3))
    outline: FloatArray = field(default_factory=lambda: np.empty((0, 3)))


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
    normal = _largest_normal(mesh)
    if _is_flat(mesh, normal, tolerance) and _is_shaded_flat(mesh, normal):
        few = len(mesh.positions) <= MOST_OUTLINE_POINTS
        return MeshForm(center, half, FLAT, normal, mesh.positions if few else _corners(low, high))
    is_box = mesh.closed and _fills_box(mesh, low, high, tolerance)
    return MeshForm(center, half, SOLID_BOX if is_box else ANY)


def _is_flat(mesh: Mesh, normal: FloatArray, tolerance: float) -> bool:
    """Return whether all vertices lie in one plane."""
    for step in (max(1, len(mesh.positions) // FIRST_LOOK_VERTICES), 1):
        heights = mesh.positions[::step] @ normal
        if not np.ptp(heights) <= 2.0 * tolerance:
            return False
    return True


def _is_shaded_flat(mesh: Mesh, normal: FloatArray) -> bool:
    """Return whether a flat mesh is shaded by its own normal: then it throws no shadow on itself.

    Light from behind may shine on a normal that leans; the sheet stands in its way.
    """
    return mesh.normals is None or bool(np.all(np.abs(mesh.normals @ normal) > UPRIGHT))


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


def _largest_normal(mesh: Mesh) -> FloatArray:
    """Return the unit normal of the largest of some triangles, spread over the mesh."""
    chosen = mesh.triangles[:: max(1, len(mesh.triangles) // FIRST_LOOK_VERTICES)]
    a, b, c = (mesh.positions[chosen[:, i]] for i in range(3))
    # The longest edge as unit keeps tiny triangles from underflowing.
    size = float(max(np.abs(b - a).max(), np.abs(c - a).max())) or 1.0
    normals = np.cross((b - a) / size, (c - a) / size)
    return unit(normals[np.argmax(np.einsum("ij,ij->i", normals, normals))])


def _corners(low: FloatArray, high: FloatArray) -> FloatArray:
    return np.asarray(np.where(np.indices((2, 2, 2)).reshape(3, 8).T, high, low))


@dataclass(frozen=True, eq=False)
class Bodies:
    """All instances of all objects, N of them, as boxes in world space.

    Attributes
    ----------
    center : ndarray, shape (N, 3)
    half_edges : ndarray, shape (N, 3, 3)
        Rows are half the edges of the box around the body: a parallelepiped.
    form : ndarray, shape (N,), int64
        `ANY`, `SOLID_BOX` or `FLAT`.
    light : ndarray, shape (N,), int64
        The light whose visible body it is, or -1.
    mesh_forms : tuple of MeshForm
        Of each body.
    world_from_object : ndarray, shape (N, 4, 4)
    is_glossy : ndarray, shape (N,), bool
        Whether it reflects more than diffuse light.
    """

    center: FloatArray
    half_edges: FloatArray
    form: IntArray
    light: IntArray
    mesh_forms: tuple[MeshForm, ...]
    world_from_object: FloatArray
    is_glossy: BoolArray

    def __len__(self) -> int:
        return len(self.center)

    @functools.cached_property
    def radius(self) -> FloatArray:
        """Of a sphere about the centre that holds each body, shape (N,)."""
        return np.asarray(np.linalg.norm(self.half_edges, axis=2).sum(axis=1))

    @functools.cached_property
    def face_axes(self) -> FloatArray:
        """Unit normals of the boxes' faces, shape (N, 3, 3), one in each row.

        Zero where a box has no such face.
        """
        edges = self.half_edges
        return unit(np.cross(np.roll(edges, -1, axis=1), np.roll(edges, -2, axis=1)))

    def flat_plane_ws(self, body: int) -> FloatArray:
        """Return the plane (4,) of a flat body: unit normal and offset, world space."""
        matrix = self.world_from_object[body]
        points = self.mesh_forms[body].outline
        # The cofactor matrix carries normals even where a matrix has no inverse.
        linear = matrix[:3, :3]
        cofactor = np.stack([np.cross(linear[(i + 1) % 3], linear[(i + 2) % 3]) for i in range(3)])
        normal = unit(cofactor @ self.mesh_forms[body].normal)
        point = linear @ points[0] + matrix[:3, 3]
        return np.append(normal, -float(normal @ point))

    def outline_ws(self, body: int) -> FloatArray:
        """Return world-space points (K, 3) whose convex hull holds a flat body."""
        matrix = self.world_from_object[body]
        return np.asarray(self.mesh_forms[body].outline @ matrix[:3, :3].T + matrix[:3, 3])

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
            forms[number] = MeshForm(center, half, ANY)
    return forms


def bodies_of(scene: Scene) -> Bodies:
    """Return the bodies of `scene` as it stands."""
    known = _forms_of([scene.meshes[item.mesh] for item in scene.objects])
    forms = [known[id(scene.meshes[item.mesh])] for item in scene.objects]
    counts = [len(item.world_from_object) for item in scene.objects]
    if not any(counts):
        none = np.empty((0, 3))
        integers = np.empty(0, dtype=np.int64)
        return Bodies(
            none, np.empty((0, 3, 3)), integers, integers, (), np.empty((0, 4, 4)), integers > 0
        )
    matrices = np.concatenate([item.world_from_object for item in scene.objects])
    center = np.repeat([form.center for form in forms], counts, axis=0)
    half = np.repeat([form.half_extent for form in forms], counts, axis=0)
    kinds = [_kind(scene, number, form) for number, form in enumerate(forms)]
    glossy = [scene.materials[item.material].is_glossy for item in scene.objects]
    lights = [-1 if item.light is None else item.light for item in scene.objects]
    return Bodies(
        center=np.einsum("nij,nj->ni", matrices[:, :3, :3], center) + matrices[:, :3, 3],
        # Column k of the matrix times the box's half extent along k, as rows.
        half_edges=matrices[:, :3, :3].transpose(0, 2, 1) * half[:, :, None],
        form=np.repeat(kinds, counts),
        light=np.repeat(lights, counts),
        mesh_forms=tuple(form for form, n in zip(forms, counts, strict=True) for _ in range(n)),
        world_from_object=matrices,
        is_glossy=np.repeat(glossy, counts),
    )


def unit(vectors: FloatArray) -> FloatArray:
    """Return vectors (..., 3) of length one; zero stays zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))


def _kind(scene: Scene, number: int, form: MeshForm) -> int:
    """A solid with holes cut out of it shows its inside; a flat sheet has none."""
    material = scene.materials[scene.objects[number].material]
    cut_out = material.has_holes
    return ANY if cut_out and form.form == SOLID_BOX else form.form
