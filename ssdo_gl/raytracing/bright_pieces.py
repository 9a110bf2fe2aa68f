"""Surfels that are so bright, and so small from afar, that rays should be aimed at them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.raytracing.emitter_tables import BODY_CODE, ENTRY_TEXELS, KIND_PARALLELOGRAM
from ssdo_gl.raytracing.emitter_tree import EmitterTree, emitter_tree
from ssdo_gl.raytracing.packed import unit_vectors
from ssdo_gl.raytracing.surfel_points import POINTS_PER_SIDE
from ssdo_gl.raytracing.torn_surfels import TornSurfels
from ssdo_gl.raytracing.triangles import SceneTriangles

# Rays are aimed at what sends more than so many times what rays meet in the mean, this left out,
BRIGHT = 8.0
# but only where what sends more than so many times the mean brings this share of all light: in
# built-in scenes at most .015, in rooms with a bulb in a shade, a candle or a patch of sun from
# .14 to .85.
VERY_BRIGHT, LEAST_SHARE = 16.0, 0.05
# Turns in which the mean of what is left settles.
TURNS = 6
# A surfel that no ray has met counts as if a quarter had.
LEAST_MET = 0.25
# Where so many would meet it that see it, it is not seen.
MOST_MISSED = 3.0
# Normals of flat surfels have at least this cosine to their mean.
FLAT = 0.996
# What a box around points is larger by, at least, for rounding.
ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class BrightSurfels:
    """Surfels to aim at.

    Attributes
    ----------
    numbers : ndarray, shape (B,), int64
    sent : ndarray, shape (B,)
        Radiance that each sends, up to a factor.
    met : ndarray, shape (B,)
        How many rays of other surfels have met it.
    """

    numbers: IntArray
    sent: FloatArray
    met: FloatArray


@dataclass(frozen=True, eq=False)
class BrightPieces:
    """Surfels to aim at as parallelograms, and a tree over them.

    Attributes
    ----------
    surfels : ndarray, shape (B,), int64
        Their numbers.
    faces : ndarray, shape (B, 2), int64
        The first parallelogram of each, and how many it has: one in which it lies, or if it is
        curved the faces of a box around it.
    owners : ndarray, shape (F,), int64
        The surfel that each parallelogram is of.
    entries : ndarray, shape (F, 8, 4), float32
        As `EmitterTables.entries`, of radiance 1: what surfels send is looked up.
    """

    surfels: IntArray
    faces: IntArray
    owners: IntArray
    entries: NDArray[np.float32]
    tree: EmitterTree


def bright_surfels(targets: IntArray, albedos: FloatArray, light: FloatArray) -> BrightSurfels:
    """Return the surfels that rays should be aimed at, none where there are no such.

    Parameters
    ----------
    targets : ndarray, shape (R,)
        The surfel that each ray of all surfels has met; those that met none are left out.
    albedos : ndarray, shape (R,)
        What it reflects there, [0, 1].
    light : ndarray, shape (S,)
        What each surfel receives, W m^-2.
    """
    met = np.bincount(targets, minlength=len(light))
    reflected = np.bincount(targets, weights=albedos, minlength=len(light)) * light
    # What no ray has met is small, and may be the brightest of all.
    usual = float(albedos.mean()) if len(albedos) else 0.0
    sent = np.where(met > 0, reflected / np.maximum(met, 1), usual * light)
    mean = reflected.sum() / max(len(targets), 1)
    for _ in range(TURNS):
        dim = sent <= BRIGHT * mean
        mean = reflected[dim].sum() / max(met[dim].sum(), 1)
    few = reflected[sent > VERY_BRIGHT * mean].sum() <= LEAST_SHARE * reflected.sum()
    numbers = np.arange(0) if few else np.flatnonzero(sent > BRIGHT * mean)
    return BrightSurfels(numbers, sent[numbers], met[numbers].astype(np.float64))


def bright_pieces(
    bright: BrightSurfels, surfels: TornSurfels, triangles: SceneTriangles
) -> BrightPieces:
    """Return the chosen ones of `surfels` as pieces to aim at, where their `triangles` are now."""
    chosen = bright.numbers
    points = surfels.positions[chosen].astype(np.float64)
    normals = unit_vectors(surfels.normals[chosen])
    normal = normals.mean(axis=1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    is_flat = np.einsum("snk,sk->sn", normals, normal).min(axis=1) > FLAT
    axes = _axes(points, normal)
    middle = points.mean(axis=1)
    low, high = _extents(points - middle[:, None], axes)
    # Points lie in the middles of 4 x 4 cells, about; of many triangles that share a surfel they
    # are too few to tell how far these reach.
    sources = np.sort(surfels.sources[chosen], axis=1)
    is_joined = (np.diff(sources, axis=1) > 0).sum(axis=1, keepdims=True) > 1
    corners = triangles.positions[sources].reshape(len(chosen), -1, 3)
    least, most = _extents(corners - middle[:, None], axes)
    low = np.where(is_joined, np.minimum(low, least), low)
    high = np.where(is_joined, np.maximum(high, most), high)
    pad = (high - low) / (2.0 * (POINTS_PER_SIDE - 1)) + ROUNDING
    low, high = low - pad, high + pad
    low[is_flat, 2], high[is_flat, 2] = 0.0, 0.0
    faces = np.where(is_flat, 1, 6)
    owner = np.repeat(np.arange(len(chosen)), faces)
    first = np.cumsum(faces) - faces
    entries = _faces(middle, axes, low, high, owner, np.arange(len(owner)) - first[owner])
    # As much as is seen of them: what stands outside of a room is met by few rays for its size.
    area = np.bincount(owner, weights=entries[:, 2, 3], minlength=len(chosen))
    often = bright.met / area
    usual = float(np.median(often[often > 0.0])) if often.any() else 1.0
    seen = np.minimum(np.maximum(bright.met, LEAST_MET) / (usual * area), 1.0)
    seen[(bright.met == 0.0) & (usual * area > MOST_MISSED)] = 0.0
    entries[:, 3, :3] = (seen * bright.sent)[owner, None]
    tree = emitter_tree(entries.astype(np.float32))
    entries[:, 3, :3] = 1.0
    numbers = np.stack([first, faces], axis=1)
    return BrightPieces(chosen, numbers, chosen[owner], entries.astype(np.float32), tree)


def _axes(points: FloatArray, normal: FloatArray) -> FloatArray:
    """Return three axes (S, 3, 3) of each surfel, the last one its normal."""
    along = points[:, POINTS_PER_SIDE - 1] - points[:, 0]
    along -= np.einsum("sk,sk->s", along, normal)[:, None] * normal
    # Of a curved surfel these points may lie above each other.
    other = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal), axis=1)])
    is_short = np.linalg.norm(along, axis=1, keepdims=True) < ROUNDING
    along = np.where(is_short, other, along)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return np.stack([along, np.cross(normal, along), normal], axis=1)


def _extents(points: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
    place = np.einsum("snk,sak->san", points, axes)
    return place.min(axis=2), place.max(axis=2)


def _faces(
    middle: FloatArray,
    axes: FloatArray,
    low: FloatArray,
    high: FloatArray,
    owner: IntArray,
    face: IntArray,
) -> FloatArray:
    """Return faces of boxes as entries, (F, 8, 4): number 0 is the front, along the last axis.

    Parameters
    ----------
    low, high : ndarray, shape (S, 3)
        Where boxes end along their `axes`, from their `middle`.
    owner, face : ndarray, shape (F,)
        Whose face each is, and which of six.
    """
    row = np.arange(len(owner))
    out = np.array([2, 2, 0, 0, 1, 1])[face]
    is_low = face % 2 == 1
    # Edges turn from the first to the second as seen from outside.
    first = np.where(is_low, out + 2, out + 1) % 3
    second = np.where(is_low, out + 1, out + 2) % 3
    corner = low[owner].copy()
    corner[row, out] = np.where(is_low, low[owner, out], high[owner, out])
    extent, axes = (high - low)[owner], axes[owner]
    edge_u, edge_v = (extent[row, i][:, None] * axes[row, i] for i in (first, second))
    entries = np.zeros((len(owner), ENTRY_TEXELS, 4))
    entries[:, 0, :3] = middle[owner] + np.einsum("fa,fak->fk", corner, axes)
    entries[:, 0, 3] = KIND_PARALLELOGRAM + BODY_CODE
    entries[:, 1, :3], entries[:, 2, :3] = edge_u, edge_v
    entries[:, 2, 3] = np.linalg.norm(np.cross(edge_u, edge_v), axis=1)
    # No image.
    entries[:, 5, 2], entries[:, 5, 3] = -1.0, 1.0
    return entries
