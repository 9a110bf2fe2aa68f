"""Triangle meshes and the objects that place them in the world."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.geometry.smoothing import smooth_normals
from ssdo_gl.scene.geometry.topology import (
    check_vertices,
    face_normals,
    is_closed,
    spans,
    unit_normals,
    unit_tangents,
    usable_uvs,
    without_area,
)
from ssdo_gl.scene.motion import Trajectory
from ssdo_gl.scene.numbers import array_of, check_index, is_float64, linear_colors
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.fields import SettingError, shown
from ssdo_gl.settings.loading import LoadOptions
from ssdo_gl.wording import counted, described

# Of one object; their matrices alone fill 128 MiB.
MAX_INSTANCES = 1 << 20
# How many numbers a vertex has in each array of a mesh.
VERTEX_WIDTHS = {
    "positions": 3,
    "normals": 3,
    "uvs": 2,
    "second_uvs": 2,
    "tangents": 4,
    "colors": 4,
}


@dataclass(frozen=True, eq=False)
class Mesh:
    """An indexed triangle mesh in its own object space, finite and non-empty.

    Attributes
    ----------
    positions : ndarray, shape (V, 3), float64
    triangles : ndarray, shape (T, 3), int64
        Counter-clockwise seen from the front. No triangle has zero area.
    normals : ndarray, shape (V, 3), float64, or None
        Unit shading normals; None: shaded flat, with the face normals.
    uvs : ndarray, shape (V, 2), float64, or None
        Texture coordinates, v = 0 at the top row of the image.
    second_uvs : ndarray, shape (V, 2), float64, or None
        Those of the images in `Material.second_uvs`; only beside `uvs`.
    tangents : ndarray, shape (V, 4), float64, or None
        Unit directions in which the first coordinate of the normal map grows, and the
        handedness: 1 where the top of the image lies along cross(normal, tangent), -1
        where it lies opposite, 0 where there is none. Only beside `normals`; where there is
        none, coordinates and positions give it.
    colors : ndarray, shape (V, 4), float64, or None
        Scene-linear vertex colour and alpha, [0, 1].
    closed : bool
        Whether the surface is watertight, so that back faces bound a solid.
    pose : callable or None
        The mesh at a time in seconds, None while nothing of it shows; without it the mesh
        keeps its shape.
    """

    positions: FloatArray
    triangles: NDArray[np.int64]
    normals: FloatArray | None = None
    uvs: FloatArray | None = None
    colors: FloatArray | None = None
    closed: bool = False
    name: str = ""
    second_uvs: FloatArray | None = None
    tangents: FloatArray | None = None
    pose: Callable[[float], Mesh | None] | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        for name in VERTEX_WIDTHS:
            value = getattr(self, name)
            if not is_float64(value) and (value is not None or name == "positions"):
                object.__setattr__(self, name, array_of(name, value, np.float64))
        object.__setattr__(self, "triangles", array_of("triangles", self.triangles, np.int64))

    @classmethod
    def from_arrays(
        cls,
        positions: ArrayLike,
        triangles: ArrayLike,
        *,
        normals: ArrayLike | Literal["smooth"] | None = None,
        uvs: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        name: str = "",
    ) -> Mesh:
        """Return a mesh made of arrays, checked, without triangles that have no area.

        Parameters
        ----------
        positions : array_like, shape (V, 3)
            Object space, finite.
        triangles : array_like, shape (T, 3)
            Indices of vertices, counter-clockwise seen from the front.
        normals : array_like, shape (V, 3), "smooth" or None
            Shading normals of any length. "smooth": made, with edges where triangles lean by
            more than 45 degrees. None: shaded flat.
        uvs : array_like, shape (V, 2), or None
            Texture coordinates, v = 0 at the top row of the image.
        colors : array_like, shape (V, 3) or (V, 4), or None
            Floats are scene-linear, [0, 1]; uint8 are sRGB-encoded, alpha linear.

        Raises
        ------
        SceneError
            Naming the argument, and what it should be.
        """
        made = isinstance(normals, str)
        if made and normals != "smooth":
            raise SceneError(f"normals = {shown(normals)}: expected an array, 'smooth' or None")
        raw = cls(
            positions,  # type: ignore[arg-type]  # becomes an array
            triangles,  # type: ignore[arg-type]
            None if made else normals,  # type: ignore[arg-type]
            uvs,  # type: ignore[arg-type]
            None if colors is None else linear_colors(colors),
            name=name,
        )
        if raw.fault:
            raise SceneError(raw.fault)
        mesh = cleaned_mesh(raw).mesh
        if mesh is None:
            raise SceneError("triangles: none has an area")
        return smoothed(mesh, LoadOptions.crease_angle) if made else mesh

    def __repr__(self) -> str:
        name = repr(self.name) if self.name else ""
        vertices = f"{len(self.positions)} vertices"
        return described(self, name, vertices, counted(len(self.triangles), "triangle"))

    def changed(self, change: Callable[[Mesh], Mesh]) -> Mesh:
        """Return what `change` makes of the mesh, at all times."""
        pose = self.pose
        if pose is None:
            return change(self)

        def changed_pose(seconds: float) -> Mesh | None:
            found = pose(seconds)
            return None if found is None else change(found)

        return replace(change(self), pose=changed_pose)

    def center(self) -> FloatArray:
        """Return the middle of the object-space bounds, shape (3,)."""
        return np.asarray(np.mean(self.bounds(), axis=0))

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the object-space corners (min, max), each of shape (3,), read-only."""
        return self._bounds

    @functools.cached_property
    def _bounds(self) -> tuple[FloatArray, FloatArray]:
        # Kept, because 300 000 triangles take 10 ms, and every frame in which anything
        # moves asks all meshes.
        is_used = np.zeros(len(self.positions), dtype=bool)
        is_used[self.triangles] = True
        points = self.positions if is_used.all() else self.positions[is_used]
        low, high = points.min(axis=0), points.max(axis=0)
        low.flags.writeable = high.flags.writeable = False
        return low, high

    @property
    def has_tangents(self) -> bool:
        """Whether its tangents, and the normals that they need, are known."""
        return self.normals is not None and self.tangents is not None

    @cached_property
    def fault(self) -> str:
        """What is wrong with the arrays, in one line; empty if nothing is."""
        count = len(self.positions)
        for name, width in VERTEX_WIDTHS.items():
            array: NDArray[Any] | None = getattr(self, name)
            if array is None:
                continue
            if array.ndim != 2 or array.shape[1] != width or len(array) != count:
                rows = "V" if name == "positions" else count
                return f"{name}: expected shape ({rows}, {width}), got {array.shape}"
            if not np.isfinite(array).all():
                row = int(np.argmin(np.isfinite(array).all(axis=1)))
                return f"{name}[{row}] = {array[row].tolist()}: expected finite numbers"
        triangles = self.triangles
        if triangles.ndim != 2 or triangles.shape[1] != 3 or not len(triangles):
            return f"triangles: expected shape (T, 3), T from 1 on, got {triangles.shape}"
        wrong = (triangles < 0) | (triangles >= count)
        if wrong.any():
            row = int(np.argmax(wrong.any(axis=1)))
            return f"triangles[{row}] = {triangles[row].tolist()}: there are {count} positions"
        return ""

    @cached_property
    def is_solid(self) -> bool:
        """Whether the mesh is closed and its front faces look outwards."""
        if not self.closed:
            return False
        volume = 0.0
        for span in spans(len(self.triangles)):
            a, b, c = np.moveaxis(self.corners(span) - self.positions[0], 1, 0)
            volume += float(np.einsum("ij,ij->", a, np.cross(b, c)))
        return volume > 0.0

    def corners(self, span: slice = slice(None)) -> FloatArray:
        """Return the positions of the corners of triangles, shape (T, 3, 3)."""
        return np.take(self.positions, self.triangles[span], axis=0)

    def face_normals(self, span: slice = slice(None)) -> FloatArray:
        """Return unit geometric normals of triangles, shape (T, 3), object space."""
        return face_normals(self.positions, self.triangles[span])


@dataclass(frozen=True)
class Cleaned:
    """A usable mesh and what had to go.

    Attributes
    ----------
    mesh : Mesh or None
        None if no triangle was left.
    not_finite, zero_area, bad_normals : int
        Dropped triangles with NaN or infinite corners, dropped triangles without
        area, and vertices whose shading normal was replaced.
    """

    mesh: Mesh | None
    not_finite: int = 0
    zero_area: int = 0
    bad_normals: int = 0


def cleaned_mesh(raw: Mesh, closed: bool | None = None) -> Cleaned:
    """Return a mesh without unusable triangles and unused vertices.

    Parameters
    ----------
    raw : Mesh
        Nothing but the shapes of its arrays is relied on. Tangents that are no direction become 0.
    closed : bool or None
        Whether they bound a solid; None: that is found out.

    Raises
    ------
    ValueError
        If a triangle names a vertex that does not exist.
    """
    positions, triangles, colors = raw.positions, raw.triangles, raw.colors
    check_vertices(triangles, len(positions))
    finite = np.asarray(np.isfinite(positions).all(axis=1))
    given = len(triangles)
    if not finite.all():
        triangles = triangles[finite[triangles].all(axis=1)]
    not_finite = given - len(triangles)
    flat = without_area(positions, triangles)
    zero_area = int(np.count_nonzero(flat))
    if zero_area:
        triangles = triangles[~flat]
    if not len(triangles):
        return Cleaned(None, not_finite, zero_area)
    is_used = np.zeros(len(positions), dtype=bool)
    is_used[triangles] = True
    used = np.flatnonzero(is_used)
    triangles = (np.cumsum(is_used) - 1)[triangles]
    points = np.ascontiguousarray(positions[used], dtype=np.float64)
    mesh = Mesh(
        positions=points,
        triangles=triangles,
        uvs=usable_uvs(raw.uvs, used),
        second_uvs=usable_uvs(raw.second_uvs, used),
        colors=None if colors is None else np.clip(np.nan_to_num(colors[used]), 0.0, 1.0),
        closed=is_closed(points, triangles) if closed is None else closed,
        name=raw.name,
    )
    if raw.normals is None:
        return Cleaned(mesh, not_finite, zero_area)
    unit, replaced = unit_normals(raw.normals[used], points, triangles)
    tangents = None if raw.tangents is None else unit_tangents(raw.tangents[used])
    mesh = replace(mesh, normals=unit, tangents=tangents)
    return Cleaned(mesh, not_finite, zero_area, replaced)


def smoothed(mesh: Mesh, crease_degrees: float) -> Mesh:
    """Return the mesh with normals that are smooth except across creases: `smooth_normals`.

    What is flat all over stays a mesh without normals.
    """
    others = {
        name: values
        for name in VERTEX_WIDTHS
        if name not in ("positions", "normals") and (values := getattr(mesh, name)) is not None
    }
    found = smooth_normals(mesh.positions, mesh.triangles, crease_degrees, joins=not others)
    if found is None:
        return replace(mesh, normals=None)
    rows, triangles, normals = found
    kept = {name: values[rows] for name, values in others.items()}
    positions = mesh.positions[rows]
    return replace(mesh, positions=positions, triangles=triangles, normals=normals, **kept)


@dataclass(frozen=True, eq=False)
class SceneObject:
    """One mesh with one material, placed once or many times.

    Attributes
    ----------
    mesh, material : int
        Indices into Scene.meshes and Scene.materials.
    world_from_object : ndarray, shape (N, 4, 4), float64
        One affine matrix for each instance, at rest (time 0).
    light : int or None
        Index into Scene.lights if this object is the visible body of a light:
        its emission is delivered by that light and must not be counted again.
    is_ground : bool
        Whether it was laid under the scene, whose size does not count it.

    Raises
    ------
    SettingError
        Naming the field that has no meaning. Whether a scene has what indices name is known
        when it is drawn.
    """

    mesh: int
    material: int
    world_from_object: FloatArray = field(default_factory=lambda: np.eye(4)[None])
    motion: Trajectory | None = None
    light: int | None = None
    name: str = ""
    is_ground: bool = False

    def __post_init__(self) -> None:
        check_index("mesh", self.mesh)
        check_index("material", self.material)
        if self.light is not None:
            check_index("light", self.light)
        if not (self.motion is None or hasattr(self.motion, "world_from_rest")):
            raise SettingError(f"motion = {shown(self.motion)}: expected a Trajectory or None")
        matrices = self.world_from_object
        if not is_float64(matrices) or matrices.ndim != 3:
            matrices = array_of("world_from_object", matrices, np.float64)
            matrices = matrices[None] if matrices.ndim == 2 else matrices
            object.__setattr__(self, "world_from_object", matrices)

    @cached_property
    def fault(self) -> str:
        """What is wrong with its matrices, in one line; empty if nothing is."""
        shape = self.world_from_object.shape
        if len(shape) != 3 or shape[1:] != (4, 4):
            return f"world_from_object: expected shape (N, 4, 4), got {shape}"
        if not np.isfinite(self.world_from_object).all():
            return "world_from_object: expected finite numbers"
        return ""

    def __repr__(self) -> str:
        name = repr(self.name) if self.name else ""
        count = counted(len(self.world_from_object), "instance")
        return described(self, name, f"mesh={self.mesh}", f"material={self.material}", count)
