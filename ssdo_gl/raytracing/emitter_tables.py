"""All that shines on a scene, as tables from which rays draw points of light.

Unlike `Scene.lights`, in which a few rectangles may stand for an emissive mesh, this is
the exact light: every emissive triangle, where it is and as bright as it is.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.raytracing.bvh import Bvh
from ssdo_gl.raytracing.emitter_images import with_images
from ssdo_gl.scene.light_bodies import approximations, body_lights
from ssdo_gl.scene.lights import SHADOW_NUMBERS, Form, Light, kind_number
from ssdo_gl.scene.scene import Scene

# As rays/emitters.glsl numbers them. Lights without an area follow, by number of their kind.
KIND_PARALLELOGRAM, KIND_TRIANGLE, KIND_MAP, KIND_LIGHT = range(4)
TWO_SIDED_CODE, BODY_CODE = 64, 128
DIRECT_CODE, UNLIT_CODE, STAND_IN_CODE = 4, 8, 16
ENTRY_TEXELS = 8
GROUP_TEXELS = 2
# Corners of a quadrilateral may be off a parallelogram by this much of its extent: the
# rounding of positions to float32.
PARALLELOGRAM_TOLERANCE = 1e-6
# Importance of an environment map is kept for cells of at most this many rows; finer
# detail than 1.4 degrees is left to chance.
MAX_CELL_ROWS = 128


@dataclass(frozen=True, eq=False)
class EmitterTables:
    """Emitters in groups: one group is one light, or one body that glows.

    Attributes
    ----------
    entries : ndarray, shape (max(N, 1), 8, 4), float32
        Texels: 0 = position or corner, or direction towards a parallel light, and a code:
        kind + 64 if both sides emit + 128 if rays can hit the emitter; 1 = first edge, or
        axis of a light without an area, probability within the group; 2 = second edge,
        area (numbers of a light without an area: see `ShaderRow`); 3 = intensity,
        irradiance or radiance (lengths in normalised units), cumulative probability
        within the group including this entry; 4, 5 = texture coordinates at the corner,
        along the first and second edge (two each), material or -1, mean of the image of
        emission; 6, 7 = the same six
        numbers of the image of holes, where they differ from those of the emission.
    groups : ndarray, shape (max(G, 1), 2, 4), float32
        Texels: 0 = first entry, number of entries, shadow mode + 4 if the group's light
        counts as direct light + 8 if it is all bodies that no light of the scene stands for
        + 16 if only sample rectangles do, probability; 1 = cumulative probability including this
        group, 0, 0, 0.
    slots : ndarray, shape (N,), int64
        Of each entry the slot of its triangle, 2 times its primitive + 0 or 1: the first of two
        that a parallelogram joins; -1: a light without a body. A parallelogram that emits an
        image is cut into cells, row by row along its second edge.
    density : float
        Probability per area (normalised units) and mean emission with which a point of
        an emissive triangle is drawn.
    """

    entries: NDArray[np.float32]
    groups: NDArray[np.float32]
    group_count: int
    slots: NDArray[np.int64]
    density: float


# The slot of a light that is no triangle.
_NO_BODY = np.full(1, -1)


@dataclass(frozen=True)
class _EmitterGroup:
    rows: NDArray[np.float64]
    slots: NDArray[np.int64]  # of the entries
    weights: FloatArray
    power: float
    shadow: int
    is_direct: bool
    tree_code: int = 0


def emitter_tables(bvh: Bvh, scene: Scene, map_power: float = 0.0) -> EmitterTables:
    """Return the tables of all emitters of `scene`.

    Parameters
    ----------
    map_power : float
        Mean radiance of the environment map over all directions; 0 if there is none.
        Constant and gradient environments are met by scattered rays well enough.
    """
    bodies, covered = _bodies(bvh, scene)
    groups = bodies + [
        _light_group(light, bvh.triangles.centre, bvh.triangles.half_diagonal)
        for i, light in enumerate(scene.lights)
        if i not in covered
    ]
    if map_power > 0.0:
        row = np.zeros((1, ENTRY_TEXELS, 4))
        row[0, 0, 3] = KIND_MAP
        # The power that enters the unit sphere, which encloses the scene.
        groups.append(
            _EmitterGroup(row, _NO_BODY, np.ones(1), 4.0 * math.pi**2 * map_power, 1, False)
        )
    groups = [group for group in groups if group.power > 0.0]
    return _assemble(groups)


def _assemble(groups: Sequence[_EmitterGroup]) -> EmitterTables:
    total = sum(group.power for group in groups)
    entries = np.zeros((max(sum(len(g.rows) for g in groups), 1), ENTRY_TEXELS, 4))
    heads = np.zeros((max(len(groups), 1), GROUP_TEXELS, 4))
    first, cumulative = 0, 0.0
    for head, group in zip(heads, groups, strict=False):
        share = group.weights / group.weights.sum()
        rows = group.rows.copy()
        rows[:, 1, 3], rows[:, 3, 3] = share, np.cumsum(share)
        rows[-1, 3, 3] = 1.0
        entries[first : first + len(rows)] = rows
        cumulative += group.power / total
        code = group.shadow + DIRECT_CODE * group.is_direct + group.tree_code
        head[0] = first, len(rows), code, group.power / total
        head[1, 0] = cumulative
        first += len(rows)
    heads[-1, 1, 0] = 1.0
    return EmitterTables(
        entries.astype(np.float32),
        heads.astype(np.float32),
        len(groups),
        np.concatenate([group.slots for group in groups] or [_NO_BODY]),
        math.pi / total if groups else 0.0,
    )


def _bodies(bvh: Bvh, scene: Scene) -> tuple[list[_EmitterGroup], set[int]]:
    """Return a group for each glowing body, and the lights that they replace."""
    triangles = bvh.triangles
    emits = np.array([material.emits for material in scene.materials] or [False])
    if triangles.count == 0 or not emits[triangles.material].any():
        return [], set()
    rows, slots, weights, owner = _emissive_rows(bvh, scene, emits)
    groups: list[_EmitterGroup] = []
    covered: set[int] = set()
    runs, sampled = body_lights(scene), approximations(scene)
    for light in np.unique(owner):
        mine = owner == light
        shadow, is_direct, code = SHADOW_NUMBERS["map"], False, UNLIT_CODE
        if light >= 0:
            shadow, is_direct = SHADOW_NUMBERS[scene.lights[light].shadow], True
            is_sampled = light in sampled and scene.lights[light].shadow == "map"
            code = STAND_IN_CODE if is_sampled else 0
            covered.update(runs[int(light)])
        power = math.pi * float(weights[mine].sum())
        chosen = rows[mine], slots[mine], weights[mine]
        groups.append(_EmitterGroup(*chosen, power, shadow, is_direct, code))
    return groups, covered


def _emissive_rows(
    bvh: Bvh, scene: Scene, emits: NDArray[np.bool_]
) -> tuple[FloatArray, NDArray[np.int64], FloatArray, NDArray[np.int64]]:
    """Return rows, slots, weights and lights of emissive triangles, parallelograms joined."""
    triangles = bvh.triangles
    pair = bvh.primitive_triangles
    both = (pair >= 0) & emits[triangles.material[np.maximum(pair, 0)]]
    same = (triangles.material[pair[:, 0]] == triangles.material[pair[:, 1]]) & (
        triangles.light[pair[:, 0]] == triangles.light[pair[:, 1]]
    )
    vertices, hole_uvs, uvs = _pair_corners(bvh, scene)
    joined = both.all(axis=1) & same & _is_parallelogram(vertices)
    joined &= _is_parallelogram(uvs) & _is_parallelogram(hole_uvs)
    single = both & ~joined[:, None]
    # (primitive, kind, its triangle, corners that span it)
    parts = [
        (np.flatnonzero(joined), KIND_PARALLELOGRAM, 0, (0, 1, 3)),
        (np.flatnonzero(single[:, 0]), KIND_TRIANGLE, 0, (0, 1, 2)),
        (np.flatnonzero(single[:, 1]), KIND_TRIANGLE, 1, (0, 2, 3)),
    ]
    emission = np.array([material.emission for material in scene.materials])
    sides = np.array([1.0 + material.two_sided_emission for material in scene.materials])
    rows, slots, weights, owners = [], [], [], []
    for chosen, kind, second, (o, u, v) in parts:
        which = pair[chosen, second]
        material = triangles.material[which]
        corner = vertices[chosen, o]
        edge_u, edge_v = vertices[chosen, u] - corner, vertices[chosen, v] - corner
        area = np.linalg.norm(np.cross(edge_u, edge_v), axis=1)
        area *= 0.5 if kind == KIND_TRIANGLE else 1.0
        row = np.zeros((len(chosen), ENTRY_TEXELS, 4))
        row[:, 0, :3], row[:, 1, :3], row[:, 2, :3] = corner, edge_u, edge_v
        row[:, 0, 3] = kind + TWO_SIDED_CODE * (sides[material] - 1.0) + BODY_CODE
        row[:, 2, 3], row[:, 3, :3] = area, emission[material]
        for texel, its in ((4, uvs), (6, hole_uvs)):
            uv = its[chosen, o]
            row[:, texel, :2], row[:, texel, 2:] = uv, its[chosen, u] - uv
            row[:, texel + 1, :2] = its[chosen, v] - uv
        row[:, 5, 2], row[:, 5, 3] = material, 1.0
        weight = area * emission[material].mean(axis=1) * sides[material]
        row, source = with_images(row, scene, cuts=kind == KIND_PARALLELOGRAM)
        share = np.bincount(source, minlength=len(chosen))[source]
        rows.append(row)
        slots.append(2 * chosen[source] + second)
        weights.append(weight[source] / share)
        owners.append(triangles.light[which[source]])
    return (
        np.concatenate(rows),
        np.concatenate(slots),
        np.concatenate(weights),
        np.concatenate(owners),
    )


def _pair_corners(bvh: Bvh, scene: Scene) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return vertices (P, 4, 3) and texture coordinates (P, 4, 2) of all primitives.

    The first ones are those of the image with holes, the others of that of emission.
    """
    pair, corners = bvh.primitive_triangles, bvh.primitive_corners
    fourth = (np.maximum(pair[:, 1:], 0), corners[:, 1, 2:])
    first = (pair[:, :1], corners[:, 0])
    triangles = bvh.triangles
    glow_uvs = triangles.uvs
    if triangles.second_uvs is not None:
        on_second = np.array(["emission" in material.second_uvs for material in scene.materials])
        chosen = on_second[triangles.material][:, None, None]
        glow_uvs = np.where(chosen, triangles.second_uvs, glow_uvs)
    vertices, hole_uvs, uvs = (
        np.concatenate([array[first], array[fourth]], axis=1).astype(np.float64)
        for array in (triangles.positions, triangles.uvs, glow_uvs)
    )
    return vertices, hole_uvs, uvs


def _is_parallelogram(corners: FloatArray) -> NDArray[np.bool_]:
    gap = np.abs(corners[:, 0] - corners[:, 1] + corners[:, 2] - corners[:, 3]).max(axis=1)
    extent = np.ptp(corners, axis=1).max(axis=1)
    return np.asarray(gap <= PARALLELOGRAM_TOLERANCE * np.maximum(extent, 1.0))


def _light_group(light: Light, centre: FloatArray, unit: float) -> _EmitterGroup:
    """Return the group of one light without a body, lengths in units of `unit`."""
    own = light.emitter(centre, unit)
    row = np.zeros((1, ENTRY_TEXELS, 4))
    is_area = light.form is Form.AREA
    kind = KIND_PARALLELOGRAM if is_area else KIND_LIGHT + kind_number(light)
    row[0, 0] = *own.place, kind + TWO_SIDED_CODE * own.two_sided
    row[0, 1, :3] = own.axis
    row[0, 2] = *own.second_axis, own.number
    row[0, 3, :3] = own.emitted
    row[0, 5, 2] = -1.0
    return _EmitterGroup(row, _NO_BODY, np.ones(1), own.power, SHADOW_NUMBERS[light.shadow], True)


def map_mean_radiance(image: NDArray[np.float32]) -> float:
    """Return the mean over directions and channels of a lat-long map, row 0 = up."""
    edges = np.cos(np.pi * np.arange(len(image) + 1) / len(image))
    rows = image[..., :3].astype(np.float64).mean(axis=(1, 2))
    return float(np.sum(rows * (edges[:-1] - edges[1:])) / 2.0)


def map_cells(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return a table for drawing directions in proportion to a lat-long map's light.

    Parameters
    ----------
    image : ndarray, shape (height, width, >= 3)
        Radiance, row 0 = up.

    Returns
    -------
    ndarray, shape (rows, columns, 4), float32
        Walker's alias method: a cell is taken if a random number is below channel 0,
        else the cell numbered in channel 1; channel 2: the cell's probability density
        over solid angle.
    """
    radiance = image[..., :3].astype(np.float64).mean(axis=2)
    factor = max(1, -(-len(radiance) // MAX_CELL_ROWS))
    rows, columns = (-(-n // factor) for n in radiance.shape)
    # A cell takes the largest light of the texels that it touches, so that no light is
    # left without a chance where cells and texels do not line up.
    bands = np.array([radiance[span].max(axis=0) for span in _spans(len(radiance), rows)])
    cells = np.array([bands[:, span].max(axis=1) for span in _spans(bands.shape[1], columns)]).T
    edges = np.cos(np.pi * np.arange(rows + 1) / rows)
    solid_angle = (edges[:-1] - edges[1:])[:, None] * (2.0 * np.pi / columns)
    weight = cells * solid_angle
    probability = weight / weight.sum()
    table = np.zeros((rows, columns, 4), dtype=np.float32)
    threshold, alias = _alias(probability.reshape(-1))
    table[..., 0] = threshold.reshape(rows, columns)
    table[..., 1] = alias.reshape(rows, columns)
    table[..., 2] = probability / solid_angle
    return table


def _spans(texels: int, cells: int) -> list[slice]:
    """Return the texels that each of `cells` equal parts touches."""
    return [slice(i * texels // cells, -(-(i + 1) * texels // cells)) for i in range(cells)]


def _alias(probability: FloatArray) -> tuple[FloatArray, NDArray[np.int64]]:
    """Vose's construction of the alias method."""
    count = len(probability)
    scaled = probability * count
    threshold, alias = np.ones(count), np.arange(count)
    small = [int(i) for i in np.flatnonzero(scaled < 1.0)]
    large = [int(i) for i in np.flatnonzero(scaled >= 1.0)]
    left = scaled.tolist()
    while small and large:
        low, high = small.pop(), large[-1]
        threshold[low], alias[low] = left[low], high
        left[high] -= 1.0 - left[low]
        if left[high] < 1.0:
            small.append(large.pop())
    return threshold, alias
