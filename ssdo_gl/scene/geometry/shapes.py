"""Triangle meshes of the primitive shapes, each in a canonical unit form.

One unit mesh serves every object of a kind: its size and place live in the
object's matrix, so that a hundred boxes are one mesh with a hundred instances.
All solids are wound counter-clockwise seen from outside and are closed; curved
faces carry smooth normals, and every shape has texture coordinates.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.geometry.mesh import Mesh

# A silhouette of 64 segments deviates from its circle by 1 - cos(pi / 64) = 0.12 %
# of the radius: under a pixel for a sphere 1500 pixels wide.
SEGMENTS = 64


def box() -> Mesh:
    """Return the cube [-1/2, 1/2]^3, shaded flat."""
    # One face in the plane x = +1/2 seen from outside, turned onto the six sides.
    face = np.array([[0.5, -0.5, 0.5], [0.5, -0.5, -0.5], [0.5, 0.5, -0.5], [0.5, 0.5, 0.5]])
    sides = []
    for axis in range(3):
        turned = np.roll(face, axis, axis=1)
        # Mirroring through the centre reverses nothing: three sign changes flip the
        # orientation, so the opposite face is taken in reverse order.
        sides += [turned, -turned[::-1]]
    triangles = np.concatenate([np.array([[0, 1, 2], [0, 2, 3]]) + 4 * i for i in range(6)])
    uvs = np.tile([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]], (6, 1))
    return Mesh(np.concatenate(sides), triangles, uvs=uvs, closed=True, name="box")


def quad() -> Mesh:
    """Return the square [0, 1]^2 in the plane z = 0 whose front looks along +z."""
    positions = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    uvs = np.stack([positions[:, 0], 1.0 - positions[:, 1]], axis=1)
    return Mesh(positions, np.array([[0, 1, 2], [0, 2, 3]]), uvs=uvs, name="quad")


def parallelogram_matrix(corner: ArrayLike, edge_u: ArrayLike, edge_v: ArrayLike) -> FloatArray:
    """Return the (4, 4) matrix that puts `quad` onto a parallelogram."""
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 3] = edge_u, edge_v, corner
    # Any third column on the front side will do for a flat shape; one as long as
    # the edges keeps the matrix well conditioned at every scale.
    normal = math3d.normalized(np.cross(math3d.normalized(edge_u), math3d.normalized(edge_v)))
    matrix[:3, 2] = normal * np.sqrt(np.linalg.norm(edge_u) * np.linalg.norm(edge_v))
    return matrix


def sphere(
    segments: int = SEGMENTS, bump_amplitude: float = 0.0, bump_frequency: float = 8.0
) -> Mesh:
    """Return the unit sphere, optionally with a bumpy surface.

    Parameters
    ----------
    segments : int
        Around the equator, >= 3; half as many (at least 2) from pole to pole.
    bump_amplitude : float
        The distance from the centre along unit direction d is
        1 + amplitude (sin f d.x + sin f d.y + sin f d.z) / 3; [0, 1).
    bump_frequency : float
        f above, radians per radius.
    """
    rings = max(segments // 2, 2)
    azimuth = np.arange(segments + 1) * (2.0 * np.pi / segments)
    polar = np.arange(rings + 1) * (np.pi / rings)
    sin_polar = np.sin(polar)
    sin_polar[-1] = 0.0  # sin(pi) rounds to 1e-16, which would open the pole
    cos_azimuth, sin_azimuth = _closed_circle(azimuth)
    direction = np.stack(
        [
            sin_polar[:, None] * sin_azimuth,
            np.broadcast_to(np.cos(polar)[:, None], (rings + 1, segments + 1)),
            sin_polar[:, None] * cos_azimuth,
        ],
        axis=-1,
    ).reshape(-1, 3)
    triangles = _grid_triangles(rings, segments)
    # The first ring's upper triangle and the last ring's lower one have no area.
    keep = np.ones((rings, segments, 2), dtype=bool)
    keep[0, :, 1] = False
    keep[-1, :, 0] = False
    uvs = _grid_uvs(rings, segments)
    if bump_amplitude == 0.0:
        positions, normals = direction, direction.copy()
    else:
        positions, normals = _bumpy(direction, bump_amplitude, bump_frequency)
    return Mesh(positions, triangles[keep.reshape(-1)], normals, uvs, closed=True, name="sphere")


def _bumpy(
    direction: FloatArray, amplitude: float, frequency: float
) -> tuple[FloatArray, FloatArray]:
    """Displace the unit sphere radially; return positions and exact normals."""
    radius = 1.0 + amplitude * np.sin(frequency * direction).mean(axis=1, keepdims=True)
    gradient = amplitude * frequency / 3.0 * np.cos(frequency * direction)
    tangential = gradient - (gradient * direction).sum(axis=1, keepdims=True) * direction
    # The surface r(d) d has the normal r d - grad r, grad r taken along the sphere.
    normal = radius * direction - tangential
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return radius * direction, normal


def cylinder(segments: int = SEGMENTS) -> Mesh:
    """Return the capped cylinder of radius 1 about +z from z = 0 to z = 1."""
    cos_azimuth, sin_azimuth = _closed_circle(np.arange(segments + 1) * (2 * np.pi / segments))
    circle = np.stack([cos_azimuth, sin_azimuth], axis=1)
    # Rows of the side's grid go from the top down so that u, v and winding agree
    # with those of the sphere: front faces outward.
    side = np.concatenate([_at_height(circle, 1.0), _at_height(circle, 0.0)])
    side_normals = np.concatenate([_at_height(circle, 0.0)] * 2)
    triangles = _grid_triangles(1, segments)
    uvs = _grid_uvs(1, segments)
    parts = [(side, triangles, side_normals, uvs)]
    parts += [_cap(circle[:-1], 1.0), _cap(circle[:-1], 0.0)]
    return _joined(parts, "cylinder")


def cone(segments: int = SEGMENTS) -> Mesh:
    """Return the cone with base radius 1 at z = 0 and its apex at z = 1."""
    azimuth = np.arange(segments + 1) * (2.0 * np.pi / segments)
    cos_azimuth, sin_azimuth = _closed_circle(azimuth)
    circle = np.stack([cos_azimuth, sin_azimuth], axis=1)
    # The apex has no normal of its own: each sector takes that of its middle.
    middle = azimuth[:-1] + np.pi / segments
    apex_normals = np.stack([np.cos(middle), np.sin(middle), np.ones(segments)], axis=1)
    base_normals = _at_height(circle, 1.0)
    normals = np.concatenate([apex_normals, base_normals]) / np.sqrt(2.0)
    positions = np.concatenate([np.tile([[0.0, 0.0, 1.0]], (segments, 1)), _at_height(circle, 0.0)])
    sector = np.arange(segments)
    triangles = np.stack([sector, segments + sector, segments + sector + 1], axis=1)
    u = np.concatenate([(sector + 0.5), np.arange(segments + 1)]) / segments
    v = np.concatenate([np.zeros(segments), np.ones(segments + 1)])
    side = (positions, triangles, normals, np.stack([u, v], axis=1))
    return _joined([side, _cap(circle[:-1], 0.0)], "cone")


def torus(
    tube_radius: float, arc: float = 360.0, segments: int = SEGMENTS, tube_segments: int = 0
) -> Mesh:
    """Return a ring of radius 1 about +z, whole or an arc of it with closed ends.

    Parameters
    ----------
    tube_radius : float
        Radius of the tube relative to the ring's, (0, 1).
    arc : float
        Degrees swept counter-clockwise from +x, (0, 360].
    segments : int
        Along the arc, >= 3.
    tube_segments : int
        Around the tube, >= 3; 0 stands for half of `segments` (at least 8).
    """
    around = tube_segments or max(segments // 2, 8)
    whole = arc >= 360.0
    sweep = np.radians(min(arc, 360.0)) * np.arange(segments + 1) / segments
    cos_sweep, sin_sweep = _closed_circle(sweep) if whole else (np.cos(sweep), np.sin(sweep))
    cos_tube, sin_tube = _closed_circle(np.arange(around + 1) * (-2.0 * np.pi / around))
    # Rows run around the tube (clockwise, so that the front faces outward), columns
    # along the ring.
    normals = np.stack(
        [
            cos_tube[:, None] * cos_sweep,
            cos_tube[:, None] * sin_sweep,
            np.broadcast_to(sin_tube[:, None], (around + 1, segments + 1)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    ring = np.stack([cos_sweep, sin_sweep, np.zeros(segments + 1)], axis=-1)
    positions = np.tile(ring, (around + 1, 1)) + tube_radius * normals
    parts = [(positions, _grid_triangles(around, segments), normals, _grid_uvs(around, segments))]
    if not whole:
        grid = positions.reshape(around + 1, segments + 1, 3)[:-1]
        parts.append(_end_cap(grid[::-1, 0], np.array([0.0, -1.0, 0.0])))
        end = np.array([-sin_sweep[-1], cos_sweep[-1], 0.0])
        parts.append(_end_cap(grid[:, -1], end))
    return _joined(parts, "torus")


_Patch = tuple[FloatArray, NDArray[np.int64], FloatArray, FloatArray]


def _closed_circle(angle: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return cosines and sines whose last entry is bit-equal to the first.

    The seam's two columns of vertices then share positions exactly, so that the
    surface is closed without a tolerance.
    """
    array = np.asarray(angle, dtype=np.float64)
    cosine, sine = np.cos(array), np.sin(array)
    cosine[-1], sine[-1] = cosine[0], sine[0]
    return cosine, sine


def _grid_triangles(rows: int, columns: int) -> NDArray[np.int64]:
    """Return the triangles of a (rows + 1) x (columns + 1) grid of vertices.

    The front is the side from which columns run to the right and rows downward.
    For each cell in row-major order: the lower-left, then the upper-right triangle.
    """
    row, column = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    upper_left = (row * (columns + 1) + column).reshape(-1)
    upper_right, lower_left = upper_left + 1, upper_left + columns + 1
    lower_right = lower_left + 1
    lower = np.stack([upper_left, lower_left, lower_right], axis=1)
    upper = np.stack([upper_left, lower_right, upper_right], axis=1)
    return np.stack([lower, upper], axis=1).reshape(-1, 3)


def _grid_uvs(rows: int, columns: int) -> FloatArray:
    v, u = np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, columns + 1), indexing="ij")
    return np.stack([u, v], axis=-1).reshape(-1, 2)


def _at_height(circle: FloatArray, z: float) -> FloatArray:
    return np.concatenate([circle, np.full((len(circle), 1), z)], axis=1)


def _fan(count: int) -> NDArray[np.int64]:
    """Return a triangle fan over a convex polygon of `count` vertices."""
    later = np.arange(1, count - 1)
    return np.stack([np.zeros_like(later), later, later + 1], axis=1)


def _cap(circle: FloatArray, z: float) -> _Patch:
    """Return a disk at height z that faces up at z = 1 and down at z = 0."""
    rim = circle if z > 0.0 else circle[::-1]
    normal = np.array([0.0, 0.0, 1.0 if z > 0.0 else -1.0])
    return _at_height(rim, z), _fan(len(rim)), np.tile(normal, (len(rim), 1)), rim * 0.5 + 0.5


def _end_cap(rim: FloatArray, normal: FloatArray) -> _Patch:
    count = len(rim)
    angle = np.arange(count) * (2.0 * np.pi / count)
    uvs = np.stack([np.cos(angle), np.sin(angle)], axis=1) * 0.5 + 0.5
    return rim, _fan(count), np.tile(normal, (count, 1)), uvs


def _joined(parts: list[_Patch], name: str) -> Mesh:
    offsets = np.cumsum([0] + [len(part[0]) for part in parts[:-1]])
    return Mesh(
        positions=np.concatenate([part[0] for part in parts]),
        triangles=np.concatenate(
            [part[1] + offset for part, offset in zip(parts, offsets, strict=True)]
        ),
        normals=np.concatenate([part[2] for part in parts]),
        uvs=np.concatenate([part[3] for part in parts]),
        closed=True,
        name=name,
    )
