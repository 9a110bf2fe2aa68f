"""Everything that is drawn, as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment import Environment
from ssdo_gl.scene.file_camera import FileCamera
from ssdo_gl.scene.geometry import MainPart, Mesh, SceneObject, Surfaces, main_part
from ssdo_gl.scene.lights import Light
from ssdo_gl.scene.material import Color, Material
from ssdo_gl.scene.motion import Trajectory
from ssdo_gl.scene.scene_error import SceneError, check_type
from ssdo_gl.settings.loading import USUAL, LoadOptions
from ssdo_gl.wording import counted, described, with_article


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene at rest. World space is right-handed; lengths are scene units.

    Attributes
    ----------
    render : mapping
        The settings that the scene asks for (``radius``, ``method``, ...); flags win over them.
    notes : tuple of str
        What the loader has to tell the user: added lights, dropped features.
    camera_motion : Trajectory or None
        Of the scene's own camera.
    cameras : tuple of FileCamera
        All that the file has, each with ``name`` and ``camera``.
    loading : LoadOptions
        How it was loaded.
    reach : float
        The near-field radius R that is used when neither scene nor flag gives one, relative to
        the diagonal of the bounds.
    backdrop : Color or None
        Radiance that is seen where no surface is, in place of the environment, which lights.
    metering_slack : float or None
        EV by which exposure 0 may miss what the picture asks for, if exposure is to be
        measured from it; None: the camera's holds.
    is_metered : bool
        Whether the camera's exposure is that measurement.
    is_framed : bool
        Whether the file has no camera, so that `camera` was chosen to hold all of it.
    added_light_count : int
        How many of the last lights were added because those of the file would not do.
    has_added_sky : bool
        Whether the environment was.

    Scenes do not change: `add` and all of ``with_...`` return another one, which shares with
    this one what they have in common. A `Renderer` that goes on with it keeps what it made
    of that.
    """

    meshes: tuple[Mesh, ...]
    materials: tuple[Material, ...]
    objects: tuple[SceneObject, ...]
    camera: Camera
    lights: tuple[Light, ...] = ()
    environment: Environment | None = None
    render: Mapping[str, Any] = field(default_factory=dict)
    title: str = ""
    purpose: str = ""
    notes: tuple[str, ...] = ()
    camera_motion: Trajectory | None = None
    cameras: tuple[FileCamera, ...] = ()
    loading: LoadOptions = USUAL
    reach: float = 0.08
    backdrop: Color | None = None
    metering_slack: float | None = None
    is_metered: bool = False
    is_framed: bool = False
    added_light_count: int = 0
    has_added_sky: bool = False

    def __post_init__(self) -> None:
        for name in ("meshes", "materials", "objects", "lights"):
            parts = getattr(self, name)
            if not isinstance(parts, (tuple, list)):
                got = with_article(type(parts).__name__)
                raise SceneError(f"{name}: expected a tuple, got {got}")

    @classmethod
    def from_arrays(
        cls,
        positions: ArrayLike,
        triangles: ArrayLike,
        *,
        normals: ArrayLike | Literal["smooth"] | None = None,
        uvs: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        material: Material | None = None,
        transform: ArrayLike | None = None,
        name: str = "",
        camera: Camera | None = None,
        lights: Iterable[Light] = (),
        environment: Environment | None = None,
        render: Mapping[str, Any] | None = None,
    ) -> Scene:
        """Return a scene of one mesh.

        Parameters
        ----------
        positions, triangles, normals, uvs, colors
            Of `Mesh.from_arrays`.
        material : Material or None
            None: light grey; white under `colors`.
        transform : array_like, shape (4, 4) or (N, 4, 4), or None
            From object to world space; more than one make as many instances.
        camera : Camera or None
            None: all of the scene is in the picture, and exposure is measured.
        lights, environment
            None of either: a soft sky and a key light.
        render : mapping or None
            Fields of `Settings` that the scene asks for.

        Raises
        ------
        SceneError, SettingError
            Naming the argument, and what it should be.
        """
        from ssdo_gl.scene import composition

        mesh = Mesh.from_arrays(
            positions, triangles, normals=normals, uvs=uvs, colors=colors, name=name
        )
        if material is None and colors is not None:
            material = Material(albedo=(1.0, 1.0, 1.0))
        parts = composition.parts_of(mesh, material, transform, name)
        return composition.composed(parts, camera, lights, environment, render, name)

    @classmethod
    def from_trimesh(
        cls,
        source: Any,
        *,
        material: Material | None = None,
        transform: ArrayLike | None = None,
        name: str = "",
        camera: Camera | None = None,
        lights: Iterable[Light] = (),
        environment: Environment | None = None,
        render: Mapping[str, Any] | None = None,
    ) -> Scene:
        """Return a scene of a ``trimesh.Trimesh`` or of a ``trimesh.Scene``.

        Parameters
        ----------
        material : Material or None
            In place of its own: colours of vertices or faces, plain or metallic-roughness
            materials with their textures.

        The others are those of `from_arrays`.
        """
        from ssdo_gl.scene import composition

        parts = composition.parts_of(source, material, transform, name)
        return composition.composed(parts, camera, lights, environment, render, name)

    def add(
        self,
        *items: Any,
        material: Material | None = None,
        transform: ArrayLike | None = None,
        name: str = "",
    ) -> Scene:
        """Return the scene with more in it.

        A camera that was chosen to frame the scene frames the new one. Light that was added
        because there was none yields to lights that are added here.

        Parameters
        ----------
        *items : Mesh, Light, Scene, or an object of trimesh
            Of a scene, its surfaces.
        material : Material or None
            Of the surfaces; None: their own, of a mesh light grey.
        transform : array_like, shape (4, 4) or (N, 4, 4), or None
            From their space to the world; `ssdo_gl.transform_matrix` makes one.
        name : str
            By which ``with_...`` finds them.

        Raises
        ------
        SceneError
        """
        from ssdo_gl.scene import composition

        lights = [item for item in items if isinstance(item, Light)]
        parts = [
            part
            for item in items
            if not isinstance(item, Light)
            for part in composition.parts_of(item, material, transform, name)
        ]
        return composition.extended(self, parts, lights)

    def with_camera(self, camera: Camera) -> Scene:
        """Return the scene seen from elsewhere."""
        check_type("camera", camera, Camera)
        return replace(self, camera=camera, camera_motion=None, is_framed=False)

    def with_transform(self, which: int | str, transform: ArrayLike) -> Scene:
        """Return the scene with an object elsewhere.

        Parameters
        ----------
        which : int or str
            Index into `objects`, or the name of one.
        transform : array_like, shape (4, 4) or (N, 4, 4)
            World from object, of each instance.
        """
        from ssdo_gl.scene.composition import with_object

        return with_object(self, which, transform, None)

    def with_material(self, which: int | str, material: Material) -> Scene:
        """Return the scene with an object, by index or name, of another material."""
        from ssdo_gl.scene.composition import with_object

        return with_object(self, which, None, material)

    def with_light(self, which: int | str, light: Light) -> Scene:
        """Return the scene with another light of the same kind for one, by index or name."""
        from ssdo_gl.scene import composition

        return composition.with_light(self, which, light)

    def __repr__(self) -> str:
        try:
            triangles = counted(self.triangle_count, "triangle")
        except (AttributeError, IndexError):  # what is refused when it is drawn can be shown
            triangles = ""
        return described(
            self,
            repr(self.title) if self.title else "",
            counted(len(self.objects), "object"),
            triangles,
            counted(len(self.lights), "light"),
            "" if self.environment is None else type(self.environment).__name__,
        )

    @property
    def has_ground(self) -> bool:
        """Whether a ground was laid under it."""
        return any(item.is_ground for item in self.objects)

    def two_sided(self) -> Scene:
        """Return the scene with both sides of all surfaces drawn."""
        materials = tuple(replace(material, single_sided=False) for material in self.materials)
        return replace(self, materials=materials)

    def surfaces(self, *, has_ground: bool = True) -> Surfaces:
        """Return all surfaces of it, or all but a ground."""
        objects = [item for item in self.objects if has_ground or not item.is_ground]
        return Surfaces(self.meshes, objects, self.materials)

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return world-space corners (min, max) of all instances but a ground, each (3,)."""
        corners = self.surfaces(has_ground=False).boxes().reshape(-1, 3)
        if not len(corners):
            raise SceneError("the scene has no geometry: give it at least one [[object]]")
        return corners.min(axis=0), corners.max(axis=0)

    def main_part(self) -> MainPart:
        """Return the part of it that lengths nobody gave go by: no strays, no far larger ground."""
        return main_part(self.surfaces(has_ground=False))

    def default_radius(self, *, is_all_light: bool = False) -> float:
        """Return the near-field radius R used when neither scene nor flag gives one.

        With `is_all_light` rays answer for what lies beyond R, and no more than the usual
        is left to the depth buffer: relMSE .0026 for .0054 in the Cornell box, mean error
        0.0 % for -9.2 %.

        Of scene files 0.08 of the diagonal of the main part: 0.28 in a room of edge 2, near the
        0.3 of the room that the method's first report was measured on. RGS09 section 3
        leaves r_max to the user and suggests the distance between local height maxima.
        """
        part = self.main_part()
        reach = min(self.reach, Scene.reach) if is_all_light else self.reach
        return float(reach * np.linalg.norm(part.high - part.low))

    @property
    def moves(self) -> bool:
        """Whether anything in it ever changes."""
        carriers: list[SceneObject | Light] = [*self.objects, *self.lights]
        return (
            self.camera_motion is not None
            or any(item.motion is not None for item in carriers)
            or any(self.meshes[item.mesh].pose is not None for item in self.objects)
        )

    @property
    def triangle_count(self) -> int:
        """Number of triangles drawn, instances included, a ground not."""
        return sum(
            len(self.meshes[item.mesh].triangles) * len(item.world_from_object)
            for item in self.objects
            if not item.is_ground
        )
