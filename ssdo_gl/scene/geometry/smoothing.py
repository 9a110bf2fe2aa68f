"""Shading normals for meshes whose file has none: smooth but for creases."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, largest_of_rows, lengths_of_rows
from ssdo_gl.scene.geometry.topology import face_normals, joined_vertices, spans

# Where more triangles meet in one vertex, and not smoothly, they keep their own normals.
_MAX_STAR = 512
_PAIRS_AT_ONCE = 1 << 22
# Normals closer than this belong to one vertex.
_SAME_NORMAL = 1e-6


# Of each vertex, the one that it was before, and the normal; between them the triangles.
Smoothed = tuple[NDArray[np.int64], NDArray[np.int64], FloatArray]


def smooth_normals(
    positions: FloatArray, triangles: NDArray[np.int64], crease_degrees: float, *, joins: bool
) -> Smoothed | None:
    """Return vertices with normals that are smooth except across creases; None: all is flat.

    The normal at each corner of a triangle is the mean of the normals of all triangles that
    meet there and lean from it by at most the crease angle, weighted by their angles at the
    vertex (Thuermer and Wuethrich 1998). Vertices at equal positions count as one; those at
    a crease are split.

    Parameters
    ----------
    crease_degrees : float
        [0, 180].
    joins : bool
        Whether vertices at equal positions become one, as nothing else tells them apart.
    """
    vertex = joined_vertices(positions)[triangles].reshape(-1)
    faces = face_normals(positions, triangles)
    angles = _corner_angles(positions, triangles)
    normals = _star_normals(vertex, faces, angles)
    creased = _creased_vertices(
        vertex, faces, normals, float(np.cos(np.radians(crease_degrees / 2.0)))
    )
    at_crease = np.flatnonzero(creased[vertex])
    own = _creased(
        vertex[at_crease],
        at_crease,
        faces,
        angles.reshape(-1),
        float(np.cos(np.radians(crease_degrees))),
    )
    stands_out = np.abs(own - faces[at_crease // 3]).max(initial=0.0) >= _SAME_NORMAL
    if not stands_out and not _is_smooth(vertex, faces, normals, creased):
        return None
    del faces, angles
    place = vertex if joins else triangles.reshape(-1)
    return _split(triangles, place, vertex, normals, at_crease, own)


def _star_normals(vertex: NDArray[np.int64], faces: FloatArray, angles: FloatArray) -> FloatArray:
    """Return the normal of each vertex (V, 3): the mean of all triangles that meet there."""
    total = np.zeros((3, int(vertex.max()) + 1))
    for span in spans(len(faces)):
        weighted = (angles[span, :, None] * faces[span, None]).reshape(-1, 3)
        for axis in range(3):
            np.add.at(total[axis], vertex[3 * span.start : 3 * span.stop], weighted[:, axis])
    return _unit(total.T, np.zeros((1, 3)))


def _creased_vertices(
    vertex: NDArray[np.int64], faces: FloatArray, normals: FloatArray, least_cosine: float
) -> NDArray[np.bool_]:
    """Return at which vertices (V,) a triangle leans from the mean of all.

    All triangles of a star within half the angle of its mean are within it of one another.
    """
    creased = np.zeros(len(normals), dtype=bool)
    for corners, of_corner, smooth in _by_corner(vertex, faces, normals):
        creased[corners[np.einsum("ij,ij->i", of_corner, smooth) < least_cosine]] = True
    return creased


def _is_smooth(
    vertex: NDArray[np.int64], faces: FloatArray, normals: FloatArray, creased: NDArray[np.bool_]
) -> bool:
    """Return whether a vertex without crease has a normal that is not its triangles' own."""
    return any(
        np.any((largest_of_rows(smooth - of_corner) >= _SAME_NORMAL) & ~creased[corners])
        for corners, of_corner, smooth in _by_corner(vertex, faces, normals)
    )


def _by_corner(
    vertex: NDArray[np.int64], faces: FloatArray, normals: FloatArray
) -> Iterator[tuple[NDArray[np.int64], FloatArray, FloatArray]]:
    """Yield the vertex of corners (N,), the normal of its triangle and its own, (N, 3) each."""
    for span in spans(len(faces)):
        corners = vertex[3 * span.start : 3 * span.stop]
        yield corners, np.repeat(faces[span], 3, axis=0), np.take(normals, corners, axis=0)


def _unit(vectors: FloatArray, otherwise: FloatArray) -> FloatArray:
    length = lengths_of_rows(vectors)[:, None]
    return np.where(length > 1e-9, vectors / np.where(length > 1e-9, length, 1.0), otherwise)


def _corner_angles(positions: FloatArray, triangles: NDArray[np.int64]) -> FloatArray:
    """Return the angle of every corner, (T, 3), radians."""
    angles = np.empty((len(triangles), 3))
    for span in spans(len(angles)):
        corners = np.take(positions, triangles[span], axis=0)
        edges = np.roll(corners, -1, axis=1) - corners
        # The longest edge as unit keeps tiny triangles from underflowing.
        largest = largest_of_rows(edges.reshape(-1, 3)).reshape(-1, 3)
        edges = edges / largest_of_rows(largest)[:, None, None]
        edges = edges / np.maximum(lengths_of_rows(edges.reshape(-1, 3)), 1e-300).reshape(-1, 3, 1)
        cosine = -np.einsum("tkc,tkc->tk", edges, np.roll(edges, 1, axis=1))
        angles[span] = np.arccos(np.clip(cosine, -1.0, 1.0))
    return angles


def _creased(
    vertex: NDArray[np.int64],
    corner: NDArray[np.int64],
    faces: FloatArray,
    angles: FloatArray,
    cosine: float,
) -> FloatArray:
    """Return the normals of corners (N,), each the mean of those that lean little from it.

    Parameters
    ----------
    vertex, corner : ndarray, shape (N,)
        Where each corner is, and its number: row of `angles`, triangle `corner` // 3.
    """
    order = np.argsort(vertex, kind="stable")
    face = corner // 3
    starts = np.flatnonzero(np.diff(vertex[order], prepend=-1))
    sizes = np.diff(np.append(starts, len(order)))
    result = faces[face]
    pairs = np.cumsum(np.where(sizes <= _MAX_STAR, sizes**2, 0))
    first = 0
    while first < len(starts):
        done = pairs[first - 1] if first else 0
        last = max(int(np.searchsorted(pairs, done + _PAIRS_AT_ONCE)), first + 1)
        chosen = np.arange(first, min(last, len(starts)))
        first = last
        begin = starts[chosen[0]]
        chosen = chosen[sizes[chosen] <= _MAX_STAR]
        size = sizes[chosen]
        # Every corner of a star beside every other one.
        star = np.repeat(np.arange(len(chosen)), size**2)
        within = np.arange(len(star)) - np.repeat(np.cumsum(size**2) - size**2, size**2)
        one = starts[chosen][star] + within // size[star]
        other = order[starts[chosen][star] + within % size[star]]
        leaning = np.take(faces, face[order[one]], axis=0)
        of_other = np.take(faces, face[other], axis=0)
        near = np.einsum("ij,ij->i", leaning, of_other) >= cosine - 1e-9
        one, other = one[near], other[near]
        weighted = angles[corner[other], None] * of_other[near]
        # Counted from the first corner of this part.
        total = np.stack([np.bincount(one - begin, weighted[:, k]) for k in range(3)], axis=1)
        done_corners = begin + np.flatnonzero(np.bincount(one - begin))
        rows = order[done_corners]
        result[rows] = _unit(total[done_corners - begin], faces[face[rows]])
    return result


def _split(
    triangles: NDArray[np.int64],
    place: NDArray[np.int64],
    vertex: NDArray[np.int64],
    normals: FloatArray,
    at_crease: NDArray[np.int64],
    own: FloatArray,
) -> Smoothed:
    """Return a vertex for each normal of a place.

    Parameters
    ----------
    place, vertex : ndarray, shape (3 T,)
        Of corners: what may share a vertex, and the first vertex at its position.
    normals : ndarray, shape (V, 3)
        Of each vertex that has no crease.
    at_crease, own : ndarray, shape (N,) and (N, 3)
        The corners that have one, and their normals.
    """
    code = np.round(own / _SAME_NORMAL).astype(np.int64)
    order = np.lexsort((*code.T, place[at_crease]))
    rows = np.concatenate([place[at_crease][:, None], code], axis=1)[order]
    is_new = np.ones(len(rows), dtype=bool)
    is_new[1:] = np.any(rows[1:] != rows[:-1], axis=1)
    # One vertex for each place in use, and as many as it has normals at a crease.
    counts = np.zeros(int(place.max()) + 1, dtype=np.int64)
    counts[place] = 1
    counts[place[at_crease]] = 0
    np.add.at(counts, rows[is_new, 0], 1)
    starts = np.cumsum(counts) - counts
    number = starts[place]
    rank = np.cumsum(is_new) - 1
    before = np.cumsum(np.bincount(rows[is_new, 0], minlength=len(counts)))
    number[at_crease[order]] += rank - (before - counts)[rows[:, 0]]
    # Written backwards, so that the first corner of each vertex stays.
    first = np.empty(int(counts.sum()), dtype=np.int64)
    first[number[::-1]] = np.arange(len(number) - 1, -1, -1)
    kept = triangles.reshape(-1)[first]
    of_first = normals[vertex[first]]
    of_first[number[at_crease[order[is_new]]]] = own[order[is_new]]
    return kept, number.reshape(-1, 3), of_first
