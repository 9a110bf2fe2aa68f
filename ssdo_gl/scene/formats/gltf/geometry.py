"""Vertices and triangles of one glTF primitive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.formats.gltf.document import Document, GltfError, Json
from ssdo_gl.scene.formats.model import Vertices
from ssdo_gl.scene.geometry import are_mirrored

_TRIANGLES, _STRIP, _FAN = 4, 5, 6
Offsets = NDArray[np.float32] | None


@dataclass(frozen=True, eq=False)
class Shape:
    """One primitive in the space of its mesh.

    Attributes
    ----------
    positions, normals : ndarray, shape (V, 3)
    triangles : ndarray, shape (T, 3)
    uvs, second_uvs : ndarray, shape (V, 2)
    colors : ndarray, shape (V, 4)
        Linear, as the format defines them.
    joints, weights : ndarray, shape (V, 4 k)
    targets : tuple of three (ndarray or None)
        What each morph target adds to positions, normals and tangents, float32.
    tangents : ndarray, shape (V, 4)
    """

    positions: FloatArray
    triangles: NDArray[np.int64]
    normals: FloatArray | None
    uvs: FloatArray | None
    colors: FloatArray | None
    joints: NDArray[np.int64] | None
    weights: FloatArray | None
    targets: tuple[tuple[Offsets, Offsets, Offsets], ...] = ()
    second_uvs: FloatArray | None = None
    tangents: FloatArray | None = None

    def morphed(self, weights: Sequence[float]) -> Vertices:
        """Return the vertices under weights of the targets; missing ones are 0."""
        positions, normals, tangents = self.positions, self.normals, self.tangents
        for (moved, turned, along), weight in zip(self.targets, weights, strict=False):
            if weight != 0.0 and moved is not None:
                positions = positions + float(weight) * moved
            if weight != 0.0 and normals is not None and turned is not None:
                normals = normals + float(weight) * turned
            if weight != 0.0 and tangents is not None and along is not None:
                tangents = tangents + float(weight) * np.pad(along, ((0, 0), (0, 1)))
        return Vertices(positions, normals, tangents)

    def skinned(self, vertices: Vertices, matrices: FloatArray) -> Vertices:
        """Return the vertices in the world, the joints at `matrices` (J, 4, 4)."""
        assert self.joints is not None and self.weights is not None
        rows = np.ascontiguousarray(matrices[:, :3])
        positions, normals, tangents = vertices
        blended = np.zeros((len(positions), 3, 4))
        for joint, weight in zip(self.joints.T, self.weights.T, strict=True):
            if weight.any():
                blended += weight[:, None, None] * rows[joint]
        linear = blended[:, :, :3]
        moved = np.einsum("vab,vb->va", linear, positions) + blended[:, :, 3]
        if normals is not None:
            normals = np.einsum("vab,vb->va", linear, normals)
        if tangents is not None:
            along = np.einsum("vab,vb->va", linear, tangents[:, :3])
            # A mirror turns the top of the image to the other side of the tangent.
            sign = np.where(are_mirrored(blended), -tangents[:, 3], tangents[:, 3])
            tangents = np.column_stack([along, sign])
        return Vertices(moved, normals, tangents)


def read_shape(
    document: Document,
    primitive: Json,
    uv_sets: tuple[int, int | None],
    is_morphed: Sequence[bool],
    *,
    is_bumped: bool = False,
) -> Shape | None:
    """Return a primitive, or None if it is made of points or lines.

    Parameters
    ----------
    uv_sets : pair of int
        Which TEXCOORD_n the material's textures use; None where all use the first.
    is_morphed : sequence of bool
        Which morph targets matter; missing ones do not.
    is_bumped : bool
        Whether there is a normal map, for which tangents are needed.
    """
    mode = int(primitive.get("mode", _TRIANGLES))
    attributes = primitive["attributes"]
    if mode not in (_TRIANGLES, _STRIP, _FAN) or "POSITION" not in attributes:
        return None
    positions = document.accessor(attributes["POSITION"], (3,))
    count = len(positions)

    def optional(name: str, *widths: int) -> FloatArray | None:
        if name not in attributes:
            return None
        values = document.accessor(attributes[name], widths)
        if len(values) != count:
            raise GltfError(f"{name} has {len(values)} entries for {count} vertices")
        return values

    joints, weights = _influences(document, attributes, count)
    colors = optional("COLOR_0", 3, 4)
    if colors is not None and colors.shape[1] == 3:
        colors = np.concatenate([colors, np.ones((count, 1))], axis=1)
    return Shape(
        positions,
        _triangles(document, primitive, mode, count),
        optional("NORMAL", 3),
        optional(f"TEXCOORD_{uv_sets[0]}", 2),
        colors,
        joints,
        weights,
        _targets(document, primitive, is_morphed, count, is_bumped),
        None if uv_sets[1] is None else optional(f"TEXCOORD_{uv_sets[1]}", 2),
        optional("TANGENT", 4) if is_bumped else None,
    )


def read_points(document: Document, attributes: Json) -> tuple[FloatArray, FloatArray | None]:
    """Return positions (V, 3) and linear colours (V, 4), if there are any, of a primitive."""
    positions = document.accessor(attributes["POSITION"], (3,))
    if "COLOR_0" not in attributes:
        return positions, None
    colors = document.accessor(attributes["COLOR_0"], (3, 4))
    if len(colors) != len(positions):
        raise GltfError(f"COLOR_0 has {len(colors)} entries for {len(positions)} vertices")
    return positions, np.concatenate([colors, np.ones((len(colors), 1))], axis=1)[:, :4]


def _triangles(document: Document, primitive: Json, mode: int, count: int) -> NDArray[np.int64]:
    if "indices" in primitive:
        index = document.index_accessor(primitive["indices"])
    else:
        index = np.arange(count)
    if mode == _TRIANGLES:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    later = np.arange(max(len(index) - 2, 0))
    if mode == _FAN:
        return np.stack([index[np.zeros_like(later)], index[later + 1], index[later + 2]], axis=1)
    # Every second triangle of a strip runs the other way round.
    odd = later % 2
    return np.stack([index[later], index[later + 1 + odd], index[later + 2 - odd]], axis=1)


def _targets(
    document: Document, primitive: Json, is_morphed: Sequence[bool], count: int, is_bumped: bool
) -> tuple[tuple[Offsets, Offsets, Offsets], ...]:
    """Return what the morph targets add to positions, normals and tangents."""
    known: dict[int, NDArray[np.float32]] = {}

    def offsets(target: Json, name: str) -> Offsets:
        if name not in target:
            return None
        index = target[name]
        if index not in known:
            values = document.accessor(index, (3,)).astype(np.float32)
            if len(values) != count:
                raise GltfError(f"a morph target has {len(values)} entries for {count} vertices")
            document.count_morphs(values.size)
            known[index] = values
        return known[index]

    return tuple(
        (
            offsets(target, "POSITION"),
            offsets(target, "NORMAL"),
            offsets(target, "TANGENT") if is_bumped else None,
        )
        if matters
        else (None, None, None)
        for target, matters in zip(primitive.get("targets", []), is_morphed, strict=False)
    )


def _influences(
    document: Document, attributes: Json, count: int
) -> tuple[NDArray[np.int64] | None, FloatArray | None]:
    """Return joint numbers and weights (V, 4 k), the weights summing to one."""
    sets = 0
    while f"JOINTS_{sets}" in attributes and f"WEIGHTS_{sets}" in attributes:
        sets += 1
    if not sets:
        return None, None
    joints = np.concatenate(
        [document.raw_accessor(attributes[f"JOINTS_{i}"], (4,)) for i in range(sets)], axis=1
    ).astype(np.int64)
    weights = np.concatenate(
        [document.accessor(attributes[f"WEIGHTS_{i}"], (4,)) for i in range(sets)], axis=1
    )
    if len(joints) != count or len(weights) != count:
        raise GltfError(f"JOINTS or WEIGHTS do not match the {count} vertices")
    if joints.min(initial=0) < 0:
        raise GltfError("JOINTS must be unsigned integers")
    weights = np.where(np.isfinite(weights), weights, 0.0)
    total = weights.sum(axis=1, keepdims=True)
    weights = np.where(total > 0.0, weights / np.where(total > 0.0, total, 1.0), 0.0)
    weights[total[:, 0] <= 0.0, 0] = 1.0
    return joints, weights
