"""The pieces that a scene is made of: boxes around them, and which of them are convex."""

from __future__ import annotations

import dataclasses
import functools
import weakref
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.mesh import Mesh
from ssdo_gl.scene.scene import Scene

BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

# Heights above a plane below this fraction of a mesh's size are rounding: transforms in
# float64 leave 1e-16 per operation, coordinates themselves 1e-16.
ROUNDING = 1e-12
# Convexity is proven by looking at every vertex from every face: a sphere of 4000
# triangles takes 4 million looks, 2 ms once. What is larger counts as not convex.
MOST_LOOKS = 10_000_000
# The same for all meshes of a scene together, some 10 ms, and the most meshes that are
# looked at, each a quarter of a millisecond however small. Of the rest nothing is said.
MOST_LOOKS_PER_SCENE = 20_000_000
MOST_MESHES = 32
MOST_FACES = 6_000
# Nearly every mesh that is not convex fails on this many faces and vertices, spread
# evenly over it, so that 300 000 triangles take no longer than a few thousand.
FIRST_LOOK_FACES, FIRST_LOOK_VERTICES = 128, 256
# Of a flat mesh with more vertices than this, the corners of its box stand for them.
MOST_OUTLINE_POINTS = 64

# What can be said of a mesh: nothing, that it is a solid without any dent, or that all
# of it lies in one plane.
ANY, CONVEX_SOLID, FLAT = 0, 1, 2


@dataclass(frozen=True, eq=False)
class MeshForm:
    """What a mesh is like, in its own space.

    Attributes
    ----------
    center, half_extent : ndarray, shape (3,)
        Of its bounds.
    form : int
        `ANY`, `CONVEX_SOLID` or `FLAT`.
    planes : ndarray, shape (F, 4)
        Outward unit normals and offsets of the faces of a convex solid, each once; the
        one plane of a flat mesh; else empty.
    outline : ndarray, shape (K, 3)
        Of a flat mesh: points whose convex hull holds it; else empty.
    looks : int
        How many times a vertex was looked at from a face to prove that.
    """

    center: FloatArray
    half_extent: FloatArray
    form: int
    planes: FloatArray
    outline: FloatArray
    looks: int = 0


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
    unknown = MeshForm(center, half, ANY, np.empty((0, 4)), np.empty((0, 3)))
    first = _spread(len(mesh.triangles), FIRST_LOOK_FACES)
    planes = _planes(mesh, first)
    vertices = mesh.positions[_spread(len(mesh.positions), FIRST_LOOK_VERTICES)]
    heights = _heights(vertices, planes)
    if np.abs(heights).max() <= tolerance:
        if np.abs(_heights(mesh.positions, planes[:1])).max() > tolerance:
            return unknown
        few = len(mesh.positions) <= MOST_OUTLINE_POINTS
        outline = mesh.positions if few else _corners(low, high)
        return MeshForm(center, half, FLAT, planes[:1], outline)
    if not mesh.closed or heights.max() > tolerance or len(mesh.triangles) > MOST_FACES:
        return unknown
    if len(first) < len(mesh.triangles):
        planes = _planes(mesh, np.arange(len(mesh.triangles)))
    planes = _distinct(planes, mesh.positions)
    looks = len(planes) * len(mesh.positions)
    if looks > MOST_LOOKS:
        return unknown
    if not _is_below(mesh.positions, planes, tolerance):
        return dataclasses.replace(unknown, looks=looks)
    return MeshForm(center, half, CONVEX_SOLID, planes, np.empty((0, 3)), looks)


def _is_below(points: FloatArray, planes: FloatArray, tolerance: float) -> bool:
    """Return whether no point rises above any of the planes."""
    columns = np.ascontiguousarray(points.T)
    # Few faces at a time, and always into the same memory, keep the heights in the cache:
    # 2 ms instead of 34 for a sphere of 4000 triangles.
    heights = np.empty((64, len(points)))
    for start in range(0, len(planes), len(heights)):
        some = planes[start : start + len(heights)]
        along = np.matmul(some[:, :3], columns, out=heights[: len(some)])
        if (along.max(axis=1) + some[:, 3]).max() > tolerance:
            return False
    return True


def _heights(points: FloatArray, planes: FloatArray) -> FloatArray:
    return np.asarray(points @ planes[:, :3].T + planes[:, 3])


def _distinct(planes: FloatArray, positions: FloatArray) -> FloatArray:
    """Return each plane once: the two triangles of a rectangle share theirs."""
    scale = float(np.abs(positions).max())
    rounded = np.round(planes / [1.0, 1.0, 1.0, scale], 9)
    return np.asarray(planes[np.unique(rounded, axis=0, return_index=True)[1]])


def _corners(low: FloatArray, high: FloatArray) -> FloatArray:
    return np.asarray(np.where(np.indices((2, 2, 2)).reshape(3, 8).T, high, low))


def _spread(count: int, wanted: int) -> IntArray:
    """Return up to `wanted` of the numbers below `count`, evenly spread."""
    return np.unique(np.linspace(0, count - 1, min(count, wanted)).astype(np.int64))


def _planes(mesh: Mesh, chosen: IntArray) -> FloatArray:
    a, b, c = (mesh.positions[mesh.triangles[chosen, i]] for i in range(3))
    edge_1, edge_2 = b - a, c - a
    # The longest edge as unit keeps tiny triangles from underflowing.
    size = np.maximum(np.abs(edge_1).max(axis=1), np.abs(edge_2).max(axis=1))[:, None]
    normal = np.cross(edge_1 / size, edge_2 / size)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return np.concatenate([normal, -np.sum(normal * a, axis=1, keepdims=True)], axis=1)


@dataclass(frozen=True, eq=False)
class Bodies:
    """All instances of all objects, N of them, as boxes in world space.

    Attributes
    ----------
    center : ndarray, shape (N, 3)
    half_edges : ndarray, shape (N, 3, 3)
        Rows are half the edges of the box around the body: a parallelepiped.
    form : ndarray, shape (N,), int64
        `ANY`, `CONVEX_SOLID` or `FLAT`.
    light : ndarray, shape (N,), int64
        The light whose visible body it is, or -1.
    mesh_forms : tuple of MeshForm
        Of each body.
    world_from_object : ndarray, shape (N, 4, 4)
    """

    center: FloatArray
    half_edges: FloatArray
    form: IntArray
    light: IntArray
    mesh_forms: tuple[MeshForm, ...]
    world_from_object: FloatArray

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
        normal = unit(cofactor @ self.mesh_forms[body].planes[0, :3])
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
        """Return whether a point lies in the convex solid `body`, or too close to tell."""
        planes = self.mesh_forms[body].planes
        matrix = self.world_from_object[body]
        try:
            local = np.linalg.solve(matrix[:3, :3], point_ws - matrix[:3, 3])
        except np.linalg.LinAlgError:
            return True
        half = float(np.linalg.norm(self.mesh_forms[body].half_extent))
        # A billionth of the size: far above rounding, far below what a picture shows.
        return bool(np.max(planes[:, :3] @ local + planes[:, 3]) <= 1e-9 * half)


def _forms_of(meshes: Sequence[Mesh]) -> dict[int, MeshForm]:
    """Return the form of each mesh by its id: of as many as a scene has the time for."""
    each = {id(mesh): mesh for mesh in meshes}
    forms: dict[int, MeshForm] = {}
    looks = 0
    for number in list(each)[:MOST_MESHES]:
        mesh = each[number]
        # What was found out before counts like the rest, or plans would depend on it.
        if looks + _likely_looks(mesh) <= MOST_LOOKS_PER_SCENE:
            forms[number] = form_of(mesh)
            looks += forms[number].looks
    rest = [number for number in each if number not in forms]
    if rest:
        counts = [len(each[number].positions) for number in rest]
        starts = np.cumsum([0, *counts[:-1]])
        positions = np.concatenate([each[number].positions for number in rest])
        low = np.minimum.reduceat(positions, starts, axis=0)
        high = np.maximum.reduceat(positions, starts, axis=0)
        planes, outline = np.empty((0, 4)), np.empty((0, 3))
        for number, center, half in zip(rest, 0.5 * (low + high), 0.5 * (high - low), strict=True):
            forms[number] = MeshForm(center, half, ANY, planes, outline)
    return forms


def _likely_looks(mesh: Mesh) -> int:
    """Return how many looks it may take, at most, to find out the form of `mesh`."""
    is_tried = mesh.closed and len(mesh.triangles) <= MOST_FACES
    return min(len(mesh.triangles) * len(mesh.positions), MOST_LOOKS) if is_tried else 0


def bodies_of(scene: Scene) -> Bodies:
    """Return the bodies of `scene` as it stands."""
    known = _forms_of([scene.meshes[item.mesh] for item in scene.objects])
    forms = [known[id(scene.meshes[item.mesh])] for item in scene.objects]
    counts = [len(item.world_from_object) for item in scene.objects]
    if not any(counts):
        none = np.empty((0, 3))
        integers = np.empty(0, dtype=np.int64)
        return Bodies(none, np.empty((0, 3, 3)), integers, integers, (), np.empty((0, 4, 4)))
    matrices = np.concatenate([item.world_from_object for item in scene.objects])
    center = np.repeat([form.center for form in forms], counts, axis=0)
    half = np.repeat([form.half_extent for form in forms], counts, axis=0)
    kinds = [_kind(scene, number, form) for number, form in enumerate(forms)]
    lights = [-1 if item.light is None else item.light for item in scene.objects]
    return Bodies(
        center=np.einsum("nij,nj->ni", matrices[:, :3, :3], center) + matrices[:, :3, 3],
        # Column k of the matrix times the box's half extent along k, as rows.
        half_edges=matrices[:, :3, :3].transpose(0, 2, 1) * half[:, :, None],
        form=np.repeat(kinds, counts),
        light=np.repeat(lights, counts),
        mesh_forms=tuple(form for form, n in zip(forms, counts, strict=True) for _ in range(n)),
        world_from_object=matrices,
    )


def unit(vectors: FloatArray) -> FloatArray:
    """Return vectors (..., 3) of length one; zero stays zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))


def _kind(scene: Scene, number: int, form: MeshForm) -> int:
    """A solid with holes cut out of it shows its inside; a flat sheet has none."""
    material = scene.materials[scene.objects[number].material]
    cut_out = material.alpha_cutoff is not None
    return ANY if cut_out and form.form == CONVEX_SOLID else form.form
