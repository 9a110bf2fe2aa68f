"""Everything that is drawn: made of arrays and parts, changed, framed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, Literal, get_args

from numpy.typing import ArrayLike

from ssdo_gl.math3d import Vector, normalized
from ssdo_gl.scene import composition
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.defaults import frame, seen_from
from ssdo_gl.scene.environment import Environment
from ssdo_gl.scene.geometry import Mesh, SceneObject
from ssdo_gl.scene.lights import Light
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene_data import SceneData
from ssdo_gl.scene.scene_error import SceneError, check_type

_KINDS = {"meshes": Mesh, "materials": Material, "objects": SceneObject, "lights": Light}


class Scene(SceneData):
    """A scene at rest. World space is right-handed; lengths are scene units.

    Attributes
    ----------
    render : mapping
        The settings that the scene asks for (``radius``, ``method``, ...); flags win over them.
    notes : tuple of str
        What the loader has to tell the user: dropped features, added lights.
    read_note_count : int
        How many of the first notes are about what was read; they stay when more is added.
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
        mesh = Mesh.from_arrays(
            positions, triangles, normals=normals, uvs=uvs, colors=colors, name=name
        )
        if material is None and colors is not None:
            material = Material(albedo=(1.0, 1.0, 1.0))
        parts = composition.parts_of(mesh, material, transform, name)
        return composition.composed(cls, parts, camera, lights, environment, render, name)

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
        parts = composition.parts_of(source, material, transform, name)
        notes = composition.notes_of(source)
        return composition.composed(cls, parts, camera, lights, environment, render, name, notes)

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
        lights = [item for item in items if isinstance(item, Light)]
        parts = [
            part
            for item in items
            if not isinstance(item, Light)
            for part in composition.parts_of(item, material, transform, name)
        ]
        notes = [note for item in (self, *items) for note in composition.notes_of(item)]
        return composition.extended(self, parts, lights, notes)

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
        return composition.with_object(self, which, transform, None)

    def with_material(self, which: int | str, material: Material) -> Scene:
        """Return the scene with an object, by index or name, of another material."""
        return composition.with_object(self, which, None, material)

    def with_light(self, which: int | str, light: Light) -> Scene:
        """Return the scene with another light of the same kind for one, by index or name."""
        return composition.with_light(self, which, light)

    def framed(self, ahead: Vector | None, fov_y: float, exposure: float | None) -> Camera:
        """Return what `Camera.fit` does."""
        check_scene(self)
        level = self.camera.exposure if exposure is None else exposure
        if ahead is None:
            return frame(self.surfaces(), fov_y, level)
        return seen_from(self.surfaces(), -normalized(ahead), fov_y, level)


def check_scene(scene: Scene) -> None:
    """Raise SceneError naming the first part of a scene that cannot be drawn, and the cure."""
    check_type("scene", scene, Scene)
    if not scene.objects:
        raise SceneError("objects: expected at least one")
    for name, kind in _KINDS.items():
        for index, item in enumerate(getattr(scene, name)):
            check_type(f"{name}[{index}]", item, kind)
    check_type("camera", scene.camera, Camera)
    if scene.environment is not None:
        check_type("environment", scene.environment, get_args(Environment), "environment")
    for index, mesh in enumerate(scene.meshes):
        if mesh.fault:
            raise SceneError(f"meshes[{index}].{mesh.fault}")
    for index, item in enumerate(scene.objects):
        _check_object(scene, item, f"objects[{index}]")


def _check_object(scene: Scene, item: SceneObject, where: str) -> None:
    counts = {"mesh": scene.meshes, "material": scene.materials, "light": scene.lights}
    for name, parts in counts.items():
        index = getattr(item, name)
        if index is not None and not 0 <= index < len(parts):
            raise SceneError(f"{where}.{name} = {index}: the scene has {len(parts)}")
    if item.fault:
        raise SceneError(f"{where}.{item.fault}")
