"""Shading normals for meshes whose file has none: smooth but for creases."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.mesh import Mesh
from ssdo_gl.scene.topology import joined_vertices

# Where more triangles meet in one vertex, and not smoothly, they keep their own normals.
_MAX_STAR = 512
_PAIRS_AT_ONCE = 1 << 22
# Normals closer than this belong to one vertex.
_SAME_NORMAL = 1e-6


def smoothed(mesh: Mesh, crease_degrees: float) -> Mesh:
    """Return the mesh with normals that are smooth except across creases.

    The normal at each corner of a triangle is the mean of the normals of all triangles that
    meet there and lean from it by at most the crease angle, weighted by their angles at the
    vertex (Thuermer and Wuethrich 1998). Vertices at equal positions count as one; those at
    a crease are split. What is flat all over stays a mesh without normals.

    Parameters
    ----------
    crease_degrees : float
        [0, 180].
    """
    vertex = joined_vertices(mesh.positions)[mesh.triangles].reshape(-1)
    faces = mesh.face_normals()
    weighted = _corner_angles(mesh)[:, :, None] * faces[:, None]
    weighted = weighted.reshape(-1, 3)
    of_corner = np.repeat(faces, 3, axis=0)
    count = int(vertex.max()) + 1
    total: FloatArray = np.stack(
        [np.bincount(vertex, weighted[:, k], count) for k in range(3)], axis=1
    ).astype(np.float64)
    normals = _unit(total, np.zeros((1, 3)))[vertex]
    # All triangles of a star within half the angle of its mean are within it of one another.
    leans = np.einsum("ij,ij->i", of_corner, normals) < np.cos(np.radians(crease_degrees / 2.0))
    creased = np.zeros(count, dtype=bool)
    creased[vertex[leans]] = True
    at_crease = np.flatnonzero(creased[vertex])
    normals[at_crease] = _creased(
        vertex[at_crease],
        of_corner[at_crease],
        weighted[at_crease],
        float(np.cos(np.radians(crease_degrees))),
    )
    if np.abs(normals - of_corner).max() < _SAME_NORMAL:
        return dataclasses.replace(mesh, normals=None)
    return _split(mesh, vertex, normals, at_crease)


def _unit(vectors: FloatArray, otherwise: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 1e-9, vectors / np.where(length > 1e-9, length, 1.0), otherwise)


def _corner_angles(mesh: Mesh) -> FloatArray:
    """Return the angle of every corner, (T, 3), radians."""
    corners = mesh.positions[mesh.triangles]
    edges = np.roll(corners, -1, axis=1) - corners
    # The longest edge as unit keeps tiny triangles from underflowing.
    edges = edges / np.abs(edges).max(axis=(1, 2), keepdims=True)
    edges = edges / np.maximum(np.linalg.norm(edges, axis=2, keepdims=True), 1e-300)
    cosine = -np.einsum("tkc,tkc->tk", edges, np.roll(edges, 1, axis=1))
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _creased(
    vertex: NDArray[np.int64], faces: FloatArray, weighted: FloatArray, cosine: float
) -> FloatArray:
    """Return the normals of corners (N,), each the mean of those that lean little from it."""
    order = np.argsort(vertex, kind="stable")
    starts = np.flatnonzero(np.diff(vertex[order], prepend=-1))
    sizes = np.diff(np.append(starts, len(order)))
    result = faces.copy()
    pairs = np.cumsum(np.where(sizes <= _MAX_STAR, sizes**2, 0))
    first = 0
    while first < len(starts):
        done = pairs[first - 1] if first else 0
        last = max(int(np.searchsorted(pairs, done + _PAIRS_AT_ONCE)), first + 1)
        chosen = np.arange(first, min(last, len(starts)))
        first = last
        chosen = chosen[sizes[chosen] <= _MAX_STAR]
        size = sizes[chosen]
        # Every corner of a star beside every other one.
        star = np.repeat(np.arange(len(chosen)), size**2)
        within = np.arange(len(star)) - np.repeat(np.cumsum(size**2) - size**2, size**2)
        one = order[starts[chosen][star] + within // size[star]]
        other = order[starts[chosen][star] + within % size[star]]
        near = np.einsum("ij,ij->i", faces[one], faces[other]) >= cosine - 1e-9
        one, other = one[near], other[near]
        total = np.stack(
            [np.bincount(one, weighted[other, k], len(vertex)) for k in range(3)], axis=1
        )
        done_corners = np.unique(one)
        result[done_corners] = _unit(total[done_corners], faces[done_corners])
    return result


def _split(
    mesh: Mesh, vertex: NDArray[np.int64], normals: FloatArray, at_crease: NDArray[np.int64]
) -> Mesh:
    """Return the mesh with a vertex for each normal of a place; equal places are joined."""
    shared = {
        field.name: getattr(mesh, field.name)
        for field in dataclasses.fields(mesh)
        if field.name not in ("positions", "triangles", "normals")
        and isinstance(getattr(mesh, field.name), np.ndarray)
    }
    place = mesh.triangles.reshape(-1) if shared else vertex
    code = np.zeros((len(place), 3), dtype=np.int64)
    code[at_crease] = np.round(normals[at_crease] / _SAME_NORMAL).astype(np.int64)
    order = np.lexsort((*code.T, place))
    rows = np.concatenate([place[:, None], code], axis=1)[order]
    is_new = np.ones(len(rows), dtype=bool)
    is_new[1:] = np.any(rows[1:] != rows[:-1], axis=1)
    number = np.empty(len(rows), dtype=np.int64)
    number[order] = np.cumsum(is_new) - 1
    first = order[is_new]
    kept = mesh.triangles.reshape(-1)[first]

    return dataclasses.replace(
        mesh,
        positions=mesh.positions[kept],
        triangles=number.reshape(-1, 3),
        normals=normals[first],
        **{name: values[kept] for name, values in shared.items()},
    )
