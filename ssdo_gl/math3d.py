"""Transforms and projections in float64; the only module that imports pyrr.

pyrr follows the row-vector convention (``p @ V @ P``). Everything this module
returns is in the column-vector convention (``P @ V @ p``), named
``dst_from_src``, so that the rest of the project knows one convention only.
"""

from __future__ import annotations

import math

import numpy as np
import pyrr
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Vector = tuple[float, float, float]
# x, y, width and height in pixels, from the bottom left.
Region = tuple[int, int, int, int]
# Sine of the angle between two edges below which their float64 cross product is rounding
# noise rather than an area.
FLAT_SINE = 1e-12


def read_only(array: FloatArray) -> FloatArray:
    """Return a copy of `array`, row by row, that cannot be written to."""
    copy = np.array(array, order="C")
    copy.flags.writeable = False
    return copy


def vector(values: ArrayLike) -> Vector:
    """Return three numbers as a tuple of floats."""
    numbers = values if isinstance(values, tuple) else np.asarray(values, dtype=np.float64)
    x, y, z = numbers
    return float(x), float(y), float(z)


def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def add(a: Vector, b: Vector, factor: float = 1.0) -> Vector:
    """Return a + factor * b."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


def difference(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def normalized(vector: ArrayLike) -> FloatArray:
    """Return `vector` scaled to unit length along its last axis.

    Parameters
    ----------
    vector : array_like, shape (..., n)

    Raises
    ------
    ValueError
        If a vector has zero or non-finite length, whose direction is undefined.
    """
    array = np.asarray(vector, dtype=np.float64)
    # Dividing by the largest component first keeps the squares of components
    # below 1e-154 or above 1e154 inside the range of float64.
    largest = np.max(np.abs(array), axis=-1, keepdims=True)
    if not np.all(np.isfinite(largest)) or np.any(largest == 0.0):
        raise ValueError("a direction must be finite and not zero")
    scaled = array / largest
    return np.asarray(scaled / np.linalg.norm(scaled, axis=-1, keepdims=True))


def translation(offset: ArrayLike) -> FloatArray:
    """Return the (4, 4) matrix that moves points by `offset` (scene units)."""
    matrix: FloatArray = pyrr.matrix44.create_from_translation(
        np.asarray(offset, dtype=np.float64), dtype=np.float64
    ).T
    return matrix


def scaling(factors: ArrayLike) -> FloatArray:
    """Return the (4, 4) matrix that scales by `factors`, a number or three."""
    three = np.broadcast_to(np.asarray(factors, dtype=np.float64), (3,))
    matrix: FloatArray = pyrr.matrix44.create_from_scale(three, dtype=np.float64).T
    return matrix


def rotation_euler(degrees_xyz: ArrayLike) -> FloatArray:
    """Return the (4, 4) rotation about x, then y, then z (degrees, right-handed)."""
    x, y, z = np.radians(np.asarray(degrees_xyz, dtype=np.float64))
    cx, sx, cy, sy, cz, sz = np.cos(x), np.sin(x), np.cos(y), np.sin(y), np.cos(z), np.sin(z)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    matrix = np.eye(4)
    matrix[:3, :3] = about_z @ about_y @ about_x
    return matrix


def transform_matrix(
    translate: ArrayLike = (0.0, 0.0, 0.0),
    rotate: ArrayLike = (0.0, 0.0, 0.0),
    scale: ArrayLike = 1.0,
) -> FloatArray:
    """Return the (4, 4) matrix that scales, then rotates, then moves points.

    Parameters
    ----------
    translate : array_like, shape (3,)
        Scene units.
    rotate : array_like, shape (3,)
        Degrees about x, then y, then z, right-handed.
    scale : float or array_like, shape (3,)

    Raises
    ------
    ValueError
        If one of them is not as many finite numbers.
    """
    _check_numbers("translate", translate, "three finite numbers", (3,))
    _check_numbers("rotate", rotate, "three finite numbers", (3,))
    _check_numbers("scale", scale, "a finite number, or three", (), (3,))
    return np.asarray(translation(translate) @ rotation_euler(rotate) @ scaling(scale))


def _check_numbers(name: str, values: ArrayLike, wanted: str, *shapes: tuple[int, ...]) -> None:
    try:
        numbers = np.asarray(values, dtype=np.float64)
        is_fit = numbers.shape in shapes and bool(np.isfinite(numbers).all())
    except (TypeError, ValueError):
        is_fit = False
    if not is_fit:
        raise ValueError(f"{name} = {values!r}: expected {wanted}")


def frame_from_z(direction: ArrayLike) -> FloatArray:
    """Return a (3, 3) rotation whose third column is `direction`.

    The other two columns complete it to a right-handed orthonormal frame. The
    helper axis is the one least aligned with `direction`, so no direction is
    degenerate.
    """
    z = normalized(direction)
    helper = np.zeros(3)
    helper[int(np.argmin(np.abs(z)))] = 1.0
    x = normalized(np.cross(helper, z))
    return np.stack([x, np.cross(z, x), z], axis=1)


def look_rotation(position: ArrayLike, target: ArrayLike, up: ArrayLike) -> FloatArray:
    """Return the (3, 3) rotation view_from_world of a camera that looks along -z.

    Parameters
    ----------
    position, target, up : array_like, shape (3,)
        World space. Where `up` is parallel to the line of sight, the nearest
        usable axis replaces it, so that looking straight down is allowed.

    Raises
    ------
    ValueError
        If `position` and `target` coincide.
    """
    backward = _unit(difference(vector(position), vector(target)))
    right = _cross(_unit(vector(up)), backward)
    # Below 1e-6 rad the cross product is rounding noise rather than a direction.
    is_parallel = dot(right, right) < 1e-12
    right = vector(frame_from_z(backward)[:, 0]) if is_parallel else _unit(right)
    return np.array([right, _cross(backward, right), backward])


def _unit(direction: Vector) -> Vector:
    """Return what `normalized` does, of one vector and without NumPy: in a tenth of the time."""
    largest = max(map(abs, direction))
    if not 0.0 < largest < math.inf or any(map(math.isnan, direction)):
        raise ValueError("a direction must be finite and not zero")
    x, y, z = direction
    x, y, z = x / largest, y / largest, z / largest
    length = math.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def is_reflection(rotation: FloatArray) -> bool:
    """Return whether the axes (3, 3) of a rotation are left-handed."""
    x, y, z = map(tuple, rotation.tolist())
    return dot(_cross(x, y), z) < 0.0


def perspective(tan_half_fov: tuple[float, float], near: float, far: float) -> FloatArray:
    """Return the (4, 4) OpenGL projection clip_from_view (z in -w..w).

    Parameters
    ----------
    tan_half_fov : (float, float)
        Tangents of half the horizontal and half the vertical field of view.
    near, far : float
        Distances along the view axis, scene units, 0 < near < far.
    """
    depth = far - near
    x, y = tan_half_fov[0] * near, tan_half_fov[1] * near
    from_clip = [
        [2.0 * near / (x + x), 0.0, 0.0, 0.0],
        [0.0, 2.0 * near / (y + y), 0.0, 0.0],
        [0.0, 0.0, -(far + near) / depth, -1.0],
        [0.0, 0.0, -2.0 * far * near / depth, 0.0],
    ]
    return np.array(from_clip).T


def orthographic(half_frame: tuple[float, float], near: float, far: float) -> FloatArray:
    """Return the (4, 4) projection clip_from_view of parallel rays (z in -1..1, w = 1).

    Parameters
    ----------
    half_frame : (float, float)
        Half the width and half the height of what the frame shows.
    near, far : float
        Distances along the view axis, scene units, near < far.
    """
    depth = far - near
    matrix = np.diag([1.0 / half_frame[0], 1.0 / half_frame[1], -2.0 / depth, 1.0])
    matrix[2, 3] = -(far + near) / depth
    return matrix


def transform_points(matrix: FloatArray, points: ArrayLike) -> FloatArray:
    """Return `points` (..., 3) moved by the affine `matrix` (4, 4)."""
    array = np.asarray(points, dtype=np.float64)
    return np.asarray(array @ matrix[:3, :3].T + matrix[:3, 3])


def lengths_of_rows(vectors: FloatArray) -> FloatArray:
    """Return the lengths of vectors (N, 3), shape (N,): three times as fast as NumPy's norm."""
    x, y, z = vectors.T
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def doubled_area_vectors(corners: FloatArray) -> FloatArray:
    """Return front normals (N, 3) of triangles (N, 3, 3), as long as twice their areas."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def spread_directions(count: int, lowest: float = -1.0) -> FloatArray:
    """Return unit vectors (count, 3) spread evenly over the sphere above y = `lowest`."""
    up = lowest + (np.arange(count) + 0.5) * ((1.0 - lowest) / count)
    turn = np.pi * (1.0 + 5.0**0.5) * np.arange(count)
    flat = np.sqrt(1.0 - up**2)
    return np.stack([flat * np.cos(turn), up, flat * np.sin(turn)], axis=1)


def largest_of_rows(vectors: FloatArray) -> FloatArray:
    """Return the largest magnitude in each of the rows of (N, 3), shape (N,)."""
    x, y, z = np.abs(vectors.T)
    return np.asarray(np.maximum(np.maximum(x, y), z))
