"""Whether anything can stand between a light and what is in view."""

from __future__ import annotations

import numpy as np

from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.planning.bodies import FLAT, Bodies, BoolArray, unit
from ssdo_gl.scene.lights import Light

# Pairs of receiver and caster that are looked at; with more bodies, some cast shadows.
MOST_PAIRS = 2048
# A shadow map tells places apart by its texels. What passes a receiver at less than this
# many texels may still darken its rim in the map, so it counts as a caster.
MARGIN_TEXELS = 4.0
# The coarsest map that the margin allows for, texels along a face.
COARSEST_MAP = 256


def shadow_is_possible(light: Light, number: int, bodies: Bodies, seen: IntArray) -> bool:
    """Return whether any body can keep the light of `light` from the bodies `seen`.

    A sheet throws no shadow on itself. Another body throws none on it if a plane has the
    one on one side and, on the other, both the light and the sheet: then no ray of light
    crosses it. A convex solid has no shadow on a side that faces the light either, but
    where light grazes it a map's texels may, and the picture would change without them.

    Parameters
    ----------
    number : int
        Of the light; its own visible body throws no shadow of its light.
    seen : ndarray of int
        Bodies whose shading matters. All bodies throw shadows.
    """
    casters = np.flatnonzero(bodies.light != number)
    # Nor does a light light its own body, which lies in its plane.
    seen = seen[bodies.light[seen] != number]
    if np.any(bodies.form[seen] != FLAT) or len(seen) * len(casters) > MOST_PAIRS:
        return True
    i, j = (index.reshape(-1) for index in np.meshgrid(seen, casters, indexing="ij"))
    i, j = i[i != j], j[i != j]
    if len(i) == 0:
        return False
    return not bool(np.all(_kept_apart(light, bodies, i, j)))


def _kept_apart(light: Light, bodies: Bodies, i: IntArray, j: IntArray) -> BoolArray:
    """Return for each pair whether a plane parts caster j from receiver i and the light."""
    points, toward = light.outline(), -light.axes()[2]
    across = bodies.center[j] - bodies.center[i]
    if points is None:
        seen_from_light = across - np.outer(across @ toward, toward)
    else:
        from_light_i = bodies.center[i] - points.mean(axis=0)
        from_light_j = bodies.center[j] - points.mean(axis=0)
        seen_from_light = unit(from_light_j) - unit(from_light_i)
    axes = candidate_axes(bodies, i, j, np.stack([across, seen_from_light], axis=1))
    axes = np.concatenate([axes, -axes], axis=1)
    lowest_j = _middle_along(bodies, j, axes) - reach_along_each(bodies, j, axes)
    highest_i = _middle_along(bodies, i, axes) + reach_along_each(bodies, i, axes)
    if points is None:
        # Parallel light comes from infinitely far on the side that it shines from, and on
        # both sides of a plane where it strays to both.
        along = axes @ toward
        steepest = along + light.spread * np.sqrt(np.maximum(1.0 - along**2, 0.0))
        reaches_over = np.where(steepest > 1e-12, np.inf, -np.inf)
        across_all = float(np.linalg.norm(np.ptp(bodies.center, axis=0)))
        distances = np.full(len(i), across_all + 2.0 * float(bodies.radius.max()))
    else:
        reaches_over = (axes @ points.T).max(axis=2)
        distances = np.maximum(
            np.linalg.norm(from_light_i, axis=1) + bodies.radius[i],
            np.linalg.norm(from_light_j, axis=1) + bodies.radius[j],
        )
    # A face of the map is two tangents wide.
    margin = MARGIN_TEXELS * 2.0 / COARSEST_MAP * distances
    free = lowest_j - np.maximum(highest_i, reaches_over)
    return np.asarray((free > margin[:, None]).any(axis=1))


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


def _middle_along(bodies: Bodies, chosen: IntArray, axes: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("pkc,pc->pk", axes, bodies.center[chosen]))
