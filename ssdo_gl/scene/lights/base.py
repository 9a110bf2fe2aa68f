"""What the rest of the program asks of a light, whatever its kind. World space."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any, ClassVar, Literal, Self

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray, Vector, vector
from ssdo_gl.scene.files import Table
from ssdo_gl.scene.geometry import Mesh, SceneObject
from ssdo_gl.scene.material import Color, Material
from ssdo_gl.scene.motion import Trajectory
from ssdo_gl.scene.numbers import light_numbers, three_numbers
from ssdo_gl.settings.fields import SettingError, shown

# map: shadow map (or shadow rays); ssdo: arrives through SSDO's open directions
# and is part of `directional`, not of `direct`; none: casts no shadow.
Shadow = Literal["map", "ssdo", "none"]
# Numbers of the above in the tables that shaders read.
SHADOW_NUMBERS: Mapping[str, int] = {"none": 0, "map": 1, "ssdo": 2}

BLACK: Color = (0.0, 0.0, 0.0)
# Of the square of a length.
UNIT_TOLERANCE = 1e-6
# Corners (low, high) of the scene in the frame of a (3, 3) rotation.
BoundsOf = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
# Half the extents (N,) of bodies along a unit vector.


class Form(IntEnum):
    """What shape light comes from: it decides how shadows are looked up and rays aimed."""

    POINT = 0  # emits an intensity, W/sr
    PARALLEL = 1  # arrives from one direction, W/m^2
    AREA = 2  # emits a radiance, W/sr/m^2


@dataclass(frozen=True, eq=False)
class ShadowView:
    """From where and how wide the shadow map of a light sees; see `ShadowFrame`."""

    origin_ws: FloatArray
    half_size: tuple[float, float] = (1.0, 1.0)
    depth: float = 0.0
    parts: FloatArray = dataclasses.field(default_factory=lambda: np.zeros((1, 3)))


@dataclass(frozen=True, eq=False)
class ShaderRow:
    """What ``shaders/lights/lights.glsl`` knows of a light beyond kind, shadow and power.

    Attributes
    ----------
    place : ndarray, shape (3,)
        A point; of parallel light the unit vector towards it.
    axis, second_axis : ndarray, shape (3,)
        Vectors of the kind's own choice.
    numbers : (float, float)
        Of the kind's own choice.
    """

    place: FloatArray
    axis: FloatArray = dataclasses.field(default_factory=lambda: np.zeros(3))
    second_axis: FloatArray = dataclasses.field(default_factory=lambda: np.zeros(3))
    numbers: tuple[float, float] = (0.0, 0.0)
    two_sided: bool = False


@dataclass(frozen=True, eq=False)
class Emitter:
    """A light as an entry of the table that rays draw lights from, lengths normalised.

    `power` is what it emits in all, by which it is chosen; `place`, `axis`, `second_axis`,
    `emitted` and `number` are texels of the entry: see `EmitterTables`.
    """

    place: FloatArray
    axis: FloatArray
    second_axis: FloatArray
    number: float
    emitted: FloatArray
    power: float
    two_sided: bool = False


@dataclass(frozen=True, eq=False)
class Body:
    """What is seen of a light: a mesh, known by a key, its material and (4, 4) matrix."""

    key: str
    make: Callable[[], Mesh]
    material: Material
    world_from_object: FloatArray

    def placed(self, light: Light, number: int, mesh: int, material: int) -> SceneObject:
        """Return the object that shows light `number` of a scene."""
        places = self.world_from_object[None]
        return SceneObject(
            mesh, material, places, light.motion, light=number, name=self.material.name
        )


@dataclass(frozen=True, kw_only=True)
class Light(ABC):
    """A light of some kind; one file of this folder is all there is to know of a kind.

    Class attributes
    ----------------
    kind : str
        Its name in shaders and window; ``shaders/lights/<kind>.glsl`` holds its functions.
    kind_in_files : str or None
        Its name in scene files, if that is another.
    emitted_field, emitted_unit : str
        The field that says how bright it is, and its unit.
    point_fields, direction_fields, edge_fields : tuple of str
        Which fields are points, unit vectors, and vectors with a length.
    gltf_type : str or None
        Its name in glTF's KHR_lights_punctual.
    """

    kind: ClassVar[str]
    kind_in_files: ClassVar[str | None] = None
    form: ClassVar[Form]
    emitted_field: ClassVar[str]
    emitted_unit: ClassVar[str]
    point_fields: ClassVar[tuple[str, ...]] = ()
    direction_fields: ClassVar[tuple[str, ...]] = ()
    edge_fields: ClassVar[tuple[str, ...]] = ()
    gltf_type: ClassVar[str | None] = None

    shadow: Shadow = "map"
    name: str = ""
    motion: Trajectory | None = None

    def __post_init__(self) -> None:
        for name in (*self.point_fields, *self.edge_fields, *self.direction_fields):
            object.__setattr__(self, name, three_numbers(name, getattr(self, name)))
        name = self.emitted_field
        object.__setattr__(self, name, light_numbers(name, getattr(self, name)))
        for name in self.direction_fields:
            direction = getattr(self, name)
            if direction == BLACK:
                raise SettingError(f"{name} = {direction}: expected a direction")
            # What is of unit length but for rounding stays as it is.
            if not abs(math3d.dot(direction, direction) - 1.0) < UNIT_TOLERANCE:
                object.__setattr__(self, name, vector(math3d.normalized(direction)))
        if self.shadow not in SHADOW_NUMBERS:
            valid = ", ".join(SHADOW_NUMBERS)
            raise SettingError(f"shadow = {shown(self.shadow)}: expected one of {valid}")

    # How bright.

    @property
    def emitted(self) -> Color:
        """What the light emits, in the unit of its kind."""
        color: Color = getattr(self, self.emitted_field)
        return color

    @property
    def power(self) -> float:
        """The largest component of what the light emits; 0: it is off."""
        return max(self.emitted)

    def with_emitted(self, color: Color) -> Self:
        """Return the light with another brightness; `Scene.with_light` dims its body, too."""
        return self._replace({self.emitted_field: color})

    def without_shadow(self) -> Self:
        """Return the light unshadowed."""
        return dataclasses.replace(self, shadow="none")

    # Where.

    @property
    def turned_fields(self) -> tuple[str, ...]:
        """The fields that say which way it faces; none if that is all the same."""
        return (*self.direction_fields, *self.edge_fields)

    @property
    def place(self) -> Vector | None:
        """Where the light is; None for a direction."""
        return getattr(self, self.point_fields[0]) if self.point_fields else None

    def moved_to(self, place: Vector) -> Self:
        """Return the light at another place; one without a place stays as it is."""
        return self._replace(dict.fromkeys(self.point_fields, place))

    def turned_to(self, axes: Mapping[str, Vector]) -> Self:
        """Return the light with others of its `turned_fields`."""
        return self._replace(axes)

    def at(self, seconds: float) -> Self:
        """Return the light `seconds` after rest."""
        return self if self.motion is None else self.moved(self.motion.world_from_rest(seconds))

    def moved(self, matrix: FloatArray) -> Self:
        """Return the light moved by a rigid (4, 4) matrix."""
        points = {
            name: vector(math3d.transform_points(matrix, getattr(self, name)))
            for name in self.point_fields
        }
        turned = {
            name: vector(matrix[:3, :3] @ np.asarray(getattr(self, name)))
            for name in self.turned_fields
        }
        return self._replace({**points, **turned})

    def scaled(self, factor: float) -> Self:
        """Return the light in a scene `factor` times as large that looks the same."""
        lengths = {
            name: vector(np.multiply(getattr(self, name), factor))
            for name in (*self.point_fields, *self.edge_fields)
        }
        if self.form is Form.POINT:
            lengths[self.emitted_field] = vector(np.multiply(self.emitted, factor * factor))
        return self._replace(lengths)

    def _replace(self, fields: Mapping[str, Any]) -> Self:
        return dataclasses.replace(self, **fields)

    # In files.

    @classmethod
    def keys(cls) -> tuple[str, ...]:
        """Return the keys of a scene file's [[light]] table that the kind has of its own."""
        common = {field.name for field in dataclasses.fields(Light)}
        return tuple(f.name for f in dataclasses.fields(cls) if f.name not in common)

    @classmethod
    @abstractmethod
    def from_table(cls, table: Table, **common: Any) -> Self:
        """Return the light that a [[light]] table describes; `common` are fields of `Light`."""

    @classmethod
    def from_gltf(
        cls, light: Mapping[str, Any], place: Vector, direction: Vector, color: Color, name: str
    ) -> Self:
        """Return a light of KHR_lights_punctual, `color` its colour times its intensity."""
        raise TypeError(f"KHR_lights_punctual has no {cls.kind} lights")

    def body(self) -> Body | None:
        """Return what is seen of the light, if anything."""
        return None

    def can_share_body(self, other: Light) -> bool:
        """Return whether both may stand for parts of one glowing body."""
        # A shadow, too, may have been found useless for some of them.
        own = {*self.point_fields, *self.edge_fields, self.emitted_field, "shadow"}
        return (
            self.form is Form.AREA
            and type(self) is type(other)
            and all(
                getattr(self, field.name) == getattr(other, field.name)
                for field in dataclasses.fields(self)
                if field.name not in own
            )
        )

    # For shaders.

    @abstractmethod
    def axes(self) -> FloatArray:
        """Return the (3, 3) rotation light_from_world; +z is where the light shines."""

    @abstractmethod
    def shader_row(self) -> ShaderRow:
        """Return what shaders know of it."""

    @cached_property
    def light_from_world(self) -> FloatArray:
        """The `axes`, worked out once: every frame asks for them."""
        return self.axes()

    @cached_property
    def own_row(self) -> ShaderRow:
        """The `shader_row`, worked out once."""
        return self.shader_row()

    @abstractmethod
    def emitter(self, centre: FloatArray, unit: float) -> Emitter:
        """Return its entry for rays, lengths from `centre` in units of `unit`."""

    @property
    def is_soft(self) -> bool:
        """Whether its shadows have penumbrae."""
        return self.form is Form.AREA or self.spread > 0.0

    @property
    def spread(self) -> float:
        """How far parallel light strays from its direction: the tangent of the angle."""
        return 0.0

    # Shadow map.

    @property
    @abstractmethod
    def map_faces(self) -> int:
        """How many faces its shadow map needs, the first of `FACE_FROM_LIGHT`."""

    @property
    def face_count(self) -> int:
        """How many faces of the atlas it needs; 0 if it has no shadow map."""
        return self.map_faces if self.shadow == "map" else 0

    @property
    def tile_span(self) -> int:
        """How many tiles a face is wide and high.

        Only soft shadows hide their map's texels. The edges of others are as sharp as their
        map, and a map of one face may spend on that what others spend on six.
        """
        if self.form is Form.AREA:
            return 1
        return 4 if self.face_count == 1 else 2

    @abstractmethod
    def shadow_view(self, bounds_of: BoundsOf, parts_per_side: int) -> ShadowView:
        """Return from where its shadow map sees, which has `parts_per_side`^2 parts."""

    # What it can do to a scene.

    @abstractmethod
    def outline(self) -> FloatArray | None:
        """Return points (N, 3) whose convex hull all its light comes from; None if parallel."""

    @abstractmethod
    def sender_radiance(self, nearest: float) -> float:
        """Return the largest radiance of a white surface, no nearer than `nearest` to it."""

    @abstractmethod
    def irradiance_at(self, points: FloatArray, normals: FloatArray) -> FloatArray:
        """Return unshadowed irradiance (N,), mean over colours.

        Negative where it reaches the side that the normal looks away from.
        """
