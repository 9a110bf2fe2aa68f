"""What emitters send that show an image: its mean over each, and over cells of large ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.emissive_meshes import linear_texels
from ssdo_gl.scene.scene import Scene

# Along each edge of a parallelogram, and of all of a scene together.
MOST_CELLS = 16
MOST_OF_ALL = 8192
# Points along each edge at which a mean is taken, at most, and about as many of all together.
POINTS = 8
POINTS_OF_ALL = 2**20
# Relative: means of cells that differ by less are of one colour.
EVEN = 1e-3
# What a cell counts at least, of the mean of all: texels between points may shine.
LEAST = 0.02


def with_images(
    rows: FloatArray, scene: Scene, *, cuts: bool
) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return rows of `EmitterTables` that know the mean of their image, and the old row of each.

    Parameters
    ----------
    rows : ndarray, shape (N, 8, 4)
    cuts : bool
        Cut those with an image into equal cells, along both edges.
    """
    materials = rows[:, 5, 2].astype(np.int64)
    shows = np.array([m.emission_texture is not None for m in scene.materials])[materials]
    per_side = 1
    if cuts and shows.any():
        per_side = int(np.clip(np.sqrt(MOST_OF_ALL / shows.sum()), 1, MOST_CELLS))
    sides = np.where(shows, per_side, 1)
    result, source = _cells(rows, sides, scene, folds=not cuts)
    if per_side > 1:
        # What shows one colour all over is as good whole.
        lowest, highest = np.full(len(rows), np.inf), np.zeros(len(rows))
        np.minimum.at(lowest, source, result[:, 5, 3])
        np.maximum.at(highest, source, result[:, 5, 3])
        sides[highest - lowest <= EVEN * highest] = 1
        result, source = _cells(rows, sides, scene, folds=not cuts)
    return result, source


def _cells(
    rows: FloatArray, sides: NDArray[np.int64], scene: Scene, *, folds: bool
) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return rows cut into so many cells along each edge, and of each the old one."""
    source = np.repeat(np.arange(len(rows)), sides**2)
    result = rows[source]
    number = np.arange(len(source)) - (np.cumsum(sides**2) - sides**2)[source]
    per_side = sides[source]
    _cut(result, np.stack([number % per_side, number // per_side], axis=1), per_side)
    materials = result[:, 5, 2].astype(np.int64)
    for index in np.unique(materials):
        if scene.materials[index].emission_texture is not None:
            mine = np.flatnonzero(materials == index)
            result[mine, 5, 3] = _means(result[mine], scene, int(index), folds=folds)
    return result, source


def _cut(rows: FloatArray, cell: NDArray[np.int64], per_side: NDArray[np.int64]) -> None:
    """Make each row one of its cells."""
    size = 1.0 / per_side[:, None]
    s = cell * size
    rows[:, 0, :3] += s[:, :1] * rows[:, 1, :3] + s[:, 1:] * rows[:, 2, :3]
    rows[:, 1, :3] *= size
    rows[:, 2, :3] *= size
    rows[:, 2, 3] *= size[:, 0] ** 2
    for texel in (4, 6):
        rows[:, texel, :2] += s[:, :1] * rows[:, texel, 2:] + s[:, 1:] * rows[:, texel + 1, :2]
        rows[:, texel, 2:] *= size
        rows[:, texel + 1, :2] *= size


def _means(rows: FloatArray, scene: Scene, material: int, *, folds: bool) -> FloatArray:
    """Return the mean of the image of each, but of none nothing; `folds`: of triangles."""
    texture = scene.materials[material].emission_texture
    assert texture is not None
    count = int(np.clip(np.sqrt(POINTS_OF_ALL / len(rows)), 2, POINTS))
    step = (np.arange(count) + 0.5) / count
    sums = np.zeros(len(rows))
    size = np.array(texture.pixels.shape[1::-1])
    for place in np.stack(np.meshgrid(step, step), axis=-1).reshape(-1, 2):
        # The far half of the square folds over onto the triangle.
        s, t = 1.0 - place if folds and place.sum() > 1.0 else place
        uv = rows[:, 4, :2] + s * rows[:, 4, 2:] + t * rows[:, 5, :2]
        # Half a texel to each side: whatever takes part where colours are interpolated.
        for shift in ((-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)):
            sums += linear_texels(texture.pixels, uv + shift / size).mean(axis=1)
    means = sums / (4 * count**2)
    return np.asarray(means + LEAST * max(float(means.mean()), 1e-6))
