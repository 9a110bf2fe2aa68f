"""The camera of a scene: a pinhole, or parallel rays."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, Vector
from ssdo_gl.scene.numbers import check_number, checked_size, hold_numbers, three_numbers
from ssdo_gl.scene.scene_error import check_type
from ssdo_gl.settings.fields import SettingError, shown

# The second and third are the same.
PROJECTIONS = ("perspective", "orthographic", "ortho")
# As high, or low, as turning goes: beyond, left and right would change places.
MAX_ELEVATION_DEGREES = 89.0
# From the axes of a camera in a convention to ours: x right, y up, z back.
CONVENTIONS = {"opengl": (1.0, 1.0, 1.0), "opencv": (1.0, -1.0, -1.0)}


@runtime_checkable
class Framed(Protocol):
    """What tells from where all of it is seen: a `Scene`."""

    def framed(self, ahead: Vector | None, fov_y: float, exposure: float | None) -> Camera:
        """Return what `Camera.fit` does."""


@dataclass(frozen=True)
class Camera:
    """A camera in world space (right-handed, scene units).

    Attributes
    ----------
    position, target, up : tuple of 3 floats, or any three numbers
        World space. `target` is the point in the middle of the picture.
    fov_y : float
        Vertical field of view in degrees, (0, 180).
    exposure : float
        Exposure in EV applied before tone mapping; 0 leaves radiance as it is.
    height : float or None
        Of what the picture shows, scene units, if rays are parallel (an orthographic
        camera); nothing behind `position` is seen. None: a pinhole camera.

    Raises
    ------
    SettingError
        Naming the field that has no meaning.

    Examples
    --------
    >>> from ssdo_gl import Camera
    >>> camera = Camera.look_at((0, 0, 4), fov_y=30).orbit(90)
    >>> [round(x, 9) for x in camera.position]
    [4.0, 0.0, 0.0]
    """

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    fov_y: float = 40.0
    exposure: float = 0.0
    height: float | None = None

    def __post_init__(self) -> None:
        for name in ("position", "target", "up"):
            object.__setattr__(self, name, three_numbers(name, getattr(self, name)))
        if self.position == self.target:
            raise SettingError(f"target = {self.target}: expected another point than position")
        if self.up == (0.0, 0.0, 0.0):
            raise SettingError("up = (0, 0, 0): expected a direction")
        hold_numbers(self, "exposure", "fov_y", *(() if self.height is None else ("height",)))
        _check_fov(self.fov_y)
        if self.height is not None and not self.height > 0.0:
            raise SettingError(f"height = {shown(self.height)}: expected scene units above 0")

    @classmethod
    def look_at(
        cls, position: ArrayLike, target: ArrayLike = (0.0, 0.0, 0.0), **fields: Any
    ) -> Self:
        """Return the camera at `position` that has `target` in the middle of its picture.

        Parameters
        ----------
        position, target : array_like, shape (3,)
        **fields
            ``up``, ``fov_y``, ``exposure``, ``height``.
        """
        return cls(three_numbers("position", position), three_numbers("target", target), **fields)

    @classmethod
    def fit(
        cls,
        scene: Framed,
        *,
        direction: ArrayLike | None = None,
        fov_y: float = 40.0,
        exposure: float | None = None,
    ) -> Camera:
        """Return the nearest camera that has all of a scene's main part in its picture.

        Strays far away and a far larger ground are no part of it. In a closed room it stands.

        Parameters
        ----------
        direction : array_like, shape (3,), or None
            In which it looks, world space; None: from a side that shows much.
        fov_y : float
            Degrees.
        exposure : float or None
            In EV; None: that of the scene's camera.

        Raises
        ------
        SceneError, SettingError
            Naming what has no meaning.
        """
        check_type("scene", scene, Framed, "Scene")
        _check_fov(fov_y)
        ahead = None if direction is None else three_numbers("direction", direction)
        if ahead == (0.0, 0.0, 0.0):
            raise SettingError("direction = (0, 0, 0): expected a direction")
        return scene.framed(ahead, fov_y, exposure)

    @classmethod
    def from_pose(
        cls, world_from_camera: ArrayLike, convention: str = "opencv", **fields: Any
    ) -> Self:
        """Return the camera that stands as a matrix says.

        Parameters
        ----------
        world_from_camera : array_like, shape (3, 4) or (4, 4)
            Rotation and position; its inverse is the extrinsic matrix.
        convention : str
            As of `pose`, whose result makes the same camera again.
        **fields
            ``fov_y``, ``exposure``, ``height``.
        """
        try:
            matrix = np.asarray(world_from_camera, dtype=np.float64)
        except (TypeError, ValueError):
            matrix = np.zeros(0)
        rotation = matrix[:3, :3] if matrix.shape in ((3, 4), (4, 4)) else np.zeros((3, 3))
        is_rigid = np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-5)
        if not is_rigid or np.linalg.det(rotation) < 0.0:
            raise SettingError("world_from_camera: expected a rotation and a position, (4, 4)")
        axes = rotation * _axes_of(convention)
        position = math3d.vector(matrix[:3, 3])
        target = math3d.vector(matrix[:3, 3] - axes[:, 2])
        return cls(position, target, math3d.vector(axes[:, 1]), **fields)

    def orbit(self, degrees: float, up_degrees: float = 0.0) -> Camera:
        """Return the camera turned about its target, at the same distance.

        Parameters
        ----------
        degrees : float
            About `up`: to the right, as one turns about what one looks at.
        up_degrees : float
            Then higher above the target; not beyond 89 degrees above or below it.
        """
        check_number("degrees", degrees)
        check_number("up_degrees", up_degrees)
        if degrees == up_degrees == 0.0:
            return self
        axis = math3d.normalized(self.up)
        arm = np.subtract(self.position, self.target)
        if degrees != 0.0:
            arm = _rotated(arm, axis, math.radians(degrees))
        if up_degrees != 0.0:
            side = self.view_from_world_rotation()[0]
            side = _rotated(side, axis, math.radians(degrees))
            before = math.degrees(math.asin(np.clip(axis @ arm / np.linalg.norm(arm), -1.0, 1.0)))
            limit = max(MAX_ELEVATION_DEGREES, abs(before))
            after = min(max(before + up_degrees, -limit), limit)
            arm = _rotated(arm, side, math.radians(before - after))
        return dataclasses.replace(self, position=math3d.vector(np.add(self.target, arm)))

    @property
    def distance(self) -> float:
        """From the camera to its target, scene units."""
        return math.dist(self.position, self.target)

    @property
    def height_at_target(self) -> float:
        """Height of what the picture shows at the distance of the target, scene units."""
        if self.height is not None:
            return self.height
        return 2.0 * self.distance * math.tan(math.radians(self.fov_y) / 2.0)

    def orthographic(self, height: float | None = None) -> Camera:
        """Return the camera with parallel rays; what is at its target keeps its size.

        Parameters
        ----------
        height : float or None
            What the picture shows instead, scene units.
        """
        shown_height = self.height_at_target if height is None else height
        return dataclasses.replace(self, height=shown_height)

    def perspective(self) -> Camera:
        """Return the pinhole camera that shows what is at the target as large.

        It keeps its field of view and comes nearer or draws back.
        """
        if self.height is None:
            return self
        ahead = np.subtract(self.target, self.position) / self.distance
        distance = self.height / (2.0 * math.tan(math.radians(self.fov_y) / 2.0))
        position = math3d.vector(np.asarray(self.target) - ahead * distance)
        return dataclasses.replace(self, position=position, height=None)

    def view_from_world_rotation(self) -> FloatArray:
        """Return the (3, 3) rotation from world to view space (looks along -z)."""
        return math3d.look_rotation(self.position, self.target, self.up)

    def pose(self, convention: str = "opencv") -> FloatArray:
        """Return the (4, 4) matrix from the camera's space to the world.

        Parameters
        ----------
        convention : str
            Of the camera's axes: ``opencv`` (y down, looks along +z) or ``opengl`` (y up,
            looks along -z).
        """
        matrix = np.eye(4)
        matrix[:3, :3] = self.view_from_world_rotation().T * _axes_of(convention)
        matrix[:3, 3] = self.position
        return matrix

    def extrinsics(self, convention: str = "opencv") -> FloatArray:
        """Return the (4, 4) matrix from the world to the camera's space; see `pose`."""
        return np.asarray(np.linalg.inv(self.pose(convention)))

    def intrinsics(self, size: tuple[int, int]) -> FloatArray:
        """Return the (3, 3) matrix from OpenCV's camera space to pixels.

        Pixel (column, row) has its centre at whole numbers, row 0 at the top: the third
        column gains 0.5 where centres lie at halves (COLMAP, NeRF). A pinhole divides by
        depth, u = (fx x + cx z) / z; parallel rays do not, u = fx x + cx.

        Parameters
        ----------
        size : (int, int)
            Width and height in pixels.
        """
        width, height = checked_size(size)
        focal = height / (self.height or 2.0 * math.tan(math.radians(self.fov_y) / 2.0))
        return np.array(
            [[focal, 0.0, (width - 1) / 2.0], [0.0, focal, (height - 1) / 2.0], [0.0, 0.0, 1.0]]
        )

    def projection(self, size: tuple[int, int], near: float, far: float) -> FloatArray:
        """Return OpenGL's (4, 4) matrix from its camera space to clip space.

        Parameters
        ----------
        near, far : float
            Depths along the view axis that become -1 and 1, scene units.

        Raises
        ------
        SettingError
            Unless `far` is beyond `near` and, of a pinhole, `near` before it.
        """
        check_number("near", near)
        check_number("far", far)
        width, height = checked_size(size)
        is_before = self.height is not None or near > 0.0
        if not (is_before and near < far):
            first = "near < far" if self.height is not None else "0 < near < far"
            raise SettingError(f"near = {shown(near)}, far = {shown(far)}: expected {first}")
        aspect = width / height
        if self.height is not None:
            return math3d.orthographic(self.half_frame(aspect), near, far)
        return math3d.perspective(self.tan_half_fov(aspect), near, far)

    def tan_half_fov(self, aspect: float) -> tuple[float, float]:
        """Return tangents of half the (horizontal, vertical) field of view; 0 if parallel.

        Parameters
        ----------
        aspect : float
            Width over height of the picture.
        """
        if self.height is not None:
            return 0.0, 0.0
        vertical = float(np.tan(np.radians(self.fov_y) / 2.0))
        return vertical * aspect, vertical

    def half_frame(self, aspect: float) -> tuple[float, float]:
        """Return half of the (width, height) that parallel rays show; 0 for a pinhole."""
        vertical = 0.5 * (self.height or 0.0)
        return vertical * aspect, vertical


def _check_fov(degrees: object) -> None:
    check_number("fov_y", degrees)
    if not 0.0 < degrees < 180.0:  # type: ignore[operator]  # it is a number
        raise SettingError(f"fov_y = {shown(degrees)}: expected degrees between 0 and 180")


def _axes_of(convention: str) -> tuple[float, float, float]:
    if convention not in CONVENTIONS:
        valid = ", ".join(CONVENTIONS)
        raise SettingError(f"convention = {shown(convention)}: expected one of {valid}")
    return CONVENTIONS[convention]


def _rotated(arm: FloatArray, axis: FloatArray, angle: float) -> FloatArray:
    """Return a vector turned about a unit axis by radians: Rodrigues' formula."""
    return np.asarray(
        arm * math.cos(angle)
        + np.cross(axis, arm) * math.sin(angle)
        + axis * (axis @ arm) * (1.0 - math.cos(angle))
    )
