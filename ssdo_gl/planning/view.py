"""What of a scene a camera can see, and what that rules out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ssdo_gl.math3d import FloatArray, IntArray, Region
from ssdo_gl.planning.bodies import ANY, FLAT, ROUNDING, SOLID_BOX, Bodies, BoolArray, unit
from ssdo_gl.scene.lights import Light

# Bodies outside the frame by less than this count as seen: jitter moves a sample by half
# a pixel, and rounding by far less.
FRAME_MARGIN_PX = 2.0
# More bodies in view than this are not compared pair by pair: with so many, some touch.
MOST_COMPARED = 48


class Eye(Protocol):
    """A camera, as far as visibility goes; `graph.frame.FrameView` is one."""

    @property
    def position_ws(self) -> FloatArray:
        """World-space position, shape (3,)."""

    @property
    def view_from_world(self) -> FloatArray:
        """Rotation, shape (3, 3); the eye looks along -z."""

    @property
    def tan_half_fov(self) -> tuple[float, float]:
        """Horizontal and vertical; 0 if rays are parallel."""

    @property
    def half_frame(self) -> tuple[float, float]:
        """Half of the width and height that parallel rays show, scene units; else 0."""

    @property
    def size(self) -> tuple[int, int]:
        """Pixels."""

    @property
    def near(self) -> float:
        """Everything visible is at least this far along the view axis, scene units."""

    @property
    def far(self) -> float:
        """And at most this far."""


@dataclass(frozen=True)
class ViewFacts:
    """Facts about one view of a scene. Everything is conservative: in doubt, it matters.

    Effects compare lengths by `Request.view_says` alone.

    Attributes
    ----------
    is_empty : bool
        No body is in view.
    open_distance : float
        Nothing in view stands above any visible tangent plane nearer than this, scene
        units; inf for a single box or sheet, 0 where nothing can be said.
    only_solids : bool
        All bodies in view are solid boxes.
    nearest_pixel, farthest_pixel : float
        Height of a pixel at the nearest and at the farthest depth in view, scene units.
    slant : float
        Distance from the eye over depth, in the corner of the frame, where it is largest.
    reaches : tuple of bool
        For each light, whether it can light anything in view.
    gloss_region : (int, int, int, int) or None
        Outside this part of the frame no surface reflects more than diffuse light: x, y,
        width and height in pixels, from the bottom left. None: nor does any inside.
    """

    is_empty: bool
    open_distance: float
    only_solids: bool
    nearest_pixel: float
    farthest_pixel: float
    slant: float
    reaches: tuple[bool, ...]
    gloss_region: Region | None

    @property
    def kinds(self) -> tuple[object, ...]:
        """All that is no length: it stays the same over many views."""
        return (
            self.is_empty,
            self.only_solids,
            self.reaches,
            self.gloss_region is None,
        )


def seen_bodies(bodies: Bodies, eye: Eye) -> IntArray:
    """Return the numbers of the bodies whose boxes reach into the frame."""
    return np.flatnonzero(_in_frame(bodies, eye))


@dataclass(frozen=True, eq=False)
class Neighbours:
    """What holds wherever the eye is, as long as the same bodies are in view.

    Attributes
    ----------
    seen : ndarray of int
        Their numbers.
    gap : float
        No body that is not flat in one plane with another is nearer to it than this;
        inf for a single one, 0 where nothing can be said.
    reaches, only_solids
        As in `ViewFacts`.
    glossy : ndarray of int
        Those of `seen` that may reflect more than diffuse light.
    """

    seen: IntArray
    gap: float
    reaches: tuple[bool, ...]
    only_solids: bool
    glossy: IntArray


def neighbours_of(bodies: Bodies, seen: IntArray, lights: Sequence[Light]) -> Neighbours:
    """Return what can be said of the bodies `seen` and of the lights."""
    return Neighbours(
        seen,
        smallest_gap(bodies, seen),
        reaches=tuple(can_reach(light, bodies, seen) for light in lights),
        only_solids=bool(np.all(bodies.form[seen] == SOLID_BOX)),
        glossy=seen[bodies.is_glossy[seen]],
    )


def view_facts(bodies: Bodies, neighbours: Neighbours, eye: Eye) -> ViewFacts:
    """Return what can be said of the view from `eye` of the bodies that are `neighbours.seen`."""
    pixel_near, pixel_far = (
        2.0 * (eye.half_frame[1] + eye.tan_half_fov[1] * z) / eye.size[1]
        for z in (eye.near, eye.far)
    )
    return ViewFacts(
        is_empty=len(neighbours.seen) == 0,
        open_distance=open_distance(bodies, neighbours, eye),
        only_solids=neighbours.only_solids,
        nearest_pixel=pixel_near,
        farthest_pixel=pixel_far,
        slant=math.hypot(1.0, *eye.tan_half_fov),
        reaches=neighbours.reaches,
        gloss_region=region_of(bodies, neighbours.glossy, eye),
    )


def region_of(bodies: Bodies, chosen: IntArray, eye: Eye) -> Region | None:
    """Return a part of the frame outside which none of the bodies `chosen` is seen.

    None, if there is none of them.
    """
    if len(chosen) == 0:
        return None
    signs = np.where(np.indices((2, 2, 2)).reshape(3, 8).T, 1.0, -1.0)
    corners = bodies.center[chosen, None] + signs @ bodies.half_edges[chosen]
    x, y, back = np.moveaxis((corners - eye.position_ws) @ eye.view_from_world.T, -1, 0)
    size = np.array(eye.size)
    if eye.half_frame[1] <= 0.0 and np.any(back >= 0.0):
        return 0, 0, *eye.size
    halves = (half - tan * back for half, tan in zip(eye.half_frame, eye.tan_half_fov, strict=True))
    across = [0.5 + 0.5 * a / half for a, half in zip((x, y), halves, strict=True)]
    low, high = (
        size * [limit(side) for side in across] + margin
        for limit, margin in ((np.min, -FRAME_MARGIN_PX), (np.max, FRAME_MARGIN_PX))
    )
    first = np.clip(np.floor(low), 0, size).astype(int)
    end = np.clip(np.ceil(high), first, size).astype(int)
    return int(first[0]), int(first[1]), int(end[0] - first[0]), int(end[1] - first[1])


def _in_frame(bodies: Bodies, eye: Eye) -> BoolArray:
    wider = [1.0 + 2.0 * FRAME_MARGIN_PX / n for n in eye.size]
    x, y = (half * factor for half, factor in zip(eye.tan_half_fov, wider, strict=True))
    u, v = (half * factor for half, factor in zip(eye.half_frame, wider, strict=True))
    # Inward normals of the frame's sides, and of the plane through the eye.
    sides = np.array([[1, 0, -x], [-1, 0, -x], [0, 1, -y], [0, -1, -y], [0, 0, -1]])
    planes = sides @ eye.view_from_world
    height = (bodies.center - eye.position_ws) @ planes.T + np.array([u, u, v, v, 0.0])
    return np.asarray((height + bodies.reach_along(planes) >= 0.0).all(axis=1))


def can_reach(light: Light, bodies: Bodies, seen: IntArray) -> bool:
    """Return whether `light` can light any side of the bodies `seen`, shadows aside."""
    if len(seen) == 0 or light.power <= 0.0:
        return False
    return light.can_reach(
        bodies.center[seen],
        bodies.radius[seen],
        lambda axis: bodies.reach_along(axis[None])[seen, 0],
    )


def open_distance(bodies: Bodies, neighbours: Neighbours, eye: Eye) -> float:
    """Return how near to a visible surface anything above its tangent plane can be.

    A solid box seen from outside has nothing of its own above any visible tangent
    plane, nor has a flat sheet. So only other bodies count, and they are no nearer than
    the gap between the boxes; flat sheets in one plane do not count for each other.
    """
    if neighbours.gap <= 0.0:
        return 0.0
    solids = neighbours.seen[bodies.form[neighbours.seen] == SOLID_BOX]
    if eye.half_frame[1] > 0.0:
        # Rays begin on the near plane, which may cut a body open.
        ahead = -eye.view_from_world[2]
        depth = (bodies.center - eye.position_ws) @ ahead - bodies.reach_along(ahead[None])[:, 0]
        inside = bool(np.any(depth[solids] <= eye.near))
    else:
        inside = any(bodies.holds(int(body), eye.position_ws) for body in solids)
    return 0.0 if inside else neighbours.gap


def smallest_gap(bodies: Bodies, seen: IntArray) -> float:
    """Return `Neighbours.gap` of the bodies `seen`."""
    if len(seen) > MOST_COMPARED or np.any(bodies.form[seen] == ANY):
        return 0.0
    first, second = np.triu_indices(len(seen), 1)
    i, j = seen[first], seen[second]
    gaps = box_gaps(bodies, i, j)
    for pair in range(len(gaps)):
        if _coplanar(bodies, int(i[pair]), int(j[pair])):
            gaps[pair] = np.inf
    return max(float(gaps.min(initial=np.inf)), 0.0)


def box_gaps(bodies: Bodies, i: IntArray, j: IntArray) -> FloatArray:
    """Return lower bounds (P,) of the distance between bodies i and j; < 0: boxes overlap.

    The widest gap along the axes of the world, of both boxes and between their centres.
    """
    across = bodies.center[j] - bodies.center[i]
    axes = candidate_axes(bodies, i, j, across[:, None])
    apart = np.abs(np.einsum("pkc,pc->pk", axes, across))
    for side in (i, j):
        apart -= reach_along_each(bodies, side, axes)
    return np.asarray(apart.max(axis=1))


def candidate_axes(bodies: Bodies, i: IntArray, j: IntArray, more: FloatArray) -> FloatArray:
    """Return unit axes (P, K, 3) along which the boxes i and j may be apart.

    Those of the world and of both boxes, and the vectors `more` (P, M, 3).
    """
    world = np.broadcast_to(np.eye(3), (len(i), 3, 3))
    return np.concatenate([world, bodies.face_axes[i], bodies.face_axes[j], unit(more)], axis=1)


def reach_along_each(bodies: Bodies, chosen: IntArray, axes: FloatArray) -> FloatArray:
    """Return half the extents (P, K) of boxes (P,) along axes of their own (P, K, 3)."""
    return np.asarray(
        np.abs(np.einsum("pec,pkc->pek", bodies.half_edges[chosen], axes)).sum(axis=1)
    )


def _coplanar(bodies: Bodies, i: int, j: int) -> bool:
    """Return whether two flat bodies lie in one plane."""
    if bodies.form[i] != FLAT or bodies.form[j] != FLAT:
        return False
    points = [bodies.outline_ws(body) for body in (i, j)]
    scale = max(float(np.abs(p).max()) for p in points)
    for body, other in ((i, points[1]), (j, points[0])):
        plane = bodies.flat_plane_ws(body)
        # Ten times, for the transform of both sheets and the plane itself.
        if np.abs(other @ plane[:3] + plane[3]).max() > 10.0 * ROUNDING * scale:
            return False
    return True
