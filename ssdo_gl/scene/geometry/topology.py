"""Triangle lists as arrays: made fit to draw, placed; solids told from open surfaces."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FLAT_SINE, FloatArray, largest_of_rows, lengths_of_rows
from ssdo_gl.scene.numbers import LARGEST_NUMBER

SPAN = 1 << 14


def spans(count: int, length: int = SPAN) -> Iterator[slice]:
    """Yield slices of at most `length` that cover `count` rows, in order.

    Temporaries that fit into a cache take no memory, nor time.
    """
    for start in range(0, count, length):
        yield slice(start, min(start + length, count))


def are_mirrored(matrices: FloatArray) -> NDArray[np.bool_]:
    """Return which of the matrices (N, 3 or 4, 4) mirror what they move, (N,).

    Whatever their scales: those of 1e-320 leave the range of a determinant.
    """
    linear = matrices[:, :3, :3]
    size = np.abs(linear).max(axis=1, keepdims=True)
    return np.asarray(np.linalg.det(linear / np.where(size > 0.0, size, 1.0)) < 0.0)


def corners_within(
    points: FloatArray, triangles: NDArray[np.int64], is_chosen: NDArray[np.bool_]
) -> FloatArray:
    """Return the corners (K, 3, 3) of triangles of which all three are chosen.

    Parameters
    ----------
    points, is_chosen : ndarray, shape (N, V, 3) and (N, V)
        The vertices of copies of one mesh.
    """
    within = np.take(is_chosen, triangles[:, 0], axis=1)
    for corner in (1, 2):
        within &= np.take(is_chosen, triangles[:, corner], axis=1)
    copy, triangle = np.nonzero(within)
    return points[copy[:, None], triangles[triangle]]


def placed(points: FloatArray, matrices: FloatArray) -> FloatArray:
    """Return `points` (..., 3) as each of the matrices (N, 4, 4) places them, (N, ..., 3)."""
    linear = np.ascontiguousarray(matrices[:, :3, :3].transpose(0, 2, 1))
    rows = points.reshape(-1, 3)
    moved = np.empty((len(matrices), len(rows), 3))
    for span in spans(len(rows)):
        np.matmul(rows[span], linear, out=moved[:, span])
        moved[:, span] += matrices[:, None, :3, 3]
    return moved.reshape(len(matrices), *points.shape)


def face_normals(positions: FloatArray, triangles: NDArray[np.int64]) -> FloatArray:
    """Return unit geometric normals of triangles, shape (T, 3)."""
    normals = np.empty((len(triangles), 3))
    for span in spans(len(normals)):
        normals[span] = _face_normals(np.take(positions, triangles[span], axis=0))
    return normals


def _face_normals(corners: FloatArray) -> FloatArray:
    edge_1, edge_2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    # The longest edge as unit keeps tiny triangles from underflowing.
    size = np.maximum(largest_of_rows(edge_1), largest_of_rows(edge_2))[:, None]
    normal = np.cross(edge_1 / size, edge_2 / size)
    return np.asarray(normal / lengths_of_rows(normal)[:, None])


def check_vertices(named: NDArray[np.int64], count: int) -> None:
    """Raise ValueError if any of the vertices that faces name is not one of `count`."""
    wrong = named[(named < 0) | (named >= count)]
    if wrong.size:
        raise ValueError(f"a face refers to vertex {wrong.max()} of {count}")


def unit_tangents(tangents: FloatArray) -> FloatArray:
    """Return tangents (V, 4) of unit length with a handedness of 1 or -1, or 0 throughout."""
    largest = np.abs(tangents[:, :3]).max(axis=1, initial=0.0)
    good = np.isfinite(tangents).all(axis=1) & (largest > 0.0)
    scaled = np.where(good, tangents.T, 0.0)[:3] / np.where(good, largest, 1.0)
    length = np.linalg.norm(scaled, axis=0)
    sign = np.where(good, np.where(tangents[:, 3] < 0.0, -1.0, 1.0), 0.0)
    return np.column_stack([(scaled / np.where(good, length, 1.0)).T, sign])


def usable_uvs(uvs: FloatArray | None, used: NDArray[np.int64]) -> FloatArray | None:
    """Return the coordinates of `used` vertices, 0 where they are of no use."""
    return None if uvs is None else np.where(np.abs(uvs[used]) <= LARGEST_NUMBER, uvs[used], 0.0)


def without_area(positions: FloatArray, triangles: NDArray[np.int64]) -> NDArray[np.bool_]:
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


def unit_normals(
    normals: FloatArray, positions: FloatArray, triangles: NDArray[np.int64]
) -> tuple[FloatArray, int]:
    """Return unit normals; those that are no direction become the faces' own."""
    largest = np.abs(normals).max(axis=1, initial=0.0)
    good = np.isfinite(largest) & (largest > 0.0)
    scaled = np.where(good[:, None], normals, 0.0) / np.where(good, largest, 1.0)[:, None]
    length = np.linalg.norm(scaled, axis=1, keepdims=True)
    unit = scaled / np.where(length > 0.0, length, 1.0)
    if not good.all():
        faces = np.repeat(face_normals(positions, triangles), 3, axis=0)
        corner = triangles.reshape(-1)
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
