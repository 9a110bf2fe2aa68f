"""Where all instances of a scene are and what shows of them, in float64 on the CPU."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ssdo_gl import math3d
from ssdo_gl.gpu.geometry.draw_group import by_chance, emitting, material_row
from ssdo_gl.gpu.instance_attributes import INSTANCE_FLOATS
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.geometry import are_mirrored
from ssdo_gl.scene.scene import Scene

# Geometry nearer than this fraction of the farthest visible bound is cut off: a
# clip plane must lie somewhere in front of the eye. A tenth of a millimetre within
# 100 km; logarithmic depth resolves 1.2e-6 of z over such a range (at 1e-6, which hid
# cards before the camera from landscapes, it was 8e-7).
NEAREST_CLIP_RATIO = 1e-9
# The clip distances keep this far (relative) from the bounds, far above float32 rounding
# (1e-7) and far below what depth precision would notice.
CLIP_MARGIN = 1e-3


class Viewpoint(Protocol):
    """An eye somewhere in the world; `graph.frame.FrameView` is one."""

    @property
    def position_ws(self) -> FloatArray:
        """World-space position, shape (3,)."""

    @property
    def view_from_world(self) -> FloatArray:
        """Rotation, shape (3, 3); a reflection is allowed."""


@dataclass(frozen=True)
class CameraPose:
    """The plainest `Viewpoint`: a light, or a face of its shadow map."""

    position_ws: FloatArray
    view_from_world: FloatArray


@dataclass(frozen=True, eq=False)
class Batch:
    """Consecutive instances of one draw group that are all mirrored, or none.

    `emits` is whether any of them does, `by_chance` whether any is translucent.
    """

    group: int
    is_mirrored: bool
    start: int
    emits: bool
    by_chance: bool


@dataclass(frozen=True, eq=False)
class Visible:
    """What shows of one batch.

    Attributes
    ----------
    attributes : ndarray, shape (n, INSTANCE_FLOATS)
    around, others : ndarray
        Of them those whose box the eye is within, and so maybe inside it, and all others.
        Parallel rays begin on the near plane: those that it cuts.
    """

    attributes: NDArray[np.float32]
    around: NDArray[np.float32]
    others: NDArray[np.float32]

    @cached_property
    def in_turn(self) -> NDArray[np.float32]:
        """Those around the eye, then all others."""
        if min(len(self.around), len(self.others)) == 0:
            return self.attributes
        return np.concatenate([self.around, self.others])


# What `Instances.boxes` returns.
Boxes = tuple[FloatArray, FloatArray, FloatArray]


@dataclass(frozen=True, eq=False)
class Instances:
    """All instances, sorted by batch.

    Attributes
    ----------
    world_from_mesh : ndarray, shape (N, 3, 4), float64
        The recentring of each mesh included, so the last column is the bounds' centre.
    half_extent : ndarray, shape (N, 3)
        Half the object-space bounds.
    materials : ndarray, shape (N, INSTANCE_FLOATS - 12), float32
    lights : ndarray, shape (N,)
        The light whose visible body it is, or -1.
    """

    world_from_mesh: FloatArray
    half_extent: FloatArray
    materials: NDArray[np.float32]
    lights: NDArray[np.int64]
    batches: tuple[Batch, ...]

    def boxes(self, viewpoint: Viewpoint) -> Boxes:
        """Return (N, 3, 4) view_from_mesh, and centres and half sizes of the view-space boxes."""
        relative = self.world_from_mesh.copy()
        relative[:, :, 3] -= viewpoint.position_ws
        view_from_mesh = np.asarray(viewpoint.view_from_world @ relative)
        half = np.einsum("nij,nj->ni", np.abs(view_from_mesh[:, :, :3]), self.half_extent)
        return view_from_mesh, view_from_mesh[:, :, 3], half

    def visible(
        self, boxes: Boxes, clip_from_view: FloatArray, skip_light: int | None
    ) -> list[Visible]:
        """Return what shows of each batch."""
        if len(self.lights) == 0:
            return []
        view_from_mesh, center, half = boxes
        rows = clip_from_view[:3]
        planes = np.concatenate([rows, -rows]) + clip_from_view[3]
        seen = self._shown(_inside(planes, center, half), skip_light)
        count, materials = int(np.count_nonzero(seen)), self.materials
        starts = [batch.start for batch in self.batches]
        ends = [*starts[1:], count]
        if count < len(seen):
            ends = np.cumsum(np.add.reduceat(seen, starts, dtype=np.int64)).tolist()
            view_from_mesh, center, half = (part[seen] for part in boxes)
            materials = materials[seen]
        packed = np.empty((count, INSTANCE_FLOATS), np.float32)
        packed[:, :12] = view_from_mesh.reshape(-1, 12)
        packed[:, 12:] = materials
        if clip_from_view[3, 2] == 0.0:
            is_around = ~_inside(planes[2:3], center, -half)
        else:
            is_around = np.asarray((np.abs(center) <= half * (1.0 + CLIP_MARGIN)).all(axis=1))
        begins = [0, *ends[:-1]]
        return [_shared_out(packed[i:j], is_around[i:j]) for i, j in zip(begins, ends, strict=True)]

    def bounds_along(self, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return corners (low, high) of all instances in a world frame with these axes."""
        if len(self.lights) == 0:
            return np.zeros(3), np.zeros(3)
        _, center, half = self.boxes(CameraPose(np.zeros(3), axes))
        return (center - half).min(axis=0), (center + half).max(axis=0)

    def near_far(
        self, boxes: Boxes, tan_half_fov: tuple[float, float], skip_light: int | None
    ) -> tuple[float, float]:
        """Return clip distances that enclose all that shows; (0.5, 1) if nothing does."""
        bounds = self.depth_bounds(boxes, tan_half_fov, (0.0, 0.0), skip_light)
        if bounds is None:
            return 0.5, 1.0
        far = bounds[1] * (1.0 + CLIP_MARGIN)
        return max(bounds[0] * (1.0 - CLIP_MARGIN), far * NEAREST_CLIP_RATIO), far

    def depth_bounds(
        self,
        boxes: Boxes,
        tan_half_fov: tuple[float, float],
        half_frame: tuple[float, float],
        skip_light: int | None,
    ) -> tuple[float, float] | None:
        """Return between which depths the boxes lie that show; None if nothing does.

        What begins behind the viewpoint has a negative depth there.
        """
        _, center, half = boxes
        farthest, nearest = half[:, 2] - center[:, 2], -center[:, 2] - half[:, 2]
        sides = _sides(*tan_half_fov, *half_frame)
        seen = self._shown(_inside(sides, center, half) & (farthest > 0.0), skip_light)
        count = np.count_nonzero(seen)
        if count == 0:
            return None
        if count < len(seen):
            farthest, nearest = farthest[seen], nearest[seen]
        return float(nearest.min()), float(farthest.max())

    def _shown(self, seen: NDArray[np.bool_], skip_light: int | None) -> NDArray[np.bool_]:
        return seen if skip_light is None else seen & (self.lights != skip_light)


def gather(
    scene: Scene, groups: Sequence[Sequence[int]], centers: Sequence[FloatArray]
) -> Instances:
    """Return the instances of `scene`.

    Parameters
    ----------
    groups : sequence of sequences of int
        Indices of the objects in each draw group.
    centers : sequence of ndarray, shape (3,)
        The object-space point that each group's vertices are relative to.
    """
    places, extents, materials, lights, owners = [], [], [], [], []
    for number, (members, center) in enumerate(zip(groups, centers, strict=True)):
        low, high = scene.meshes[scene.objects[members[0]].mesh].bounds()
        for i in members:
            item = scene.objects[i]
            count = len(item.world_from_object)
            place = item.world_from_object[:, :3, :].copy()
            place[:, :, 3] += place[:, :, :3] @ center
            row = material_row(scene.materials[item.material], item.light is None)
            places.append(place)
            extents.append(np.broadcast_to(0.5 * (high - low), (count, 3)))
            materials.append(np.broadcast_to(row, (count, len(row))))
            lights.append(np.full(count, -1 if item.light is None else item.light))
            owners.append(np.full(count, number))
    if not places:
        nothing = np.zeros((0, INSTANCE_FLOATS - 12), np.float32)
        return Instances(np.zeros((0, 3, 4)), np.zeros((0, 3)), nothing, np.zeros(0, np.int64), ())
    place, owner = np.concatenate(places), np.concatenate(owners)
    is_mirrored = are_mirrored(place)
    order = np.lexsort((is_mirrored, owner))
    keys, starts = np.unique(2 * owner[order] + is_mirrored[order], return_index=True)
    rows = np.concatenate(materials)[order].astype(np.float32)
    batches = [
        Batch(
            int(key) // 2,
            bool(key % 2),
            int(start),
            emitting(own),
            by_chance(own),
        )
        for key, start, own in zip(keys, starts, np.split(rows, starts[1:]), strict=True)
    ]
    return Instances(
        place[order],
        np.concatenate(extents)[order],
        rows,
        np.concatenate(lights)[order],
        tuple(batches),
    )


def _shared_out(attributes: NDArray[np.float32], is_around: NDArray[np.bool_]) -> Visible:
    count = np.count_nonzero(is_around)
    if count == 0:
        return Visible(attributes, attributes[:0], attributes)
    if count == len(attributes):
        return Visible(attributes, attributes, attributes[:0])
    return Visible(attributes, attributes[is_around], attributes[~is_around])


@lru_cache(maxsize=16)
def _sides(x: float, y: float, u: float, v: float) -> FloatArray:
    """Return the planes of a frame's sides, by tangents and half sizes; read-only."""
    sides = np.array([[1, 0, -x, u], [-1, 0, -x, u], [0, 1, -y, v], [0, -1, -y, v]])
    # A jittered frame sees up to a pixel more; a hundredth of the field of view covers that
    # for frames of 100 pixels and more, at no cost.
    sides[:, 2:] *= 1.01
    return math3d.read_only(sides)


def _inside(planes: FloatArray, center: FloatArray, half: FloatArray) -> NDArray[np.bool_]:
    """Return which boxes reach the positive side of every plane (P, 4)."""
    distance = center @ planes[:, :3].T + planes[:, 3]
    reach = half @ np.abs(planes[:, :3]).T
    return np.asarray((distance + reach >= 0.0).all(axis=1))
