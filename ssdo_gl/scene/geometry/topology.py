"""Making triangle lists fit to draw, and telling solids from open surfaces."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FLAT_SINE, FloatArray, largest_of_rows, lengths_of_rows
from ssdo_gl.scene.geometry.mesh import Mesh, spans
from ssdo_gl.scene.numbers import LARGEST_NUMBER


@dataclass(frozen=True)
class Cleaned:
    """A usable mesh and what had to go.

    Attributes
    ----------
    mesh : Mesh or None
        None if no triangle was left.
    not_finite, zero_area, bad_normals : int
        Dropped triangles with NaN or infinite corners, dropped triangles without
        area, and vertices whose shading normal was replaced.
    """

    mesh: Mesh | None
    not_finite: int = 0
    zero_area: int = 0
    bad_normals: int = 0


def check_vertices(named: NDArray[np.int64], count: int) -> None:
    """Raise ValueError if any of the vertices that faces name is not one of `count`."""
    wrong = named[(named < 0) | (named >= count)]
    if wrong.size:
        raise ValueError(f"a face refers to vertex {wrong.max()} of {count}")


def cleaned_mesh(raw: Mesh, closed: bool | None = None) -> Cleaned:
    """Return a mesh without unusable triangles and unused vertices.

    Parameters
    ----------
    raw : Mesh
        Nothing but the shapes of its arrays is relied on. Tangents that are no direction become 0.
    closed : bool or None
        Whether they bound a solid; None: that is found out.

    Raises
    ------
    ValueError
        If a triangle names a vertex that does not exist.
    """
    positions, triangles, colors = raw.positions, raw.triangles, raw.colors
    check_vertices(triangles, len(positions))
    finite = np.asarray(np.isfinite(positions).all(axis=1))
    given = len(triangles)
    if not finite.all():
        triangles = triangles[finite[triangles].all(axis=1)]
    not_finite = given - len(triangles)
    flat = _without_area(positions, triangles)
    zero_area = int(np.count_nonzero(flat))
    if zero_area:
        triangles = triangles[~flat]
    if not len(triangles):
        return Cleaned(None, not_finite, zero_area)
    is_used = np.zeros(len(positions), dtype=bool)
    is_used[triangles] = True
    used = np.flatnonzero(is_used)
    triangles = (np.cumsum(is_used) - 1)[triangles]
    points = np.ascontiguousarray(positions[used], dtype=np.float64)
    mesh = Mesh(
        positions=points,
        triangles=triangles,
        uvs=_usable_uvs(raw.uvs, used),
        second_uvs=_usable_uvs(raw.second_uvs, used),
        colors=None if colors is None else np.clip(np.nan_to_num(colors[used]), 0.0, 1.0),
        closed=is_closed(points, triangles) if closed is None else closed,
        name=raw.name,
    )
    if raw.normals is None:
        return Cleaned(mesh, not_finite, zero_area)
    unit, replaced = _unit_normals(raw.normals[used], mesh)
    tangents = None if raw.tangents is None else unit_tangents(raw.tangents[used])
    mesh = dataclasses.replace(mesh, normals=unit, tangents=tangents)
    return Cleaned(mesh, not_finite, zero_area, replaced)


def unit_tangents(tangents: FloatArray) -> FloatArray:
    """Return tangents (V, 4) of unit length with a handedness of 1 or -1, or 0 throughout."""
    largest = np.abs(tangents[:, :3]).max(axis=1, initial=0.0)
    good = np.isfinite(tangents).all(axis=1) & (largest > 0.0)
    scaled = np.where(good, tangents.T, 0.0)[:3] / np.where(good, largest, 1.0)
    length = np.linalg.norm(scaled, axis=0)
    sign = np.where(good, np.where(tangents[:, 3] < 0.0, -1.0, 1.0), 0.0)
    return np.column_stack([(scaled / np.where(good, length, 1.0)).T, sign])


def _usable_uvs(uvs: FloatArray | None, used: NDArray[np.int64]) -> FloatArray | None:
    return None if uvs is None else np.where(np.abs(uvs[used]) <= LARGEST_NUMBER, uvs[used], 0.0)


def _without_area(positions: FloatArray, triangles: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which triangles have no area at the scale of their own edges."""
    flat = np.empty(len(triangles), dtype=bool)
    for span in spans(len(triangles)):
        a, b, c = np.moveaxis(np.take(positions, triangles[span], axis=0), 1, 0)
        edge_1, edge_2 = b - a, c - a
        size = np.maximum(largest_of_rows(edge_1), largest_of_rows(edge_2))
        divisor = np.where(size > 0.0, size, 1.0)[:, None]
        cross = np.cross(edge_1 / divisor, edge_2 / divisor)
        flat[span] = lengths_of_rows(cross) <= FLAT_SINE
    return flat


def _unit_normals(normals: FloatArray, mesh: Mesh) -> tuple[FloatArray, int]:
    """Return unit normals; those that are no direction become the faces' own."""
    largest = np.abs(normals).max(axis=1, initial=0.0)
    good = np.isfinite(largest) & (largest > 0.0)
    scaled = np.where(good[:, None], normals, 0.0) / np.where(good, largest, 1.0)[:, None]
    length = np.linalg.norm(scaled, axis=1, keepdims=True)
    unit = scaled / np.where(length > 0.0, length, 1.0)
    if not good.all():
        faces = np.repeat(mesh.face_normals(), 3, axis=0)
        corner = mesh.triangles.reshape(-1)
        summed = np.stack(
            [np.bincount(corner, faces[:, k], len(normals)) for k in range(3)], axis=1
        )
        # Where the faces around a vertex cancel out, the last of them decides.
        single = np.zeros_like(summed)
        single[corner] = faces
        total = np.linalg.norm(summed, axis=1, keepdims=True)
        own = np.where(total > 1e-6, summed / np.where(total > 1e-6, total, 1.0), single)
        unit = np.where(good[:, None], unit, own)
    return unit, int(np.count_nonzero(~good))


def is_closed(positions: FloatArray, triangles: NDArray[np.int64]) -> bool:
    """Return whether the triangles bound a solid.

    True if, after vertices at equal positions are joined, every edge is shared by
    exactly two triangles that run through it in opposite directions.
    """
    corner = joined_vertices(positions)[triangles]
    count = len(triangles)
    forward, backward = np.empty((2, 3 * count), dtype=np.int64)
    for edge in range(3):
        start, end = corner[:, edge], corner[:, (edge + 1) % 3]
        if np.any(start == end):
            return False
        rows = slice(edge * count, (edge + 1) * count)
        np.add(start * len(positions), end, out=forward[rows])
        np.add(end * len(positions), start, out=backward[rows])
    forward.sort()
    if np.any(forward[1:] == forward[:-1]):
        return False
    backward.sort()
    return bool(np.array_equal(forward, backward))


def joined_vertices(positions: NDArray[np.floating[Any]]) -> NDArray[np.int64]:
    """Return for each vertex the first one at its position, shape (V,)."""
    key = _position_keys(positions)
    order = np.argsort(key)
    key = key[order]
    is_same = key[1:] == key[:-1]
    label = np.arange(len(positions))
    if not is_same.any():
        return label
    near = np.flatnonzero(is_same)
    if np.any(positions[order[near]] != positions[order[near + 1]]):
        # Two positions have one key, which is a matter of 2^-64: compare them themselves.
        order = np.lexsort(positions.T)
        is_same = np.all(positions[order[1:]] == positions[order[:-1]], axis=1)
    starts = np.flatnonzero(np.concatenate([[True], ~is_same]))
    first = np.minimum.reduceat(order, starts)
    label[order] = np.repeat(first, np.diff(np.append(starts, len(order))))
    return label


def _position_keys(positions: NDArray[np.floating[Any]]) -> NDArray[np.uint64]:
    """Return a number for each position (V, 3), equal ones alike, -0 as 0."""
    kind = np.uint32 if positions.dtype == np.float32 else np.uint64
    key = np.zeros(len(positions), dtype=np.uint64)
    for axis in range(3):
        key ^= (positions[:, axis] + positions.dtype.type(0.0)).view(kind)
        # Odd constant of the golden ratio. Coordinates that were float32 end in zeros, and
        # so do products: the shift brings their upper half down.
        key *= np.uint64(0x9E3779B97F4A7C15)
        key ^= key >> np.uint64(32)
    return key
